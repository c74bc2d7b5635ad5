#pragma once

// Plans the motion of one run and streams it ahead to the motion bridge, within the
// bridge's credit. Frame machine, mm; ticks of the lamp sync.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engrave/motion/planner.h"
#include "services/platform/bus/flow.h"
#include "services/synchronizer/pulses/motion_clock.h"
#include "services/synchronizer/pulses/pulse_schedule.h"

namespace intaglio::synchronizer {

class MotionFeed {
 public:
  struct Target {
    std::uint32_t point = 0;
    Vec3 position_mm = Vec3::Zero();  ///< machine frame
  };
  /// The next point of the run; nullopt when there are no more.
  using NextTarget = std::function<std::optional<Target>()>;

  /// Hands one batch to the bridge; the sample is valid during the call.
  using BatchWriter = std::function<Status(const intaglio_MotionSegmentBatch&)>;
  /// What the bridge has granted for a stream.
  using GrantLookup = std::function<bus::CreditBook::Grant(const std::string& stream)>;

  MotionFeed(BatchWriter write, GrantLookup grant_of);

  /// A run from rest at `start_mm`, beginning at `start_tick`. The limits of `plan` are
  /// those of the job, `machine` has those that no speed override exceeds. `clock` is
  /// that of a controller with a clock of its own, read with every batch; null: it has
  /// none.
  void Begin(const std::string& job_uid, std::uint32_t run, std::uint64_t start_tick,
             const Vec3& start_mm, const motion::PlanOptions& plan,
             const motion::Limits& machine, const MotionClock* clock = nullptr);
  /// Runs begun from now on need the stage that carries the block at this place of its
  /// axes; 0: the machine has none.
  void SetBlockPlace(const Vec2& place_mm) { block_mm_ = place_mm; }
  /// Plans towards `horizon_tick`, one window of the planner a call, and sends what the
  /// bridge has room for; every pulse planned is added to the schedule.
  void Advance(std::uint64_t horizon_tick, const NextTarget& next,
               PulseSchedule& schedule);
  /// The share of the job's speed limits that holds from the next motion planned on,
  /// 0.01..1.4: all the way is taken more slowly, so accelerations go with its square and
  /// jerks with its cube, or, above 1, faster as far as the machine's limits allow. What
  /// is planned already stays, and comes to rest first.
  void SetSpeed(double ratio, PulseSchedule& schedule);
  /// Commands the bridge to brake to rest and forget its run, ours or, of an earlier
  /// life, one up to `run`.
  Status Abort(std::uint32_t run = 0);

  /// The whole run, to its end at rest, has been handed to the bridge.
  bool sent_all() const { return sent_all_; }
  /// The bridge wants no more of a run that is not at its end.
  bool dropped() const;
  std::uint32_t run() const { return run_; }
  std::uint64_t start_tick() const { return start_tick_; }

 private:
  std::unique_ptr<motion::Planner> PlannerFrom(const Vec3& start_mm) const;
  void Schedule(PulseSchedule& schedule);
  bool MaySend() const;
  std::vector<std::uint64_t> ControllerTimes();
  bool Send(bool last);

  BatchWriter write_;
  GrantLookup grant_of_;
  std::string job_uid_;
  std::string stream_;
  std::uint32_t run_ = 0;
  std::uint64_t start_tick_ = 0;
  std::uint64_t next_batch_ = 0;
  Vec2 block_mm_ = Vec2::Zero();
  const MotionClock* clock_ = nullptr;
  std::uint64_t start_controller_ns_ = 0;
  double sent_controller_ns_ = 0;     ///< end of what was sent, by the controller's clock
  std::uint64_t timed_subticks_ = 0;  ///< from the run's start to there
  bool planned_all_ = false;
  bool sent_all_ = true;
  motion::PlanOptions plan_;
  motion::Limits machine_;
  double speed_ratio_ = 1;
  std::unique_ptr<motion::Planner> planner_;
  std::uint64_t ticks_before_planner_ = 0;  ///< of the run, by earlier planners
  std::vector<motion::Segment> pending_;
  std::size_t scheduled_ = 0;             ///< of pending_, from its front
  std::uint64_t scheduled_subticks_ = 0;  ///< from the run's start to there
};

}  // namespace intaglio::synchronizer
