#pragma once

// Driver of the grbl family (grbl 1.1, grblHAL; serial or TCP): one controller that moves
// the stage and whose laser output is the laser line. docs/machines/grbl.md has the
// wiring and the settings.
//
//   segments --GrblProgram--> writes --GrblLine--> controller
//   decided ticks --ProgressTicks--^          |           |
//                                         v           v
//                            sent moves: "ok" and Bf: executed; "ok" of a barrier:
//                            settled
//
// What a tick is: grbl_program.h. The family runs in lockstep (LaserIdentity::lockstep):
// while the lamp is on, ticks pass only as far as they are decided, so nothing comes too
// late. Without the lamp nothing can fire, and ticks pass by this computer's clock.
//
// A pulse is settled by a barrier: "G4P0" is acknowledged when the planner is empty. A
// barrier follows every kPointsPerBarrier points and whatever there is nothing to send
// behind; never more than kMaxUnsettled points are sent and not settled. When the line is
// lost, or the controller is reset, holds or opens its door, these points are uncertain
// (TickOutcome::kNoLongerKnown): the synchronizer never fires them again without a
// person's consent. For a killed process laser.max_unsettled_points of the profile bounds
// the same number in the journal.
//
// What this family does not keep by itself of the numbered guarantees, and what bounds
// it:
//  - M9, L7: there is no watchdog: a controller whose host is gone runs its buffer out.
//  So
//    never more than kAhead_s of motion is sent ahead, no lit block without its dark one,
//    and M4 is dark at rest; but the laser stays enabled (M4) until the line comes back.
//    An external gate has to close the laser when the line is silent.
//  - L5, L6: of pulses in the uncertain window neither outcome nor count is known.
//  - L9: openings of the door are counted while the line is up; of those without a host
//  one
//    is seen. Key, door and stop button are one chain on the door's input.
//  - M5, L3: AbortRun and Disarm end when what was sent has been executed: within
//  kAhead_s
//    and a barrier. Stop is 0x18: dark with the last step, and the position may be lost.
// Nothing is sent after a door, a hold or an alarm before Reset or ClearFault, and '~'
// never is.
//
// Not thread-safe. A state of both interfaces: either Poll moves bytes for both.

#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "services/drivers/grbl/grbl_line.h"
#include "services/drivers/grbl/grbl_program.h"
#include "services/drivers/laser_controller.h"
#include "services/drivers/motion_driver.h"
#include "services/drivers/progress_ticks.h"

namespace intaglio::drivers {

class GrblDriver final : public MotionDriver, public LaserController {
 public:
  static constexpr std::size_t kPointsPerBarrier = 8;
  static constexpr std::size_t kMaxUnsettled = 16;
  static constexpr double kAhead_s = 0.15;
  static constexpr std::size_t kQueuedPieces = 256;

  GrblDriver(const MachineSpec& machine, link::StreamOpener open,
             link::SteadyClock clock);

  int fd() const override { return line_.fd(); }

  // The motion driver.
  void Poll() override;
  const DriverState& state() const override { return state_; }
  std::vector<LatchedPositions> TakePositions() override;
  Status BeginRun(std::uint32_t run, std::uint64_t start_tick,
                  std::uint64_t start_ns) override;
  std::size_t Room() const override;
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) override;
  Status AbortRun() override;
  Status ClearFault() override;
  LaserController* laser() override { return this; }
  /// M5 S0, then a jog in pieces of 50 ms, never more than kAhead_s ahead: so it ends by
  /// itself when the host is gone. Home is not offered: a controller that homes answers
  /// nothing, not even '?'.
  Status Jog(const Vec3& axes, double speed_mm_s) override;
  /// A jog: 0x85 until it is idle. A run: as AbortRun.
  Status Hold() override;

  // The laser driver.
  void Poll(const ReportSink& sink, const PastSink& past) override;
  bool up() const override { return state_.link_up; }
  bool CanSend() const override { return up(); }
  bool taken_over() const override { return false; }
  const std::string& message() const override { return line_.message(); }
  const std::string& refusal() const override { return state_.refusal; }
  const link::LaserIdentity& identity() const override { return identity_; }
  const link::LaserStatus& status() const override { return status_; }
  std::uint64_t status_number() const override { return status_number_; }
  std::chrono::nanoseconds status_at() const override { return status_at_; }
  std::uint64_t session() const override { return line_.sessions(); }
  bool disarmed() const override {
    return up() && status_.disarms_taken == disarms_sent_;
  }
  Status Lamp(bool on, double rate_hz) override;
  Status OpenShutters(std::uint8_t mask) override;
  Status Arm(const link::ArmWindow& window) override;
  Status Disarm() override;
  Status Reset() override;
  Status Stop() override;
  Status RequestStatus() override;
  bool RequestPast(std::uint64_t first_tick, std::uint16_t count) override;

 private:
  struct JogWay {
    Vec3 from_mm = Vec3::Zero(), to_mm = Vec3::Zero();
    double speed_mm_s = 0, length_mm = 0, sent_mm = 0;
    bool dark = false;       ///< M5 S0 was sent
    bool cancelled = false;  ///< nothing more is sent but 0x85
  };
  enum class Run { kNone, kWaits, kRuns };
  struct InFlight {
    enum class What { kMove, kBarrier, kEnable, kDisable } what = What::kMove;
    GrblMove move = {};
    bool acknowledged = false;
    std::uint64_t settles = 0;  ///< a barrier: the pulses up to this tick
  };

  void Turn();
  void Take(const GrblLine::Event& event);
  void TakeUp();
  void TakePowerUp();
  void TakeLost();
  void TakeOk();
  void TakeStatus(const GrblStatus& status);
  void CheckPlace();
  void UpdateReach();
  void Report();
  void SetDown();
  void SetFault(intaglio_MotionFault fault, std::string why);
  void TakeRecovery();

  // Sending: grbl_driver_feed.cc.
  void Feed();
  bool FeedProgram();
  void FeedJog();
  bool FeedAsides(std::uint64_t through);
  void FeedBarrier();
  void FeedEnable();
  bool SendPending();
  bool MaySendPulses() const;
  bool BarrierIsDue() const;
  double AheadSeconds() const;
  bool Fires(std::uint64_t tick);
  std::optional<link::TickOutcome> WhyDark() const;
  void Executed(std::size_t lines);
  void Execute(const GrblMove& move);
  void ExecuteThrough(std::size_t index);
  void PassTicks();
  void PassThrough(std::uint64_t tick);
  std::uint64_t IdleTarget();
  std::uint64_t LimitedByPulses(std::uint64_t tick) const;
  void CheckStarved();
  void EndRun();
  /// The controller does nothing more of what was sent: its points are uncertain.
  void Forget();
  void Halt(intaglio_MotionFault fault, std::string why);
  void Recover();

  bool lamp_decides() const { return lamp_on_; }
  double WarmRatio() const;
  std::chrono::nanoseconds now() const { return clock_(); }
  Status Down() const;

  link::SteadyClock clock_;
  GrblLine line_;
  GrblProgram program_;
  ProgressTicks ticks_;
  double rate_hz_, warm_up_s_;
  std::vector<double> rates_hz_;

  DriverState state_;
  GrblStatus grbl_;
  std::vector<LatchedPositions> positions_;
  Run run_ = Run::kNone;
  std::uint64_t start_tick_ = 0;
  std::uint64_t executed_through_ = 0;
  std::deque<InFlight> in_flight_;
  std::optional<GrblWrite> pending_;
  std::optional<JogWay> jog_;
  std::deque<std::uint64_t> unsettled_;  ///< ticks of pulses that were sent
  std::uint64_t barrier_tick_ = 0;       ///< the newest barrier settles up to here
  bool halted_ = false;                  ///< nothing is sent before Reset or ClearFault
  bool clearing_ = false;      ///< the fault goes when the controller takes lines again
  bool leaving_safe_ = false;  ///< so does the safe state
  bool checks_place_ = false;  ///< the place is to be where the program ended
  bool aborted_ = false;       ///< the run ends where it is
  bool ran_ = false;           ///< a run was there when the line was lost
  std::chrono::nanoseconds planned_end_{0}, passed_at_{0}, quiet_at_{0};
  double passed_part_ = 0;

  link::LaserIdentity identity_;
  link::LaserStatus status_;
  std::vector<link::PastReport> pasts_;
  std::vector<link::PulseReport> reports_;
  std::uint64_t status_number_ = 0;
  std::chrono::nanoseconds status_at_{0}, lamp_since_{0};
  std::uint32_t disarms_sent_ = 0, power_ups_ = 0;
  std::uint64_t committed_tick_ = 0;  ///< of the newest pulse that is sent or pending
  bool lamp_on_ = false, wanted_open_ = false, commanded_open_ = false, open_ = false;
  bool stop_ = false, safe_ = false;
};

std::unique_ptr<MotionDriver> MakeGrblDriver(const MachineSpec& machine,
                                             link::StreamOpener open,
                                             link::SteadyClock clock);

}  // namespace intaglio::drivers
