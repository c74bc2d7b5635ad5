#include "engrave/mesh/files/three_mf_file.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <pugixml.hpp>
#include <string>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/io/number_text.h"
#include "engrave/io/zip_archive.h"
#include "engrave/mesh/files/unused_vertices.h"
#include "engrave/mesh/weld_vertices.h"

namespace intaglio::mesh {
namespace {

constexpr int kMaxNesting = 64;
constexpr std::uint64_t kMaxObjects = 1'000'000;  // after components are unfolded

/// model_from_object.
struct Place {
  Mat3 linear = Mat3::Identity();
  Vec3 offset = Vec3::Zero();

  Place Then(const Place& inner) const {
    return {linear * inner.linear, linear * inner.offset + offset};
  }
};

/// The name without its prefix.
std::string_view Local(std::string_view name) {
  const auto colon = name.rfind(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

pugi::xml_node Child(const pugi::xml_node& node, std::string_view name) {
  for (const pugi::xml_node child : node.children()) {
    if (Local(child.name()) == name) return child;
  }
  return {};
}

/// The attribute in the production namespace, whatever its prefix.
std::string_view PathOf(const pugi::xml_node& node) {
  for (const pugi::xml_attribute attribute : node.attributes()) {
    if (Local(attribute.name()) == "path") return attribute.value();
  }
  return {};
}

std::optional<double> UnitMm(std::string_view unit) {
  constexpr std::pair<std::string_view, double> kUnits[] = {
      {"", 1},        {"millimeter", 1}, {"micron", 0.001}, {"centimeter", 10},
      {"inch", 25.4}, {"foot", 304.8},   {"meter", 1000}};
  for (const auto& [name, mm] : kUnits) {
    if (name == unit) return mm;
  }
  return std::nullopt;
}

/// A number of an attribute, which may have spaces around it (XML Schema 2, whiteSpace of
/// double).
std::optional<double> NumberOf(std::string_view text) {
  constexpr const char* kSpaces = " \t\r\n";
  text.remove_prefix(std::min(text.find_first_not_of(kSpaces), text.size()));
  return io::ParseFinite(text.substr(0, text.find_last_not_of(kSpaces) + 1));
}

/// Twelve numbers; a point is a row to the left of the matrix. None when they are wrong.
std::optional<Place> PlaceOf(std::string_view text) {
  Place place;
  for (int row = 0; row < 4; ++row) {
    for (int column = 0; column < 3; ++column) {
      text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
      const std::string_view word = text.substr(0, text.find_first_of(" \t\r\n"));
      const auto number = io::ParseFinite(word);
      if (!number) return std::nullopt;
      text.remove_prefix(word.size());
      (row < 3 ? place.linear(column, row) : place.offset[column]) = *number;
    }
  }
  return place;
}

class ThreeMfReader {
 public:
  ThreeMfReader(const io::ZipArchive& archive, const ImportSource& source)
      : archive_(archive), source_(source) {}

  Result<ImportedMesh> Read() {
    root_path_ = INTAGLIO_TRY(RootPath());
    const Part* root = INTAGLIO_TRY(PartOf(root_path_));
    const auto unit = UnitMm(root->model.attribute("unit").value());
    if (!unit) {
      return source_.Refuse(
          ErrorCode::kUnsupported,
          fmt::format("its unit {:.40?} is none of 3MF; export it again",
                      root->model.attribute("unit").value()));
    }
    for (const pugi::xml_node item : Child(root->model, "build").children()) {
      if (Local(item.name()) != "item") continue;
      const bool wanted = source_.options.objects.empty();
      if (wanted && !item.attribute("printable").as_bool(true)) NoteUnprintable(item);
      INTAGLIO_TRY(AddReference(item, root_path_, Place{}, wanted, 0));
    }
    for (const std::string& asked : source_.options.objects) {
      if (std::ranges::find(names_, asked) == names_.end())
        return source_.RefuseObject(asked, names_);
    }
    if (mesh_.triangles.empty()) return source_.RefuseEmptyModel();
    mesh_.vertices = welder_.TakePoints();
    if (root->model.attribute("unit")) mesh_.declared_unit_mm = *unit;
    for (Vec3& vertex : mesh_.vertices) {
      vertex *= *unit;
      if (!vertex.allFinite()) return Unreadable("a vertex is not finite in mm");
    }
    return std::move(mesh_);
  }

 private:
  struct Part {
    pugi::xml_document document;
    pugi::xml_node model;
    std::map<std::string, pugi::xml_node, std::less<>> objects;
  };

  tl::unexpected<Error> Unreadable(std::string_view why) const {
    return source_.RefuseAsUnreadable(why);
  }

  Result<std::string> RootPath() const {
    constexpr std::string_view kUsual = "3D/3dmodel.model";
    const auto relations = archive_.Read("_rels/.rels");
    pugi::xml_document document;
    if (relations && document.load_buffer(relations->data(), relations->size())) {
      for (const pugi::xml_node one : document.document_element().children()) {
        const std::string_view type = one.attribute("Type").value();
        if (type.ends_with("/3dmodel"))
          return std::string(one.attribute("Target").value());
      }
    }
    if (archive_.Contains(kUsual)) return std::string(kUsual);
    return Unreadable("the package names no 3D model");
  }

  Result<const Part*> PartOf(const std::string& path) {
    const auto known = parts_.find(path);
    if (known != parts_.end()) return known->second.get();
    const auto text = archive_.Read(path);
    if (!text) return Unreadable(text.error().message);
    auto part = std::make_unique<Part>();
    if (!part->document.load_buffer(text->data(), text->size()))
      return Unreadable(fmt::format("{:.80} is not XML", path));
    part->model = part->document.document_element();
    if (Local(part->model.name()) != "model")
      return Unreadable(fmt::format("{:.80} has no model", path));
    INTAGLIO_TRY(CheckExtensions(part->model));
    const Part* root = path == root_path_ ? nullptr : parts_.at(root_path_).get();
    if (root != nullptr && UnitMm(root->model.attribute("unit").value()) !=
                               UnitMm(part->model.attribute("unit").value())) {
      return source_.Refuse(ErrorCode::kUnsupported,
                            fmt::format("{:.80} has another unit than the model; export "
                                        "it again with one unit",
                                        path));
    }
    for (const pugi::xml_node object : Child(part->model, "resources").children()) {
      if (Local(object.name()) != "object") continue;
      const char* id = object.attribute("id").value();
      if (!part->objects.try_emplace(id, object).second) {
        return Unreadable(fmt::format(
            "{:.80} has two objects {:.40}; which of them is meant is not known", path,
            id));
      }
    }
    return parts_.emplace(path, std::move(part)).first->second.get();
  }

  /// Checks the prefixes in requiredextensions.
  Status CheckExtensions(const pugi::xml_node& model) const {
    constexpr std::string_view kRead[] = {"/production/2015/06", "/material/2015/02",
                                          "/trianglesets/2021/07"};
    std::string_view rest = model.attribute("requiredextensions").value();
    while (true) {
      rest.remove_prefix(std::min(rest.find_first_not_of(" \t\r\n"), rest.size()));
      if (rest.empty()) return {};
      const std::string prefix(rest.substr(0, rest.find_first_of(" \t\r\n")));
      rest.remove_prefix(prefix.size());
      const std::string_view space = model.attribute(("xmlns:" + prefix).c_str()).value();
      if (std::ranges::any_of(kRead, [&](auto known) { return space.ends_with(known); }))
        continue;
      return source_.Refuse(
          ErrorCode::kUnsupported,
          fmt::format("it requires the extension {:.40} ({:.120}) of 3MF, which is not "
                      "supported; export it as a plain mesh, or as stl",
                      prefix, space));
    }
  }

  /// An item or a component: the object that it refers to, in its place.
  Status AddReference(const pugi::xml_node& node, const std::string& path,
                      const Place& outer, bool wanted, int depth) {
    if (depth > kMaxNesting)
      return Unreadable(
          fmt::format("its components are nested more than {} deep", kMaxNesting));
    if (++object_count_ > kMaxObjects)
      return source_.Refuse(ErrorCode::kTooLarge,
                            "it has more than a million components; export it as stl");
    const std::string_view other = PathOf(node);
    const std::string part_path = other.empty() ? path : std::string(other);
    const Part* part = INTAGLIO_TRY(PartOf(part_path));
    const std::string_view id = node.attribute("objectid").value();
    const auto found = part->objects.find(id);
    if (found == part->objects.end())
      return Unreadable(fmt::format("{:.80} has no object {:.40}", part_path, id));
    const pugi::xml_attribute transform = node.attribute("transform");
    const auto inner = transform ? PlaceOf(transform.value()) : Place{};
    if (!inner)
      return Unreadable(
          fmt::format("the transform {:.60?} is not twelve numbers", transform.value()));
    return AddObject(found->second, part_path, outer.Then(*inner), wanted, depth);
  }

  Status AddObject(const pugi::xml_node& object, const std::string& path,
                   const Place& place, bool wanted, int depth) {
    const std::string_view type = object.attribute("type").value();
    if (type == "support" || type == "solidsupport") {
      mesh_.findings.Add(
          {.what = "object of type support",
           .where = "object " + std::string(object.attribute("id").value()),
           .remedy = "",
           .count = 1,
           .effect = Effect::kNothingSeen,
           .plural = "objects of type support"});
      return {};
    }
    const std::string name = object.attribute("name").value();
    if (!name.empty() && std::ranges::find(names_, name) == names_.end())
      names_.push_back(name);
    wanted = wanted || std::ranges::find(source_.options.objects, name) !=
                           source_.options.objects.end();
    if (wanted) AddUnread(object, {"mesh", "components", "metadatagroup"}, object);
    if (wanted && !Child(object, "mesh") && !Child(object, "components"))
      AddLost("object without a mesh", object);
    for (const pugi::xml_node child : object.children()) {
      const std::string_view kind = Local(child.name());
      if (kind == "mesh" && wanted) INTAGLIO_TRY(AddMesh(child, place));
      if (kind != "components") continue;
      for (const pugi::xml_node component : child.children()) {
        if (Local(component.name()) == "component")
          INTAGLIO_TRY(AddReference(component, path, place, wanted, depth + 1));
      }
    }
    return {};
  }

  /// Slicers write it of what they are to leave out.
  void NoteUnprintable(const pugi::xml_node& item) {
    mesh_.findings.Add(
        {.what = "item that is not printable",
         .where = fmt::format("object {:.40}", item.attribute("objectid").value()),
         .remedy = "remove it from the file, or choose the objects by name",
         .count = 1,
         .effect = Effect::kChanged,
         .plural = "items that are not printable"});
  }

  void AddLost(std::string what, const pugi::xml_node& object) {
    mesh_.findings.Add(
        {.what = std::move(what),
         .where = fmt::format("object {:.40}", object.attribute("id").value()),
         .remedy = "export it as a plain mesh, or as stl",
         .count = 1,
         .effect = Effect::kLost});
  }

  /// Elements of extensions that a file need not require, which may be part of the shape:
  /// lattices, displacements, operations between solids, levels of a function.
  void AddUnread(const pugi::xml_node& node, std::initializer_list<std::string_view> read,
                 const pugi::xml_node& object) {
    for (const pugi::xml_node child : node.children()) {
      const bool is_known = std::ranges::find(read, Local(child.name())) != read.end();
      if (child.type() == pugi::node_element && !is_known)
        AddLost(fmt::format("element {:.40}", child.name()), object);
    }
  }

  Status AddMesh(const pugi::xml_node& mesh, const Place& place) {
    if (Child(mesh, "beamlattice")) {
      return source_.Refuse(ErrorCode::kUnsupported,
                            "it has a beam lattice, which is not supported; export it as "
                            "a plain mesh, or as stl");
    }
    AddUnread(mesh, {"vertices", "triangles", "trianglesets"}, mesh.parent());
    AddUnread(Child(mesh, "vertices"), {"vertex"}, mesh.parent());
    AddUnread(Child(mesh, "triangles"), {"triangle"}, mesh.parent());
    PointList points;
    for (const pugi::xml_node vertex : Child(mesh, "vertices").children()) {
      if (Local(vertex.name()) != "vertex") continue;
      Vec3 p;
      for (int axis = 0; axis < 3; ++axis) {
        constexpr const char* kNames[] = {"x", "y", "z"};
        const char* text = vertex.attribute(kNames[axis]).value();
        const auto number = NumberOf(text);
        if (!number)
          return Unreadable(fmt::format("a vertex has {} = {:.40?}", kNames[axis], text));
        p[axis] = *number;
      }
      p = place.linear * p + place.offset;
      if (!p.allFinite()) return Unreadable("a vertex is not finite in its place");
      points.push_back(p);
    }
    std::vector<std::uint32_t> welded(points.size(), kUnset);
    const bool mirrors = place.linear.determinant() < 0;
    for (const pugi::xml_node triangle : Child(mesh, "triangles").children()) {
      if (Local(triangle.name()) != "triangle") continue;
      Triangle corners;
      constexpr const char* kNames[] = {"v1", "v2", "v3"};
      for (std::size_t c = 0; c < 3; ++c) {
        const auto index = NumberOf(triangle.attribute(kNames[c]).value());
        if (!index || *index < 0 || *index >= static_cast<double>(points.size()) ||
            std::floor(*index) != *index)
          return Unreadable(fmt::format("a triangle refers to vertex {:.20?} of {}",
                                        triangle.attribute(kNames[c]).value(),
                                        points.size()));
        const auto i = static_cast<std::size_t>(*index);
        if (welded[i] == kUnset) welded[i] = welder_.Add(points[i]);
        corners[c] = welded[i];
      }
      if (mirrors) std::swap(corners[1], corners[2]);
      mesh_.triangles.push_back(corners);
      if (mesh_.triangles.size() > source_.options.max_triangles)
        return source_.RefuseTriangleCount();
    }
    AddUnusedVertices(welded, mesh_.findings);
    return {};
  }

  const io::ZipArchive& archive_;
  const ImportSource& source_;
  std::string root_path_;
  std::map<std::string, std::unique_ptr<Part>> parts_;
  std::vector<std::string> names_;
  std::uint64_t object_count_ = 0;
  VertexWelder welder_;
  ImportedMesh mesh_;
};

Status CheckUnpackedSize(const io::ZipArchive& archive, std::uint64_t packed,
                         const ImportSource& source) {
  const std::uint64_t unpacked = archive.unpacked_size();
  if (unpacked <= source.options.max_file_bytes &&
      unpacked / source.options.max_unpacked_ratio <= packed) {
    return {};
  }
  return source.Refuse(
      ErrorCode::kTooLarge,
      fmt::format("its {} bytes unpack to {}, more than {} times as many or than the {} "
                  "allowed; reduce the mesh or raise the limit",
                  packed, unpacked, source.options.max_unpacked_ratio,
                  source.options.max_file_bytes));
}

}  // namespace

Result<ImportedMesh> ReadThreeMf(std::string_view archive, const ImportSource& source) {
  const auto opened = io::ZipArchive::Open(archive);
  if (!opened)
    return source.RefuseAsUnreadable("it is not a zip archive, or it is truncated");
  INTAGLIO_TRY(CheckUnpackedSize(*opened, archive.size(), source));
  return ThreeMfReader(*opened, source).Read();
}

}  // namespace intaglio::mesh
