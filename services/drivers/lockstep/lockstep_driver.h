#pragma once

// What the drivers of controllers without a clock share (grbl, isel): one controller that
// moves the stage and whose output is the laser line.
//
//   segments --PieceQueue--> Feed --ControllerLine--> controller
//   decided ticks --ProgressTicks--^        answers --> PassTicks, Report
//
// What the controller reports of itself is never taken for a lost line: a stop of its own
// (Halt) is a fault, a safe state and one of status().openings, which a host cannot miss
// (services/cell/machine_watch.h), and a reset is another power-up.
//
// What a tick is: piece_queue.h. The family runs in lockstep (LaserIdentity::lockstep):
// while the lamp is on, ticks pass only as far as they are decided, so nothing comes too
// late. Without the lamp nothing can fire, and ticks pass by this computer's clock. Lamp
// and rate are this driver's: the controller has neither.
//
// A controller that homes is mute. Until it has ended nothing can light: the output was
// switched off before, and nothing is sent. So the status stays fresh, with the shutter
// closed and the interlocks as they were; the controller itself stops for its chain.
//
// A family overrides how its controller is fed and what its answers mean; what it does
// not keep of the numbered guarantees of both interfaces stands in its header.
//
// Not thread-safe. A state of both interfaces: either Poll moves bytes for both.

#include <optional>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "services/drivers/interface/laser_controller.h"
#include "services/drivers/interface/motion_driver.h"
#include "services/drivers/lockstep/controller_line.h"
#include "services/drivers/lockstep/piece_queue.h"
#include "services/drivers/lockstep/progress_ticks.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class LockstepDriver : public MotionDriver, public LaserController {
 public:
  static constexpr std::size_t kQueuedPieces = 256;

  int fd() const final { return line().fd(); }

  // The motion driver.
  void Poll() final { Turn(); }
  const DriverState& state() const final { return state_; }
  std::vector<LatchedPositions> TakePositions() final;
  Status BeginRun(std::uint32_t run, std::uint64_t start_tick,
                  std::uint64_t start_ns) final;
  std::size_t Room() const final;
  Status Append(std::span<const motion::Segment> segments,
                std::span<const std::uint64_t> end_ns) final;
  Status AbortRun() override;
  Status ClearFault() final;
  LaserController* laser() final { return this; }
  /// In moves of at most PieceQueue::kMaxPiece_s: so it ends by itself when the host is
  /// gone.
  Status Jog(const Vec3& axes, double speed_mm_s) override;
  Status Home() override;
  /// A jog: nothing more of it is sent. Home: StopHoming. A run: as AbortRun.
  Status Hold() final;

  // The laser driver.
  void Poll(const ReportSink& sink, const PastSink& past) final;
  bool up() const final { return state_.link_up; }
  bool CanSend() const final { return up(); }
  bool taken_over() const final { return false; }
  const std::string& message() const final { return line().message(); }
  const std::string& refusal() const final { return line().refusal(); }
  const link::LaserIdentity& identity() const final { return identity_; }
  const link::LaserStatus& status() const final { return status_; }
  std::uint64_t status_number() const final { return status_number_; }
  std::chrono::nanoseconds status_at() const final { return status_at_; }
  std::uint64_t session() const final { return line().sessions(); }
  bool disarmed() const final { return up() && status_.disarms_taken == disarms_sent_; }
  Status Lamp(bool on, double rate_hz) final;
  Status OpenShutters(std::uint8_t mask) final;
  Status Arm(const link::ArmWindow& window) final;
  Status Disarm() final;
  Status Reset() final;
  Status Stop() final;
  Status RequestStatus() final;
  bool RequestPast(std::uint64_t first_tick, std::uint16_t count) final;

 protected:
  enum class Run { kNone, kWaits, kRuns };
  struct JogWay {
    Vec3 from_mm = Vec3::Zero(), to_mm = Vec3::Zero();
    double speed_mm_s = 0, length_mm = 0, sent_mm = 0;
    bool cancelled = false;  ///< nothing more is sent
    bool is_sent() const { return cancelled || sent_mm >= length_mm; }
  };
  /// The next move of a jog.
  struct JogPiece {
    Vec3 to_mm = Vec3::Zero();
    double seconds = 0;
    double end_mm = 0;  ///< JogWay::sent_mm with it
  };

  LockstepDriver(const MachineSpec& machine, link::SteadyClock clock, std::string model);

  // What a family says of its controller.
  virtual const ControllerLine& line() const = 0;
  virtual PieceQueue& pieces() = 0;
  virtual const PieceQueue& pieces() const = 0;
  /// A status of this session has come, and lines are taken.
  virtual bool IsIdentified() const { return status_number_ > 0; }
  /// A move or a command that was sent has not been executed yet.
  virtual bool HasSent() const = 0;
  /// The controller's newest report shows it at rest.
  virtual bool IsQuiet() const { return true; }
  /// What was sent can light nothing any more.
  virtual bool IsSettled() const = 0;
  /// Something of the run waits to be sent, or for its pulse.
  virtual bool HasPending() const = 0;
  /// Nothing of what was appended waits.
  virtual bool IsGivenOut() const { return pieces().empty() && !HasPending(); }
  /// After a fault: the controller takes commands again.
  virtual bool HasRecovered() const = 0;
  virtual bool chain_is_open() const = 0;
  virtual std::uint32_t openings() const = 0;
  virtual bool shutter_is_open() const { return wanted_open_; }
  /// `tick`, or the one before the first pulse whose outcome is not known.
  virtual std::uint64_t LimitedByPulses(std::uint64_t tick) const = 0;

  // What a family does.
  /// It makes a point by the pulses of its window.
  virtual bool DwellsAtPoints() const { return false; }
  /// Before a window is decided: its pulses are of the window's energy, or an error. Of a
  /// laser with one energy: CheckEnergy.
  virtual Status SetEnergy(const link::ArmWindow& window) {
    return CheckEnergy(identity_, window);
  }
  /// Moves the line's bytes, and takes what came; TakePowerUps comes first.
  virtual void TakeAnswers() = 0;
  virtual void Feed() = 0;
  virtual void BeginProgram(std::uint64_t start_tick) {
    pieces().Begin(start_tick, state_.position_mm);
  }
  virtual void DropProgram() { pieces().Drop(); }
  virtual void EndRun();
  /// The controller does nothing more of what was sent; its pulses are uncertain. The
  /// newest of their ticks, 0: none.
  virtual std::uint64_t ForgetSent() = 0;
  /// Ends what the controller executes, dark.
  virtual void StopController() = 0;
  virtual void AskStatus() = 0;
  /// Of a home that was sent.
  virtual void StopHoming() = 0;
  /// Brings the controller to where it takes commands again.
  virtual void Recover() {}
  virtual void Report();

  void TakePowerUps();
  /// A session has begun. `lost_run`: the fault after a run that a lost line has ended.
  void BeginSession(const std::string& lost_run);
  void TakeLost();
  void SetFault(intaglio_MotionFault fault, std::string why);
  /// Who stopped it: the chain, which openings() counts; the controller for a reason of
  /// its own, which is counted among status().openings, too; this host, by Stop.
  enum class StoppedBy { kChain, kController, kHost };
  void Halt(intaglio_MotionFault fault, std::string why,
            StoppedBy by = StoppedBy::kController);
  /// Whether Jog may begin now, and what a family begins as one.
  Status CheckByHand() const;
  std::optional<JogPiece> NextJogPiece() const;
  bool Fires(std::uint64_t tick);
  /// Ticks up to here may be sent.
  std::uint64_t DecidedThrough() const {
    return lamp_on_ ? ticks_.decided_through() : UINT64_MAX;
  }
  void PassTicks();
  void PassThrough(std::uint64_t tick);
  /// The next move, which takes `seconds`, is sent.
  void Plan(double seconds);
  std::chrono::nanoseconds now() const { return clock_(); }
  Status Down() const;

  ProgressTicks ticks_;
  DriverState state_;
  std::vector<LatchedPositions> positions_;
  Run run_ = Run::kNone;
  std::uint64_t start_tick_ = 0;
  std::uint64_t executed_through_ = 0;
  std::uint64_t committed_tick_ = 0;  ///< of the newest pulse that is sent or about to be
  std::optional<JogWay> jog_;
  bool homing_ = false, home_sent_ = false;
  bool halted_ = false;        ///< nothing is sent before Reset or ClearFault
  bool checks_place_ = false;  ///< the place is to be where the run ended
  bool aborted_ = false;       ///< the run ends where it is
  bool lamp_on_ = false, wanted_open_ = false;

  link::LaserIdentity identity_;
  link::LaserStatus status_;
  std::uint64_t status_number_ = 0;
  std::chrono::nanoseconds status_at_{0};

 private:
  void Turn();
  void SetDown();
  void TakeRecovery();
  std::uint64_t IdleTarget();
  void CheckStarved();
  void ReportLaser();
  void Forget();
  double WarmRatio() const;
  bool IsBusy() const { return homing_ || HasSent(); }
  std::optional<link::TickOutcome> WhyDark() const;

  link::SteadyClock clock_;
  double rate_hz_, warm_up_s_;
  std::vector<double> rates_hz_;
  bool clearing_ = false;      // the fault goes when the controller takes commands again
  bool leaving_safe_ = false;  // so does the safe state
  bool stop_ = false, safe_ = false;
  std::uint32_t own_stops_ = 0;
  bool ran_ = false;  // a run was there when the line was lost
  std::chrono::nanoseconds planned_end_{0}, passed_at_{0}, lamp_since_{0};
  double passed_part_ = 0;  // of a tick
  std::vector<link::PastReport> pasts_;
  std::vector<link::PulseReport> reports_;
  std::uint32_t disarms_sent_ = 0, power_ups_ = 0;
};

}  // namespace intaglio::drivers
