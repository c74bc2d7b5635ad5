#include "engrave/calibrate/cube_pattern.h"

#include <fmt/format.h>

namespace intaglio::calibrate {
namespace {

constexpr double kMinGapMm = 1;
// A share of the distance to the next column, seen from above.
constexpr double kSignShare = 0.4;

Status CheckOptions(const CubePatternOptions& options) {
  if (options.nodes < 3 || options.nodes > 41) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("a level of the cube has 3..41 marks a side, not {}", options.nodes));
  }
  if (options.levels < 2 || options.levels > 10) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("the cube has 2..10 levels, not {}", options.levels));
  }
  return {};
}

}  // namespace

// Level k is shifted by k gaps, where the pitch of a level has `levels` gaps.
Result<CubePattern> MakeCubePattern(const CubePatternOptions& options) {
  if (const Status status = CheckOptions(options); !status) {
    return tl::unexpected(status.error());
  }
  const Vec3 size_mm = options.box_mm.size_mm();
  const int gaps = options.nodes * options.levels - 1;
  const Vec2 gap_mm = size_mm.head<2>() / gaps;
  if (!(gap_mm.minCoeff() >= kMinGapMm) ||
      !(size_mm.z() >= kMinGapMm * (options.levels - 1))) {
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("{} levels of {} x {} marks have no room in {:.1f} x {:.1f} x "
                    "{:.1f} mm: they need {:.0f} mm in x and y and {:.0f} mm in "
                    "z; give fewer marks or a larger block",
                    options.levels, options.nodes, options.nodes, size_mm.x(),
                    size_mm.y(), size_mm.z(), kMinGapMm * gaps,
                    kMinGapMm * (options.levels - 1)));
  }
  CubePattern pattern;
  for (int level = 0; level < options.levels; ++level) {
    const double z_mm =
        options.box_mm.min_mm.z() + size_mm.z() * level / (options.levels - 1);
    for (int j = 0; j < options.nodes; ++j) {
      for (int i = 0; i < options.nodes; ++i) {
        pattern.marks_mm.emplace_back(
            options.box_mm.min_mm.x() + gap_mm.x() * (i * options.levels + level),
            options.box_mm.min_mm.y() + gap_mm.y() * (j * options.levels + level), z_mm);
      }
    }
  }
  const Vec3 first_mm = pattern.marks_mm.front();
  pattern.signs_mm = {first_mm + kSignShare * gap_mm.x() * Vec3::UnitX(),
                      first_mm + kSignShare * gap_mm.y() * Vec3::UnitY()};
  return pattern;
}

}  // namespace intaglio::calibrate
