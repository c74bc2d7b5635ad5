#include "engrave/mesh/files/obj_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/io/byte_order_mark.h"
#include "engrave/io/number_text.h"
#include "engrave/mesh/files/polygon.h"
#include "engrave/mesh/files/unused_vertices.h"
#include "engrave/mesh/weld_vertices.h"

namespace intaglio::mesh {
namespace {

/// Statements without a face: nothing of a surface is lost with them.
constexpr std::array<std::string_view, 27> kWithoutFaces = {
    "vt",       "vn",     "vp",    "s",     "mg",         "mtllib",    "usemtl",
    "maplib",   "usemap", "bevel", "lod",   "shadow_obj", "trace_obj", "c_interp",
    "d_interp", "csh",    "ctech", "stech", "deg",        "bmat",      "step",
    "cstype",   "parm",   "end",   "con",   "usemat",     "matlib"};
/// Statements of what is seen and has no face; call names a file with more of the model.
constexpr std::array<std::string_view, 3> kLeftOut = {"p", "l", "call"};
constexpr std::array<std::string_view, 7> kFreeForms = {"curv", "curv2", "surf", "trim",
                                                        "hole", "scrv",  "sp"};

std::string_view NextToken(std::string_view& line) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t\r"), line.size()));
  const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
  line.remove_prefix(word.size());
  return word;
}

class ObjReader {
 public:
  explicit ObjReader(const ImportSource& source) : source_(source) {}

  Result<ImportedMesh> Read(std::string_view text) {
    text = io::WithoutByteOrderMark(text);
    // Lines of old computers end with a carriage return alone.
    const char end = text.find('\n') == text.npos ? '\r' : '\n';
    std::string joined;
    while (!text.empty()) {
      ++line_number_;
      std::string_view line = text.substr(0, text.find(end));
      text.remove_prefix(std::min(text.size(), line.size() + 1));
      while (line.ends_with('\r') || line.ends_with(' ')) line.remove_suffix(1);
      if (line.ends_with('\\')) {
        joined.append(line.substr(0, line.size() - 1)).append(" ");
        continue;
      }
      if (!joined.empty()) line = joined.append(line);
      INTAGLIO_TRY(TakeLine(line));
      joined.clear();
    }
    return Take();
  }

 private:
  tl::unexpected<Error> Refuse(std::string_view what) const {
    return source_.RefuseAsUnreadable(fmt::format("line {} {}", line_number_, what));
  }

  Status TakeLine(std::string_view line) {
    std::string_view rest = line.substr(0, line.find('#'));
    const std::string_view statement = NextToken(rest);
    if (statement.empty()) return {};
    if (statement == "v") return TakeVertex(rest);
    if (statement == "f" || statement == "fo") return TakeFace(rest);
    if (statement == "o" || statement == "g") {
      object_ = NextToken(rest);
      is_wanted_ = source_.options.objects.empty() || IsAskedFor(object_);
      return {};
    }
    if (std::ranges::find(kFreeForms, statement) != kFreeForms.end()) {
      return source_.Refuse(
          ErrorCode::kUnsupported,
          fmt::format("line {} has a free-form curve or surface ({}), which is not "
                      "supported; export it as polygons",
                      line_number_, statement));
    }
    if (std::ranges::find(kWithoutFaces, statement) != kWithoutFaces.end()) return {};
    if (std::ranges::find(kLeftOut, statement) != kLeftOut.end()) {
      AddLost(statement);
      return {};
    }
    return Refuse(fmt::format("is not a line of an OBJ: {:.60?}", line));
  }

  void AddLost(std::string_view statement) {
    mesh_.findings.Add({.what = std::string(statement),
                        .where = fmt::format("line {}", line_number_),
                        .remedy = "only faces are read",
                        .count = 1,
                        .effect = Effect::kLost});
  }

  bool IsAskedFor(std::string_view object) const {
    return std::ranges::find(source_.options.objects, object) !=
           source_.options.objects.end();
  }

  Status TakeVertex(std::string_view rest) {
    const std::string_view line = rest;
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis) {
      const auto number = io::ParseNumber<double>(NextToken(rest));
      if (!number) return Refuse(fmt::format("is not a vertex: {:.60?}", line));
      p[axis] = *number;
    }
    if (!p.allFinite()) {
      return source_.Refuse(ErrorCode::kInvalidValue,
                            fmt::format("line {} has a vertex at ({}, {}, {}), which is "
                                        "not finite; export the model again",
                                        line_number_, p.x(), p.y(), p.z()));
    }
    points_.push_back(p);
    welded_.push_back(kUnset);
    return {};
  }

  Status TakeFace(std::string_view rest) {
    corners_.clear();
    places_.clear();
    for (std::string_view word = NextToken(rest); !word.empty(); word = NextToken(rest)) {
      const std::string_view digits = word.substr(0, word.find('/'));
      long long index = 0;
      const auto [end, failure] =
          std::from_chars(digits.data(), digits.data() + digits.size(), index);
      const auto count = static_cast<long long>(points_.size());
      if (failure != std::errc() || end != digits.data() + digits.size())
        return Refuse(fmt::format("has a corner {:.20?}", word));
      if (index < 0) index += count + 1;
      if (index < 1 || index > count) {
        return Refuse(fmt::format("refers to vertex {} of {}", digits, count));
      }
      corners_.push_back(static_cast<std::size_t>(index - 1));
      places_.push_back(points_[corners_.back()]);
      if (corners_.size() > source_.options.max_triangles + 2)
        return source_.RefuseTriangleCount();
    }
    if (corners_.size() < 3) {
      AddLost("f of fewer than three corners");
      return {};
    }
    if (!object_.empty() && std::ranges::find(names_, object_) == names_.end())
      names_.emplace_back(object_);
    return is_wanted_ ? AddPolygon() : Status();
  }

  Status AddPolygon() {
    const auto triangles = TriangulatePolygon(places_);
    if (!triangles) {
      return source_.Refuse(
          ErrorCode::kUnreadable,
          fmt::format("the polygon of line {} crosses itself, so that it has no one "
                      "surface; export it as triangles",
                      line_number_));
    }
    if (mesh_.triangles.size() + triangles->size() > source_.options.max_triangles)
      return source_.RefuseTriangleCount();
    for (const auto& triangle : *triangles) {
      Triangle welded;
      for (std::size_t c = 0; c < 3; ++c) {
        std::uint32_t& index = welded_[corners_[triangle[c]]];
        if (index == kUnset) index = welder_.Add(places_[triangle[c]]);
        welded[c] = index;
      }
      mesh_.triangles.push_back(welded);
    }
    return {};
  }

  Result<ImportedMesh> Take() {
    for (const std::string& asked : source_.options.objects) {
      if (std::ranges::find(names_, asked) == names_.end())
        return source_.RefuseObject(asked, names_);
    }
    if (mesh_.triangles.empty()) return source_.RefuseEmptyModel();
    mesh_.vertices = welder_.TakePoints();
    if (source_.options.objects.empty()) AddUnusedVertices(welded_, mesh_.findings);
    return std::move(mesh_);
  }

  const ImportSource& source_;
  std::size_t line_number_ = 0;
  std::string object_;
  bool is_wanted_ = source_.options.objects.empty();
  std::vector<std::string> names_;
  PointList points_;
  std::vector<std::uint32_t> welded_;
  std::vector<std::size_t> corners_;  ///< of the face
  PointList places_;
  VertexWelder welder_;
  ImportedMesh mesh_;
};

}  // namespace

Result<ImportedMesh> ReadObj(std::string_view text, const ImportSource& source) {
  return ObjReader(source).Read(text);
}

}  // namespace intaglio::mesh
