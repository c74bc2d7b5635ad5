#pragma once

// A run of motion, sampled at the servo periods: row k of a tick with N periods is where
// the plan is k/N of the tick after the lamp sync. A knot on a whole tick is a row of its
// own, exactly.

#include <cstdint>
#include <deque>
#include <optional>
#include <span>

#include "engrave/core/geometry.h"
#include "engrave/motion/segments/segment.h"

namespace intaglio::drivers {

class RowCourse {
 public:
  /// From rest at `place` at `start_tick`. `tick_s`: of a tick, s, > 0.
  void Begin(std::uint32_t run, std::uint64_t start_tick, const Vec3& place_mm,
             double tick_s);
  void Append(std::span<const motion::Segment> segments);
  void End() { run_ = 0; }

  struct Place {
    Vec3 position_mm = Vec3::Zero();
    bool pulse = false;  ///< a knot marked for a pulse lies here
    bool ended = false;  ///< the run is at its end, at rest
  };
  /// Where the plan is `period` of `periods` after the sync of `tick`; times only grow.
  /// Nullopt: the segments end before, and the run does not.
  std::optional<Place> At(std::uint64_t tick, std::uint32_t period,
                          std::uint32_t periods);

  bool active() const { return run_ != 0; }
  std::uint32_t run() const { return run_; }
  std::uint64_t start_tick() const { return start_tick_; }
  std::uint64_t covered_through_tick() const {
    return start_tick_ + covered_subticks_ / motion::kSubticksPerTick;
  }
  std::size_t waiting() const { return segments_.size(); }

 private:
  std::uint32_t run_ = 0;
  std::uint64_t start_tick_ = 0;
  double tick_s_ = 0;
  std::uint64_t covered_subticks_ = 0;  // by all segments, since the start
  std::uint64_t from_subticks_ = 0;     // of the knot before the first segment
  motion::KnotState from_;
  bool from_pulse_ = false, from_end_ = false;
  std::deque<motion::Segment> segments_;
};

}  // namespace intaglio::drivers
