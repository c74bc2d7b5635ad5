#include "services/virtual_engraver/positioner.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <vector>

// Each carriage is a rigid motion of the laboratory: the head's takes the beam along, the
// block's takes the block along. The focus in the frame of the block is the inverse of
// the block's motion, applied to the focus in the laboratory.

namespace intaglio::virtual_engraver {
namespace {

using Motion = Eigen::Isometry3d;

std::vector<std::string> SplitAtCommas(const std::string& text) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == ',') {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

tl::unexpected<Error> Wrong(const std::string& part, const std::string& remedy) {
  return Fail(ErrorCode::kInvalidValue, "'" + part + "': " + remedy, part);
}

Result<Guide> ParseGuide(const std::string& part) {
  Guide guide;
  guide.backwards = part.starts_with('-');
  const std::string carried = part.substr(guide.backwards ? 1 : 0);
  if (carried != "head" && carried != "block") {
    return Wrong(part, "a guide is head, -head, block or -block");
  }
  guide.carries_block = carried == "block";
  return guide;
}

Result<double> ParseLength(const std::string& part) {
  double length_mm = 0;
  const char* end = part.data() + part.size();
  const auto parsed = std::from_chars(part.data(), end, length_mm);
  if (parsed.ec != std::errc() || parsed.ptr != end ||
      !(length_mm > 0 && length_mm <= 1e5)) {
    return Wrong(part, "a length is above 0 and at most 100000 mm");
  }
  return length_mm;
}

Vec3 Travelled(const Guide& guide, int axis, double coordinate) {
  return (guide.backwards ? -coordinate : coordinate) * Vec3::Unit(axis);
}

Motion Turn(double angle_rad, const Vec3& pivot_mm) {
  return Eigen::Translation3d(pivot_mm) * Eigen::AngleAxisd(angle_rad, Vec3::UnitZ()) *
         Eigen::Translation3d(-pivot_mm);
}

}  // namespace

Result<PositionerOptions> ParsePositioner(const std::string& text) {
  PositionerOptions options;
  if (text.empty()) return options;
  const std::vector<std::string> parts = SplitAtCommas(text);
  options.has_arm = parts.front() == "arm";
  if (parts.size() != (options.has_arm ? 4 : 3)) {
    return Wrong(text, "give three guides, or arm, two lengths and a guide");
  }
  for (int axis = options.has_arm ? 2 : 0; axis < 3; ++axis) {
    const auto at = static_cast<std::size_t>(axis);
    const auto guide = ParseGuide(parts[options.has_arm ? at + 1 : at]);
    if (!guide) return tl::unexpected(guide.error());
    options.guides[at] = *guide;
  }
  if (!options.has_arm) return options;
  const auto distance = ParseLength(parts[1]), length = ParseLength(parts[2]);
  if (!distance) return tl::unexpected(distance.error());
  if (!length) return tl::unexpected(length.error());
  options.pivot_distance_mm = *distance;
  options.arm_length_mm = *length;
  return options;
}

Vec3 FocusAt(const PositionerOptions& positioner, const Vec3& axes) {
  Vec3 focus_mm = Vec3::Zero();
  Motion of_block = Motion::Identity();
  const auto guide = [&](int axis) {
    const Guide& g = positioner.guides[static_cast<std::size_t>(axis)];
    const Vec3 travelled_mm = Travelled(g, axis, axes[axis]);
    if (g.carries_block) {
      of_block.pretranslate(travelled_mm);
    } else {
      focus_mm += travelled_mm;
    }
  };
  if (positioner.has_arm) {
    const Vec3 pivot_mm(0, positioner.pivot_distance_mm, 0);
    const Vec3 at_zero_mm = pivot_mm - Vec3(0, positioner.arm_length_mm, 0);
    focus_mm = Turn(axes[0], pivot_mm) * at_zero_mm;
    of_block = Turn(axes[1], Vec3::Zero());
  } else {
    guide(0);
    guide(1);
  }
  guide(2);
  return of_block.inverse(Eigen::Isometry) * focus_mm;
}

Vec3 FocusPerAxisUnitMm(const PositionerOptions& positioner, const Box3& block_mm) {
  if (!positioner.has_arm) return Vec3::Ones();
  double farthest_mm = 0;
  for (const double x_mm : {block_mm.min_mm.x(), block_mm.max_mm.x()}) {
    for (const double y_mm : {block_mm.min_mm.y(), block_mm.max_mm.y()}) {
      farthest_mm = std::max(farthest_mm, Vec2(x_mm, y_mm).norm());
    }
  }
  return {positioner.arm_length_mm, farthest_mm, 1};
}

}  // namespace intaglio::virtual_engraver
