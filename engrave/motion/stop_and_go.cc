#include "engrave/motion/stop_and_go.h"

#include "engrave/core/check.h"
#include "engrave/motion/profiles.h"

namespace intaglio::motion {

StopAndGoPlanner::StopAndGoPlanner(const Limits& limits, double rate_hz, Profile profile,
                                   const Vec3& start_mm, const ProgramOptions& options)
    : program_(MakeStepProgram(profile, limits, rate_hz, options)),
      position_mm_(start_mm) {}

void StopAndGoPlanner::Append(const Vec3& target_mm, std::int32_t point, bool pulse,
                              std::vector<Segment>& out) {
  Require(target_mm.allFinite(), "target_mm ({}, {}, {}) is not finite", target_mm.x(),
          target_mm.y(), target_mm.z());
  if ((target_mm - position_mm_).isZero(0.0)) {
    Segment hold;
    hold.duration_subticks = kSubticksPerTick;
    out.push_back(hold);
    ++ticks_;
  } else {
    ticks_ += program_->Append(position_mm_, target_mm, out);
  }
  Segment& last = out.back();
  EndAtRest(target_mm, last);
  last.point = point;
  last.pulse = pulse;
  position_mm_ = target_mm;
}

void StopAndGoPlanner::Finish(std::vector<Segment>& out) {
  Append(position_mm_, -1, false, out);
  out.back().program_end = true;
}

}  // namespace intaglio::motion
