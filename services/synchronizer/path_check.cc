#include "services/synchronizer/path_check.h"

#include <fmt/format.h>

#include <optional>
#include <string>

#include "engrave/core/check.h"
#include "services/job/channels.h"
#include "services/job/options.h"

namespace intaglio::synchronizer {
namespace {

constexpr double kAllowedMm = 1e-3;

Box3 Wider(const Box3& box) {
  const Vec3 allowed_mm = Vec3::Constant(kAllowedMm);
  return {box.min_mm - allowed_mm, box.max_mm + allowed_mm};
}

struct Finding {
  std::size_t point = 0;
  std::string text;
};

class Findings {
 public:
  void Add(std::size_t point, const char* what, const Vec3& place_mm, const Box3& limit) {
    if (++count_ > 1) return;
    first_ = {
        point,
        fmt::format("point {} of the order {} x {:.6g} y {:.6g} z {:.6g} mm, allowed "
                    "are {:g} to {:g}, {:g} to {:g}, {:g} to {:g}",
                    point, what, place_mm.x(), place_mm.y(), place_mm.z(),
                    limit.min_mm.x(), limit.max_mm.x(), limit.min_mm.y(),
                    limit.max_mm.y(), limit.min_mm.z(), limit.max_mm.z())};
  }
  std::size_t count() const { return count_; }
  const Finding& first() const { return first_; }

 private:
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

Status CheckPath(const PointCloud& path, const std::vector<Box3>& blocks,
                 const optics::MachineFromGlass& machine_from_glass, const Box3& travel) {
  Require(!blocks.empty() && path.source.size() == path.size(),
          "a path of {} points with {} sources and {} blocks", path.size(),
          path.source.size(), blocks.size());
  const Box3 reach = Wider(travel);
  std::vector<Box3> allowed;
  for (const Box3& block : blocks) allowed.push_back(Wider(block));
  Findings findings;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Vec3& place_mm = path.points_mm[i];
    const std::size_t model = path.source[i] < blocks.size() ? path.source[i] : 0;
    const Vec3 machine_mm = machine_from_glass.ToMachine(place_mm);
    // A coordinate that is no number is in no box.
    if (!allowed[model].Contains(place_mm)) {
      findings.Add(i, "is not in the block: it is at", place_mm, blocks[model]);
    } else if (!reach.Contains(machine_mm)) {
      findings.Add(i, "is out of the stage's travel: the stage would go to", machine_mm,
                   travel);
    }
  }
  if (findings.count() == 0) return {};
  return Fail(
      ErrorCode::kOutsideBlock,
      fmt::format("{} of {} points of the path cannot be engraved; {}: the job is "
                  "refused; submit it again",
                  findings.count(), path.size(), findings.first().text),
      std::to_string(findings.first().point));
}

}  // namespace intaglio::synchronizer
