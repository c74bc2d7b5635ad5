#include "services/client/shop/work_left.h"

#include <algorithm>
#include <cmath>

#include "services/platform/host/times/utc_time.h"

namespace intaglio::client {
namespace {

constexpr double kPaceIsKnown = 0.05;

}  // namespace

WorkLeft WorkLeftOf(double share, double elapsed_s, double expected_s) {
  if (share <= 0 || share >= 1 || elapsed_s <= 0) return {};
  const bool by_plan = share < kPaceIsKnown && expected_s > 0;
  return {share, (1 - share) * (by_plan ? expected_s : elapsed_s / share)};
}

double EngravingSeconds(const JobView& job, double machine_speed) {
  if (machine_speed <= 0 || job.rate_hz <= 0 || job.speed_percent == 0) return 0;
  // Above 100 % the machine's limits and the lamp decide how much is gained.
  return static_cast<double>(job.estimate_ticks) / job.rate_hz / machine_speed * 100 /
         std::min(job.speed_percent, 100u);
}

WorkLeft WorkLeftOf(const JobView& job) {
  const JobView::Progress* stage = StageAtWork(job);
  if (job.ended() || job.state == intaglio_JOB_PAUSED || stage == nullptr ||
      stage->total_count == 0)
    return {};
  const bool engraves = stage->stage == intaglio_STAGE_ENGRAVE;
  const double share =
      static_cast<double>(stage->done_count) / static_cast<double>(stage->total_count);
  return WorkLeftOf(share, stage->elapsed_s, engraves ? EngravingSeconds(job) : 0);
}

std::string EndUtc(std::chrono::system_clock::time_point now, double left_s) {
  return host::UtcText(now + std::chrono::milliseconds(std::llround(1000 * left_s)));
}

}  // namespace intaglio::client
