#pragma once

// Motion that comes to rest at every point: the published method (Trochimczuk 2008 ch.
// 6.2) and the simplest one. A pulse exists only at a tick, so every step takes whole
// ticks; how it is driven is its profile's program (profiles.h). Frame machine, mm.

#include <cstdint>
#include <memory>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/motion/axis/limits.h"
#include "engrave/motion/axis/profile.h"
#include "engrave/motion/axis/program_options.h"
#include "engrave/motion/segments/segment.h"
#include "engrave/motion/step_program.h"

namespace intaglio::motion {

/// Streams: target in, the segments of that step out. Allocates nothing but the
/// growth of `out`. Not for use by two threads at once.
class StopAndGoPlanner {
 public:
  /// Starts at rest at `start_mm`. rate_hz > 0: the lamp's rate, 1 .. 50000.
  /// `options`: what the profile leaves open.
  StopAndGoPlanner(const Limits& limits, double rate_hz, Profile profile,
                   const Vec3& start_mm, const ProgramOptions& options = {});

  /// Adds the segments of the step to `target_mm`. Only the last one carries `point` and
  /// `pulse`. A step of no length takes one tick, as the next pulse cannot come sooner.
  void Append(const Vec3& target_mm, std::int32_t point, bool pulse,
              std::vector<Segment>& out);

  /// Adds the end of the program: one tick at rest. (A caller that still holds the last
  /// segment may set its program_end instead and save the tick.)
  void Finish(std::vector<Segment>& out);

  const Vec3& position_mm() const { return position_mm_; }
  /// Ticks of everything appended so far.
  std::uint64_t ticks() const { return ticks_; }

 private:
  std::unique_ptr<StepProgram> program_;
  Vec3 position_mm_;
  std::uint64_t ticks_ = 0;
};

}  // namespace intaglio::motion
