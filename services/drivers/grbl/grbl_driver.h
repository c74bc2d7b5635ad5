#pragma once

// Driver of the grbl family (grbl 1.1, grblHAL; serial or TCP): one controller that moves
// the stage and whose laser output is the laser line. docs/machines/grbl.md has the
// wiring and the settings.
//
//   segments --GrblProgram--> writes --GrblLine--> controller
//                                       |               |
//                                       v               v
//                 sent moves: "ok" and Bf: executed; "ok" of a barrier: settled
//
// What a tick is: grbl_program.h. What it shares with other controllers that have no
// clock: lockstep_driver.h.
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
//    So never more than kAhead_s of motion is sent ahead, no lit block without its dark
//    one, and M4 is dark at rest; but the laser stays enabled (M4) until the line comes
//    back. An external gate has to close the laser when the line is silent.
//  - A controller that homes answers nothing, not even '?': a host that dies meanwhile
//    ends it no more. Hold does, by 0x18: the controller is locked then, until it has
//    homed. After its power-up a controller with $22=1 is not homed, and takes nothing
//    else.
//  - L5, L6: of pulses in the uncertain window neither outcome nor count is known.
//  - L9: openings of the door are counted while the line is up; of those without a host
//    one is seen. Key, door and stop button are one chain on the door's input.
//  - M5, L3: AbortRun and Disarm end when what was sent has been executed: within
//    kAhead_s and a barrier. Stop is 0x18: dark with the last step, and the position may
//    be lost.
// Nothing is sent after a door, a hold or an alarm before Reset or ClearFault, and '~'
// never is.

#include <array>
#include <deque>
#include <optional>
#include <string>

#include "proto/machine.pb.h"
#include "services/drivers/grbl/grbl_jog.h"
#include "services/drivers/grbl/grbl_line.h"
#include "services/drivers/grbl/grbl_program.h"
#include "services/drivers/lockstep/lockstep_driver.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class GrblDriver final : public LockstepDriver {
 public:
  static constexpr std::size_t kPointsPerBarrier = 8;
  static constexpr std::size_t kMaxUnsettled = 16;
  static constexpr double kAhead_s = 0.15;

  GrblDriver(const MachineSpec& machine, link::StreamOpener open,
             link::SteadyClock clock);

  /// M5 S0, then the moves of a jog, never more than kAhead_s ahead. Hold: 0x85 until it
  /// is idle. One that the controller cuts (grbl_jog.h) is a stop of its own.
  Status Jog(const Vec3& axes, double speed_mm_s) override;
  /// M5 S0, then $H. kRefused of a controller whose $22 is 0.
  Status Home() override;
  /// M5 S0, then G10L20P1: G54 is moved, and the controller's own count stays.
  Status SetZero(const Vec3& here_mm, const std::array<bool, 3>& sets) override;

 private:
  struct InFlight {
    enum class What { kMove, kBarrier, kEnable, kDisable, kZero } what = What::kMove;
    GrblMove move = {};
    bool acknowledged = false;
    std::uint64_t settles = 0;  ///< a barrier: the pulses up to this tick
  };

  const ControllerLine& line() const override { return line_; }
  PieceQueue& pieces() override { return program_.pieces(); }
  const PieceQueue& pieces() const override { return program_.pieces(); }
  bool IsIdentified() const override;
  bool HasSent() const override { return !in_flight_.empty() || zero_; }
  bool IsQuiet() const override {
    return grbl_.at_rest() && status_at_ > quiet_at_ && IsSetUp();
  }
  bool IsSettled() const override { return unsettled_.empty() && !pending_; }
  bool HasPending() const override { return pending_.has_value(); }
  bool IsGivenOut() const override;
  bool IsSetUp() const { return line_.takes_lines() || line_.needs_recovery(); }
  bool HasRecovered() const override;
  bool chain_is_open() const override { return line_.chain_is_open(); }
  std::uint32_t openings() const override { return line_.chain_openings(); }
  bool shutter_is_open() const override { return open_ && wanted_open_; }
  std::uint64_t LimitedByPulses(std::uint64_t tick) const override;
  void BeginProgram(std::uint64_t start_tick) override;
  void DropProgram() override { program_.Drop(); }
  std::uint64_t ForgetSent() override;
  void StopController() override { line_.Reset(); }
  void AskStatus() override { line_.RequestStatus(); }
  void StopHoming() override;
  Status SetEnergy(const link::ArmWindow& window) override;
  void Recover() override;
  void Report() override;

  void TakeAnswers() override;
  void Receive(const GrblLine::Event& event);
  void TakeUp();
  void TakeOk();
  void TakeAlarm(const GrblAlarm& alarm);
  void TakeHomed();
  void TakeStatus(const GrblStatus& status);
  void TakeProgress();
  void WatchJog();
  void CheckPlace();
  void UpdateReach();

  // Sending: grbl_driver_feed.cc.
  void Feed() override;
  bool FeedProgram();
  void FeedJog();
  void FeedHome();
  void FeedZero();
  bool SendDark();
  bool FeedAsides(std::uint64_t through);
  void FeedBarrier();
  void FeedEnable();
  bool SendPending();
  /// No move that was sent can still be refused.
  bool IsPlaceCertain() const;
  bool MaySendPulses() const;
  bool BarrierIsDue() const;
  double AheadSeconds() const;
  void Executed(std::size_t lines);
  void Execute(const GrblMove& move);
  void ExecuteThrough(std::size_t index);

  GrblLine line_;
  GrblProgram program_;
  GrblJogMoves jog_moves_;
  LaserHead laser_;  ///< of the profile
  GrblStatus grbl_;
  std::deque<InFlight> in_flight_;
  std::optional<GrblWrite> pending_;
  std::deque<std::uint64_t> unsettled_;  ///< ticks of pulses that were sent
  std::uint64_t barrier_tick_ = 0;       ///< the newest barrier settles up to here
  struct Zero {
    Vec3 here_mm = Vec3::Zero();
    std::array<bool, 3> sets{};
  };
  std::optional<Zero> zero_;   ///< not sent, or not acknowledged yet
  bool is_dark_ = false;       ///< M5 S0 was sent for the newest motion by hand
  bool stopped_home_ = false;  ///< its alarm is no fault
  bool commanded_open_ = false, open_ = false;
  std::chrono::nanoseconds quiet_at_{0};
};

std::unique_ptr<MotionDriver> MakeGrblDriver(const MachineSpec& machine,
                                             link::StreamOpener open,
                                             link::SteadyClock clock);

}  // namespace intaglio::drivers
