#include "engrave/mesh/files/triangle_welder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "engrave/core/try.h"

namespace intaglio::mesh {
namespace {

using Corner = CornerWelder::Corner;

/// Without a branch for each, so that its cost is negligible beside the welding.
bool AllFinite(std::span<const Corner> corners) {
  constexpr std::uint32_t kExponent = 0x7F80'0000;
  std::uint32_t not_finite = 0;
  for (const Corner& corner : corners) {
    for (const float coordinate : corner) {
      not_finite |= static_cast<std::uint32_t>(
          (std::bit_cast<std::uint32_t>(coordinate) & kExponent) == kExponent);
    }
  }
  return not_finite == 0;
}

}  // namespace

TriangleWelder::TriangleWelder(const ImportSource& source,
                               std::size_t expected_triangle_count)
    : source_(source), welder_(expected_triangle_count / 2 + 1024) {
  corners_.reserve(kBatch);
  triangles_.reserve(expected_triangle_count);
}

Status TriangleWelder::Flush() {
  if (triangles_.size() + corners_.size() / 3 > source_.options.max_triangles) {
    return source_.RefuseTriangleCount();
  }
  if (!AllFinite(corners_)) {
    const auto bad = std::find_if(
        corners_.begin(), corners_.end(),
        [](const Corner& corner) { return !AllFinite(std::span(&corner, 1)); });
    return source_.Refuse(
        ErrorCode::kInvalidValue,
        fmt::format(
            "a corner of triangle {} is at ({}, {}, {}), which is not finite; export the "
            "model again",
            triangles_.size() + static_cast<std::size_t>(bad - corners_.begin()) / 3,
            (*bad)[0], (*bad)[1], (*bad)[2]));
  }
  indices_.resize(corners_.size());
  welder_.Add(corners_, indices_);
  for (std::size_t i = 0; i < indices_.size(); i += 3) {
    triangles_.push_back({indices_[i], indices_[i + 1], indices_[i + 2]});
  }
  corners_.clear();
  return {};
}

Result<TriangleMesh> TriangleWelder::Take() {
  INTAGLIO_TRY(Flush());
  if (triangles_.empty()) return source_.RefuseEmptyModel();
  return TriangleMesh{welder_.TakePoints(), std::move(triangles_)};
}

}  // namespace intaglio::mesh
