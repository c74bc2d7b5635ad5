#include "services/synchronizer/path_check.h"

#include <fmt/format.h>

#include <array>
#include <string>

#include "engrave/core/check.h"
#include "engrave/core/counted.h"
#include "services/job/fields/channels.h"
#include "services/job/fields/shapes.h"

namespace intaglio::synchronizer {
namespace {

constexpr double kAllowedMm = 1e-3, kAllowedRad = 1e-5;

// The axes of the glass frame.
constexpr std::array<machine::Axis, 3> kGlassAxes = {{{"x"}, {"y"}, {"z"}}};

Box3 Wider(const Box3& box, const std::array<machine::Axis, 3>& axes) {
  Vec3 allowed = Vec3::Constant(kAllowedMm);
  for (std::size_t i = 0; i < 3; ++i) {
    if (axes[i].unit == machine::AxisUnit::kRad) {
      allowed[static_cast<int>(i)] = kAllowedRad;
    }
  }
  return {box.min_mm - allowed, box.max_mm + allowed};
}

struct Finding {
  std::size_t point = 0;
  std::string text;
};

class Findings {
 public:
  /// `axes`: what the coordinates are; `what`: why they are wrong.
  void Add(std::size_t point, const std::array<machine::Axis, 3>& axes, const char* what,
           const Vec3& at, const Box3& limit) {
    if (!IsFirst(point)) return;
    const bool linear =
        axes[0].unit == machine::AxisUnit::kMm && axes[1].unit == machine::AxisUnit::kMm;
    const auto text = [&](std::size_t i) {
      return fmt::format("{} {:.6g}{}", axes[i].name, at[static_cast<int>(i)],
                         linear ? "" : " " + std::string(axes[i].unit_name()));
    };
    first_.text = fmt::format(
        "point {} of the order {} {} {} {}{}, allowed are {:g} to {:g}, {:g} to {:g}, "
        "{:g} to {:g}",
        point, what, text(0), text(1), text(2), linear ? " mm" : "", limit.min_mm.x(),
        limit.max_mm.x(), limit.min_mm.y(), limit.max_mm.y(), limit.min_mm.z(),
        limit.max_mm.z());
  }
  void Add(std::size_t point, const Error& error) {
    if (!IsFirst(point)) return;
    first_.text =
        fmt::format("point {} of the order is out of reach: {}", point, error.message);
  }
  bool any() const { return count_ > 0; }
  tl::unexpected<Error> Refusal(std::size_t of_points) const {
    return Fail(ErrorCode::kOutsideBlock,
                fmt::format("{} of {} of the path cannot be engraved; {}: the job "
                            "is refused; submit it again",
                            count_, Counted(of_points, "point"), first_.text),
                std::to_string(first_.point));
  }

 private:
  bool IsFirst(std::size_t point) {
    if (++count_ > 1) return false;
    first_.point = point;
    return true;
  }

  std::size_t count_ = 0;
  Finding first_;
};

}  // namespace

std::vector<Box3> BlocksOfModels(const JobSpec& job) {
  std::vector<Box3> blocks;
  for (const Model& model : job.models()) {
    blocks.push_back({Vec3::Zero(), Vec3Of(BlockOf(job, model).size_mm())});
  }
  if (blocks.empty()) blocks.push_back({Vec3::Zero(), BlockSizeOf(job)});
  return blocks;
}

Result<PointList> CheckedAxes(const PointCloud& path, const std::vector<Box3>& blocks,
                              const std::vector<machine::AxesFromGlass>& frames,
                              const Box3& travel) {
  Require(!blocks.empty() && !frames.empty() && path.source.size() == path.size(),
          "a path of {} points with {} sources and {} blocks", path.size(),
          path.source.size(), blocks.size());
  const auto axes = frames.front().kinematics().axes();
  const Box3 reach = Wider(travel, axes);
  std::vector<Box3> allowed;
  for (const Box3& block : blocks) allowed.push_back(Wider(block, kGlassAxes));
  Findings findings;
  PointList axes_of_points;
  axes_of_points.reserve(path.size());
  Vec3 near = machine::BranchStart(travel);
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vec3& place_mm = path.points_mm[i];
    const std::size_t model = path.source[i] < blocks.size() ? path.source[i] : 0;
    // A coordinate that is no number is in no box.
    if (!allowed[model].Contains(place_mm)) {
      findings.Add(i, kGlassAxes, "is outside the block: it is at", place_mm,
                   blocks[model]);
      continue;
    }
    const auto at = frames[path.source[i] < frames.size() ? path.source[i] : 0].ToAxes(
        place_mm, near);
    if (!at) {
      findings.Add(i, at.error());
      continue;
    }
    if (!reach.Contains(*at)) {
      findings.Add(i, axes, "is outside the stage's travel: the stage would move to", *at,
                   travel);
    }
    near = *at;
    axes_of_points.push_back(near);
  }
  if (findings.any()) return findings.Refusal(path.size());
  return axes_of_points;
}

}  // namespace intaglio::synchronizer
