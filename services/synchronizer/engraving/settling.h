#pragma once

// What becomes of armed points after a halt: each gets its result by report, by what the
// controller remembers when reports were lost, or, after another power-up of it, as
// uncertain. The controller's memory is the truth, its pulse counter the check of it.
//
//   Begin / BeginTakenUp        status after the Disarm          schedule empty
//   ---------------------> kDisarming ----------------> kAsking ---------------> settled
//                              ^   | new session            |
//                              +---+<-----------------------+
//
// Guarantees: what was never sent is skipped; nothing is settled by memory before the
// controller has shown that nothing is armed; after a lost line its counter is compared
// with what is known before anything is armed again. A journal whose end is lost makes
// the next open points uncertain, as many as the counter has more.
//
// Used from one thread; nothing waits. No point is armed while this works.

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "services/drivers/interface/laser_controller.h"
#include "services/synchronizer/engraving/engraving_inputs.h"
#include "services/synchronizer/engraving/engraving_job.h"
#include "services/synchronizer/engraving/motion_feed.h"
#include "services/synchronizer/pulses/pulse_record.h"
#include "services/synchronizer/pulses/tick_windows.h"

namespace intaglio::synchronizer {

class Settling {
 public:
  /// How long it waits for the reports of what was armed, and for the stage to rest.
  static constexpr std::chrono::seconds kTimeout{2};

  /// All outlive this.
  Settling(drivers::LaserController& laser, MotionFeed& feed, TickWindows& ticks,
           PulseRecord& record)
      : laser_(laser), feed_(feed), ticks_(ticks), record_(record) {}

  /// Halts: disarms, brakes the stage, takes back what was not sent. `reason` is that of
  /// points that turn out not to have fired.
  void Begin(SkipReason reason, std::chrono::nanoseconds now);
  /// The controller is asked about the points that an earlier life armed, if it has not
  /// been switched off since; otherwise these points are uncertain.
  void BeginTakenUp(const EarlierWork& earlier);

  /// Once a turn while halted. `grant_known`: a grant of the job has been received;
  /// `no_run_yet`: by this life. Returns why a person has to check the block, when the
  /// controller's counter shows pulses that are not known.
  std::optional<std::string> Turn(std::chrono::nanoseconds now, bool grant_known,
                                  bool no_run_yet);
  /// Once a turn, always: notices the answer to the Disarm, however late.
  void TakeDisarmed();
  /// The answer to what it asked. Before the disarm is confirmed it means nothing.
  void Receive(const link::PastReport& report);
  /// A stage that moves for an earlier life is braked; in lockstep it would wait for
  /// ever.
  void AbortEarlierRun(const MotionView& motion, std::chrono::nanoseconds now);

  /// In this session of the line, a Disarm has not been confirmed. Sends it if the line
  /// did not take it before.
  bool AwaitsDisarm();
  /// The controller has confirmed that nothing is armed, and its line is up.
  bool disarmed() const { return laser_.up() && disarm_seen_; }
  /// No armed point is without its result.
  bool all_settled() const {
    return ticks_.schedule().empty() && !ticks_.awaits_places() && unmarked_count_ == 0;
  }
  bool is_late(std::chrono::nanoseconds now) const {
    return began_at_ && now - *began_at_ > kTimeout;
  }
  /// Points made that are known from the controller's memory, not from a report.
  std::uint64_t settled_by_memory_count() const { return settled_by_memory_count_; }

 private:
  bool RequestDisarm();
  std::optional<std::string> SettleByMemory(std::chrono::nanoseconds now,
                                            bool grant_known, bool no_run_yet);
  std::optional<std::string> CompareCounters(bool no_run_yet);
  void RequestPast(std::chrono::nanoseconds now);
  bool MarkNextPoints();
  void SettleAs(std::vector<PulseResult> points, formats::PointOutcome outcome);

  drivers::LaserController& laser_;
  MotionFeed& feed_;
  TickWindows& ticks_;
  PulseRecord& record_;

  SkipReason reason_ = SkipReason::kNone;
  std::optional<std::chrono::nanoseconds> began_at_;
  bool taken_up_ = false;
  std::uint64_t disarm_session_ = 0;  // that the newest Disarm was for
  bool disarm_sent_ = false;
  bool disarm_seen_ = false;
  std::uint32_t unmarked_count_ = 0;  // next open points that are still to be uncertain
  std::uint64_t uncertain_before_ = 0;
  std::uint64_t settled_by_memory_count_ = 0;
  std::chrono::nanoseconds next_past_{0}, next_abort_{0};
};

}  // namespace intaglio::synchronizer
