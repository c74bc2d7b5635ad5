#include "services/job/machine/zero_change.h"

#include <fmt/format.h>

#include "services/job/machine/block_origin.h"

namespace intaglio {
namespace {

constexpr double kSamePlace_mm = 1e-9;

std::string ToText(const Vec3& place_mm) {
  return fmt::format("{:.4f}, {:.4f}, {:.4f} mm", place_mm.x(), place_mm.y(),
                     place_mm.z());
}

}  // namespace

std::string ZeroChange(const JobSpec& job, const MachineSpec& begun,
                       const MachineSpec& now) {
  for (const std::uint32_t channel : job.laser().channels()) {
    const Vec3 then_mm = BlockOriginOf(begun, job, channel);
    const Vec3 now_mm = BlockOriginOf(now, job, channel);
    if ((now_mm - then_mm).norm() <= kSamePlace_mm) continue;
    return fmt::format(
        "the zero of channel {} with the lens of {} mm is at {} now, and the job was "
        "begun "
        "with {}",
        channel, job.lens().focal_length_mm(), ToText(now_mm), ToText(then_mm));
  }
  return "";
}

}  // namespace intaglio
