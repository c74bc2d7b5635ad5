#pragma once

// Whether an engraving makes the progress that its plan expects. A machine that holds
// back nearly every pulse (its tolerance is smaller than that of the profile, the sensor
// sees no cracks, a line is lost again and again) works for days without a fault: every
// loss by itself is repaired. This class compares what was made with what the plan makes
// in the same time.
//
// Time is that of the lamp's ticks in which the job works: armed, the lamp warm, waiting
// for no person. So a warm-up, a pause and a machine in lockstep that waits for its host
// do not count. The plan gives the tick of every point in an undisturbed pass; a speed
// override of p % counts p % of the ticks. So a slow plan (1 Hz, long ways between
// points) expects little and raises nothing.
//
//   expected = points that the plan makes in 80 % of the working ticks of the window
//   window   = at least 30 s, and as long as it takes to expect 10 points, or all that
//              are left
//   stalled  = fewer than 10 % of them were made; no longer from 20 % on
//
// Pure; used from one thread.

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "services/synchronizer/pulses/pulse_schedule.h"

namespace intaglio::synchronizer {

/// What disturbed an engraving; all counted from its beginning.
struct Disturbances {
  std::uint64_t out_of_position_count = 0;  ///< armed pulses that the stage held back
  std::uint64_t late_count = 0;             ///< points whose arm came too late
  std::uint64_t other_skips_count = 0;      ///< points not fired for another reason
  std::uint64_t missed_count = 0;           ///< pulses without a crack
  std::uint64_t line_loss_count = 0;        ///< of the laser line and the motion line
  std::uint64_t run_count = 0;              ///< begun from rest

  void Add(const PulseResult& result);
};

/// The engraving at one turn.
struct WorkSight {
  std::uint64_t tick = 0;  ///< newest of the lamp; 0: not known
  bool works = false;      ///< armed, the lamp is warm, no person is waited for
  std::uint32_t speed_percent = 100;
  std::uint64_t made_count = 0;      ///< points with a crack
  std::uint64_t ended_count = 0;     ///< points with any final outcome
  std::uint64_t left_out_count = 0;  ///< of these, by a person's choice
  Disturbances disturbances;
};

/// The plan's figure and the truth over one window.
struct Stall {
  double working_s = 0;
  std::uint64_t made_count = 0, expected_count = 0;
  Disturbances disturbances;  ///< in the window
};

class ProgressWatch {
 public:
  static constexpr double kWindowS = 30;
  static constexpr std::uint64_t kMinExpected = 10;

  explicit ProgressWatch(double rate_hz) : rate_hz_(rate_hz) {}

  /// The tick of each point in an undisturbed pass, ascending; nothing is watched before.
  void SetPlan(std::vector<std::uint32_t> point_ticks) {
    point_ticks_ = std::move(point_ticks);
  }
  /// Once a turn.
  void Update(const WorkSight& sight);
  /// Nothing while the job makes progress. It is renewed once in kWindowS / 3, so that a
  /// text made of it stays for a while.
  const std::optional<Stall>& stall() const { return stall_; }

 private:
  struct Sample {
    double working_ticks = 0, planned_ticks = 0;  // planned: by the speed override
    WorkSight sight;
  };
  std::uint64_t Expected(const Sample& from, const Sample& to) const;
  bool IsWindow(const Sample& from, const Sample& to) const;
  void Judge();

  double rate_hz_;
  std::vector<std::uint32_t> point_ticks_;
  Sample now_;
  bool began_ = false;
  std::deque<Sample> samples_;  // one a second of working time, the oldest first
  std::optional<Stall> stall_;
  double stalled_at_ticks_ = 0;
};

/// Why, and what to do. `tolerance_mismatch`: as ToleranceMismatch, or empty.
std::string TextOf(const Stall& stall, const std::string& tolerance_mismatch);

}  // namespace intaglio::synchronizer
