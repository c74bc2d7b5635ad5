#include "services/drivers/linuxcnc/row_course.h"

namespace intaglio::drivers {

using motion::kSubticksPerTick;

void RowCourse::Begin(std::uint32_t run, std::uint64_t start_tick, const Vec3& place_mm,
                      double tick_s) {
  run_ = run;
  start_tick_ = start_tick;
  tick_s_ = tick_s;
  covered_subticks_ = from_subticks_ = 0;
  from_ = {place_mm, Vec3::Zero()};
  from_pulse_ = from_end_ = false;
  segments_.clear();
}

void RowCourse::Append(std::span<const motion::Segment> segments) {
  for (const motion::Segment& segment : segments) {
    segments_.push_back(segment);
    covered_subticks_ += segment.duration_subticks;
  }
}

std::optional<RowCourse::Place> RowCourse::At(std::uint64_t tick, std::uint32_t period,
                                              std::uint32_t periods) {
  if (tick < start_tick_) return Place{from_.position_mm};
  // In 1/periods of a subtick: whole numbers, so that a knot is met exactly.
  const std::uint64_t at = ((tick - start_tick_) * periods + period) * kSubticksPerTick;
  const auto end_of = [&](const motion::Segment& segment) {
    return (from_subticks_ + segment.duration_subticks) * periods;
  };
  while (!segments_.empty() && end_of(segments_.front()) <= at) {
    const motion::Segment& done = segments_.front();
    from_ = done.end();
    from_pulse_ = done.pulse;
    from_end_ = done.program_end;
    from_subticks_ += done.duration_subticks;
    segments_.pop_front();
  }
  const bool on_knot = from_subticks_ * periods == at;
  if (on_knot || from_end_)
    return Place{from_.position_mm, on_knot && from_pulse_, from_end_};
  if (segments_.empty()) return std::nullopt;
  const double seconds = static_cast<double>(at - from_subticks_ * periods) /
                         (static_cast<double>(periods) * kSubticksPerTick) * tick_s_;
  const double duration_s = segments_.front().duration_subticks /
                            static_cast<double>(kSubticksPerTick) * tick_s_;
  return Place{motion::HermitePosition(from_, segments_.front(), seconds, duration_s)};
}

}  // namespace intaglio::drivers
