#include "engrave/mesh/files/ply_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/io/ply_header.h"
#include "engrave/io/ply_values.h"
#include "engrave/mesh/files/ply_check.h"
#include "engrave/mesh/files/polygon.h"
#include "engrave/mesh/files/unused_vertices.h"
#include "engrave/mesh/weld_vertices.h"

namespace intaglio::mesh {
namespace {

/// A list of the indices of vertices: the one with their name, else the first of whole
/// numbers. The size of the properties: there is none.
std::size_t IndexList(const io::PlyElement& element) {
  std::size_t first = element.properties.size();
  for (std::size_t i = 0; i < element.properties.size(); ++i) {
    const io::PlyProperty& property = element.properties[i];
    if (!property.is_list || property.type == io::PlyType::kFloat ||
        property.type == io::PlyType::kDouble) {
      continue;
    }
    if (property.name == "vertex_indices" || property.name == "vertex_index") return i;
    first = std::min(first, i);
  }
  return first;
}

/// What has no place: nothing of a surface is lost with it.
bool IsOfAppearance(std::string_view element) {
  return element == "material" || element == "camera" || element == "light";
}

/// "x", if the vertices have no such number; empty: they have all three.
std::string_view MissingCoordinate(const io::PlyElement& vertices) {
  for (const std::string_view name : {"x", "y", "z"}) {
    const bool has =
        std::ranges::any_of(vertices.properties, [name](const io::PlyProperty& property) {
          return property.name == name && !property.is_list;
        });
    if (!has) return name;
  }
  return {};
}

class PlyReader {
 public:
  PlyReader(const ImportSource& source, const io::PlyHeader& header,
            std::string_view values)
      : source_(source),
        header_(header),
        values_(io::PlyValuesOf(header.encoding, values)) {}

  Result<ImportedMesh> Read() {
    for (const io::PlyElement& element : header_.elements) {
      for (std::uint64_t row = 0; row < element.count; ++row) {
        INTAGLIO_TRY(ReadRow(element, row));
      }
    }
    if (values_->has_more()) {
      return source_.RefuseAsUnreadable(
          "it goes on behind its last row: its header declares fewer rows than it has, "
          "or its rows have more values than properties");
    }
    if (mesh_.triangles.empty()) return source_.RefuseEmptyModel();
    mesh_.vertices = welder_.TakePoints();
    AddUnusedVertices(welded_, mesh_.findings);
    AddLost("face of fewer than three corners", small_face_count_);
    for (const io::PlyElement& element : header_.elements) {
      const bool is_read = io::HoldsFaces(element) || IsOfAppearance(element.name);
      if (!is_read && element.name != "vertex")
        AddLost("element " + element.name, element.count);
    }
    return std::move(mesh_);
  }

 private:
  tl::unexpected<Error> CutOff(const io::PlyElement& element, std::uint64_t row) const {
    return source_.RefuseAsUnreadable(
        fmt::format("it ends, or is damaged, in row {} of the {} of element {:.30}",
                    row + 1, element.count, element.name));
  }

  void AddLost(const std::string& what, std::uint64_t count) {
    if (count == 0) return;
    mesh_.findings.Add({.what = what,
                        .where = "",
                        .remedy = "only faces are read",
                        .count = count,
                        .effect = Effect::kLost});
  }

  Status ReadRow(const io::PlyElement& element, std::uint64_t row) {
    const std::size_t indices =
        io::HoldsFaces(element) ? IndexList(element) : element.properties.size();
    Vec3 place = Vec3::Zero();
    for (std::size_t i = 0; i < element.properties.size(); ++i) {
      const io::PlyProperty& property = element.properties[i];
      double count = 1;
      if (property.is_list) {
        const auto size = values_->Next(property.count_type);
        if (!size || *size < 0) return CutOff(element, row);
        count = *size;
        if (i == indices) corners_.clear();
      }
      for (double k = 0; k < count; ++k) {
        const auto value = values_->Next(property.type);
        if (!value) return CutOff(element, row);
        if (i == indices) corners_.push_back(static_cast<std::int64_t>(*value));
        if (property.is_list || property.name.size() != 1) continue;
        const int axis = property.name[0] - 'x';
        if (axis >= 0 && axis < 3) place[axis] = *value;
      }
    }
    if (element.name == "vertex") return AddVertex(place, row);
    if (indices == element.properties.size()) return {};
    return element.name == "tristrips" ? AddStrips(row) : AddFace(row);
  }

  Status AddVertex(const Vec3& place, std::uint64_t row) {
    if (!place.allFinite()) {
      return source_.Refuse(ErrorCode::kInvalidValue,
                            fmt::format("vertex {} is at ({}, {}, {}), which is not "
                                        "finite; export the model again",
                                        row, place.x(), place.y(), place.z()));
    }
    points_.push_back(place);
    welded_.push_back(kUnset);
    return {};
  }

  Status CheckCorner(std::int64_t corner, std::uint64_t row) const {
    if (corner >= 0 && corner < std::ssize(points_)) return {};
    return source_.Refuse(ErrorCode::kUnreadable,
                          fmt::format("face {} refers to vertex {} of {}; the file is "
                                      "damaged, export it again",
                                      row, corner, points_.size()));
  }

  Status AddTriangle(std::int64_t a, std::int64_t b, std::int64_t c) {
    if (mesh_.triangles.size() >= source_.options.max_triangles)
      return source_.RefuseTriangleCount();
    Triangle welded;
    std::size_t at = 0;
    for (const std::int64_t corner : {a, b, c}) {
      std::uint32_t& index = welded_[static_cast<std::size_t>(corner)];
      if (index == kUnset) index = welder_.Add(points_[static_cast<std::size_t>(corner)]);
      welded[at++] = index;
    }
    mesh_.triangles.push_back(welded);
    return {};
  }

  Status AddFace(std::uint64_t row) {
    places_.clear();
    for (const std::int64_t corner : corners_) {
      INTAGLIO_TRY(CheckCorner(corner, row));
      places_.push_back(points_[static_cast<std::size_t>(corner)]);
    }
    if (corners_.size() < 3) {
      ++small_face_count_;
      return {};
    }
    const auto triangles = TriangulatePolygon(places_);
    if (!triangles) {
      return source_.Refuse(
          ErrorCode::kUnreadable,
          fmt::format("the polygon of face {} crosses itself, so that it has no one "
                      "surface; export it as triangles",
                      row));
    }
    for (const auto& [a, b, c] : *triangles)
      INTAGLIO_TRY(AddTriangle(corners_[a], corners_[b], corners_[c]));
    return {};
  }

  /// Every second triangle is the other way round. Those with one corner twice only turn
  /// the strip.
  Status AddStrips(std::uint64_t row) {
    std::size_t begin = 0;
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      if (corners_[i] < 0) {
        begin = i + 1;
        continue;
      }
      INTAGLIO_TRY(CheckCorner(corners_[i], row));
      if (i < begin + 2) continue;
      std::int64_t a = corners_[i - 2], b = corners_[i - 1];
      const std::int64_t c = corners_[i];
      if (a == b || b == c || a == c) continue;
      if ((i - begin) % 2 == 1) std::swap(a, b);
      INTAGLIO_TRY(AddTriangle(a, b, c));
    }
    return {};
  }

  const ImportSource& source_;
  const io::PlyHeader& header_;
  std::unique_ptr<io::PlyValues> values_;
  PointList points_;
  std::vector<std::uint32_t> welded_;
  std::vector<std::int64_t> corners_;  ///< of the row
  PointList places_;
  std::uint64_t small_face_count_ = 0;
  VertexWelder welder_;
  ImportedMesh mesh_;
};

}  // namespace

Result<ImportedMesh> ReadPly(std::string_view file, const ImportSource& source) {
  const auto header = io::ParsePlyHeader(file.substr(0, kMaxPlyHeaderSize));
  if (!header) return source.Refuse(ErrorCode::kUnreadable, header.error().message);
  const bool has_vertices = std::ranges::any_of(
      header->elements,
      [](const io::PlyElement& element) { return element.name == "vertex"; });
  if (!has_vertices) {
    return source.RefuseAsUnreadable("its header declares no element vertex");
  }
  for (const io::PlyElement& element : header->elements) {
    const std::string_view missing =
        element.name == "vertex" ? MissingCoordinate(element) : std::string_view();
    if (!missing.empty()) {
      return source.RefuseAsUnreadable(
          fmt::format("its vertices have no property {}", missing));
    }
    if (element.name != "range_grid" || element.count == 0) continue;
    return source.Refuse(ErrorCode::kUnsupported,
                         "its element range_grid, a grid of ranges of a scanner, is not "
                         "supported; export it with element face");
  }
  return PlyReader(source, *header, file.substr(header->size)).Read();
}

}  // namespace intaglio::mesh
