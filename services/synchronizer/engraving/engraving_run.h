#pragma once

// The state of one run: a pass over the open points from rest to rest, with the same
// shutters open all the time.
//
//   idle --Begin--> sent to the stage --stage executes it--> firing --all settled, at
//   rest-->
//    ^                |        |                               | idle |                |
//    +--- start tick passed: late ---+--- Turn: a HaltReason
//    +----------------+----------------------------------------+
//
// Guarantees: a tick is armed only when the motion for it is in the stage's controller,
// and while the newest status shows exactly the shutters of the run open; whether the
// rest of the permission chain holds is asked by Engraving in the same turn, before. A
// point that was passed by, too many pulses without a crack, a dropped run, a change of
// pace of the stage's clock and a failing journal end the run.
//
// Used from one thread; nothing waits.

#include <cstdint>
#include <optional>

#include "services/synchronizer/engraving/engraving_inputs.h"
#include "services/synchronizer/engraving/engraving_job.h"
#include "services/synchronizer/engraving/halt_reason.h"
#include "services/synchronizer/engraving/motion_feed.h"
#include "services/synchronizer/engraving/shutters.h"
#include "services/synchronizer/pulses/open_points.h"
#include "services/synchronizer/pulses/pulse_record.h"
#include "services/synchronizer/pulses/tick_horizon.h"
#include "services/synchronizer/pulses/tick_windows.h"

namespace intaglio::synchronizer {

class EngravingRun {
 public:
  /// Finished runs in a row that made nothing before the open points are given up: each
  /// is one more pass over points that were skipped.
  static constexpr int kMaxIdleRuns = 2;

  /// All outlive this.
  EngravingRun(const EngravingJob& job, MotionFeed& feed, TickHorizon& horizon,
               TickWindows& ticks, PulseRecord& record, Shutters& shutters);

  /// The shutters of the next run. Where nothing can be fired, any will do.
  ChannelMask NextMask();
  /// After NextMask, with the stage at rest and the shutters commanded.
  void Begin(const EngravingInputs& inputs);
  /// Once a turn, always: what was fired has its result when the clock of the stage shows
  /// that it was at its place.
  void PlacePulses(const EngravingInputs& inputs);
  /// Plans, arms and sends what this turn has time for. A reason when the run has to be
  /// halted.
  std::optional<HaltReason> Turn(const EngravingInputs& inputs);
  /// What became of a point.
  void Note(const PulseResult& result);

  /// The stage's controller executes this run, not an older one.
  bool is_executed(const MotionView& motion) const { return motion.run == record_.run(); }
  /// All is made and sent, and the stage is at rest.
  bool is_finished(const EngravingInputs& inputs) const;
  void Finish();

  /// Runs begun by this life.
  std::uint32_t count() const { return count_; }
  /// As many finished runs in a row made nothing as are worth trying.
  bool is_fruitless() const { return idle_runs_ >= kMaxIdleRuns; }
  void ForgetFruitless() { idle_runs_ = 0; }
  /// Tick of the first point that was passed by; 0: none was.
  std::uint64_t passed_by_tick() const { return passed_by_tick_; }
  /// Speed overrides that motion was planned with, and how often they changed.
  std::uint32_t min_speed_percent() const { return min_speed_percent_; }
  std::uint32_t max_speed_percent() const { return max_speed_percent_; }
  std::uint32_t speed_changes() const { return speed_changes_; }

 private:
  std::optional<HaltReason> WhyHalt(const EngravingInputs& inputs);
  HaltReason WhySkipped();
  void TakeSpeed(const EngravingInputs& inputs);
  void FeedMotion(const EngravingInputs& inputs);
  std::optional<HaltReason> DecideTicks(const EngravingInputs& inputs);
  std::optional<HaltReason> CheckStart(const EngravingInputs& inputs);
  std::uint64_t ArmLimit(const EngravingInputs& inputs);
  std::optional<HaltReason> ArmThrough(std::uint64_t last);

  const EngravingJob& job_;
  MotionFeed& feed_;
  TickHorizon& horizon_;
  TickWindows& ticks_;
  PulseRecord& record_;
  Shutters& shutters_;
  OpenPoints open_points_;

  std::uint32_t count_ = 0;
  std::optional<SkipReason> passed_by_;  // a point of this run was reached and not fired
  std::uint64_t passed_by_tick_ = 0;
  std::uint32_t passed_by_point_ = 0;      // of what the laser reported as skipped
  std::uint32_t missed_in_a_row_ = 0;      // in this run
  std::uint64_t fired_points_before_ = 0;  // this run
  int idle_runs_ = 0;                      // finished in a row that made nothing
  int fruitless_halts_ = 0;                // over skipped points, in a row, and none made
  int late_starts_ = 0;                    // in a row
  std::uint32_t clock_steps_ = 0;          // of the stage's clock, when the run began
  std::uint32_t speed_percent_ = 100;      // of the motion planned last
  std::uint32_t min_speed_percent_ = 100, max_speed_percent_ = 100;
  std::uint32_t speed_changes_ = 0;
};

}  // namespace intaglio::synchronizer
