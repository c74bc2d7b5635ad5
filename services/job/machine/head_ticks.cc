#include "services/job/machine/head_ticks.h"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace intaglio {
namespace {

// Arcs as chords: far below a step of the outputs.
constexpr double kChordToleranceMm = 1e-4;
constexpr double kDefaultAheadMs = 40;
// From one status of a head's controller to the next, with what it has seen meanwhile.
constexpr double kHeadStatusSeconds = 0.02;

}  // namespace

bool FollowsWeb(const ScanHead& head) {
  return head.encoder_count_um() > 0 && (!head.has_follow_web() || head.follow_web());
}

double AheadSeconds(const ScanHead& head) {
  return 1e-3 * (head.has_ahead_ms() ? head.ahead_ms() : kDefaultAheadMs);
}

double EyeAheadSeconds(const ScanHead& head) {
  return std::max(AheadSeconds(head), kHeadStatusSeconds + AheadSeconds(head) / 2);
}

galvo::MarkTickOptions TickOptionsOf(const ScanHead& head, const mark::Pen& pen,
                                     double rate_hz) {
  galvo::MarkTickOptions options;
  options.rate_hz = rate_hz;
  options.mark_mm_s = pen.speed_mm_s;
  options.jump_mm_s = head.jump_mm_s();
  options.run_in_s = head.has_run_in_s() ? head.run_in_s() : kDefaultRunInSeconds;
  options.lag_s = head.servo_lag_s();
  options.lead_servo = head.has_lead_servo() ? head.lead_servo() : head.servo_lag_s() > 0;
  if (options.lead_servo) return options;
  options.laser_on_delay_s = head.laser_on_delay_s();
  options.laser_off_delay_s = head.laser_off_delay_s();
  options.jump_delay_s = head.jump_delay_s();
  options.mark_delay_s = head.mark_delay_s();
  options.polygon_delay_s = head.polygon_delay_s();
  return options;
}

std::vector<galvo::MarkStroke> StrokesOf(const mark::Mark& mark, const mark::Pen& pen) {
  galvo::MarkStroke stroke{mark::PlacesOf(mark, kChordToleranceMm), mark.closed};
  for (Vec2& place : stroke.points_mm) place.x() -= mark.web_mm;
  std::vector<galvo::MarkStroke> passes;
  passes.reserve(pen.pass_count);
  for (std::uint32_t i = 1; i < pen.pass_count; ++i) passes.push_back(stroke);
  passes.push_back(std::move(stroke));
  return passes;
}

}  // namespace intaglio
