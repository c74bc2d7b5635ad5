#pragma once

// Driver of isel's stepper controllers (19200 8N1, '@' commands): one
// controller that moves the stage and whose output 1 triggers the laser.
// docs/machines/isel.md has the wiring.
//
//   segments --PieceQueue--> pieces --@0M--> '0' --@0P--> place right --@0B--> '0' '0'
//   decided ticks --ProgressTicks--^                                            |
//                                                           the point is made <-+
//
// Stop and shoot. A piece is one move of at most 50 ms, or up to the next point; the next
// command is sent when the controller has answered. A pulse is fired only at rest, after
// the '0' of the move and a place that is the point's own step; output on and off leave
// in one write.
//
// What a tick is: piece_queue.h. The family runs in lockstep (LaserIdentity::lockstep):
// while the lamp is on, ticks pass only as far as they are decided. Without the lamp
// nothing can fire, and ticks pass by this computer's clock.
//
// What this family does not keep by itself of the numbered guarantees, and what bounds
// it:
//  - M9, L7: there is no watchdog. A controller whose host is gone ends its move, 50 ms
//  at
//    most, and a pulse. If the line is cut between on and off, the output stays on until
//    the line comes back: an external pulse former and gate are needed.
//  - L6: the pulse that was sent when the line was lost is uncertain
//    (TickOutcome::kNoLongerKnown); one point at most.
//  - L9: openings of the chain are seen while the line is up, by a move by nothing every
//    40 ms and by every command.
//  - L10: the shutter and the lamp are this driver's: without them nothing is sent.
//  - M13, L12: the family reports no serial number; a profile that names one is refused,
//    and so is one without steps_per_mm.
//  - Home is one command, which the controller executes without an answer, for a minute:
//    a host that dies meanwhile ends it no more. Hold does.
//
// Not thread-safe. A state of both interfaces: either Poll moves bytes for both.

#include <optional>
#include <string>
#include <vector>

#include "services/drivers/isel/isel_line.h"
#include "services/drivers/laser_controller.h"
#include "services/drivers/motion_driver.h"
#include "services/drivers/piece_queue.h"
#include "services/drivers/progress_ticks.h"

namespace intaglio::drivers {

class IselDriver final : public MotionDriver, public LaserController {
 public:
  static constexpr std::size_t kQueuedPieces = 256;

  IselDriver(const MachineSpec& machine, link::StreamOpener open,
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
  /// In moves of 50 ms: so it ends by itself when the host is gone.
  Status Jog(const Vec3& axes, double speed_mm_s) override;
  Status Home() override;
  Status Hold() override;

  // The laser driver.
  void Poll(const ReportSink& sink, const PastSink& past) override;
  bool up() const override { return state_.link_up; }
  bool CanSend() const override { return up(); }
  bool taken_over() const override { return false; }
  const std::string& message() const override { return line_.message(); }
  const std::string& refusal() const override { return line_.refusal(); }
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
  enum class Run { kNone, kWaits, kRuns };
  struct JogWay {
    Vec3 from_mm = Vec3::Zero(), to_mm = Vec3::Zero();
    double speed_mm_s = 0, length_mm = 0, sent_mm = 0;
    bool cancelled = false;  ///< nothing more is sent
  };
  /// A move that is executed, and what has passed with it.
  struct Move {
    IselSteps to{};
    Vec3 from_mm = Vec3::Zero();
    std::optional<Piece> piece;  ///< of a run
  };

  void Turn();
  void Take(const IselLine::Event& event);
  void TakeUp();
  void TakePowerUp();
  void TakeLost();
  void TakeReply(const IselReply& reply);
  void TakePlace(const IselSteps& place);
  void TakeProbe(char code);
  void TakeMove(char code);
  void TakeCheck(const IselSteps& place);
  void TakePulse(char on, char off);
  void TakeHome(char code);
  void SetChain(bool open);
  void SetDown();
  void SetFault(intaglio_MotionFault fault, std::string why);
  void Refuse(char code, const std::string& what);
  void Report();
  void ReportLaser();

  // Sending: isel_driver_feed.cc.
  void Feed();
  bool FeedJog();
  bool FeedRun();
  bool FeedPiece();
  bool FeedPulse();
  bool FeedAside();
  void FeedQuestion();
  void SendMove(const IselSteps& to, double seconds, std::optional<Piece> piece);
  bool Fires(std::uint64_t tick);
  std::optional<link::TickOutcome> WhyDark() const;
  void Execute(const Move& move);
  void PassTicks();
  std::uint64_t IdleTarget();
  std::uint64_t LimitedByPulse(std::uint64_t tick) const;
  void CheckStarved();
  void CheckPlace();
  void EndRun();
  void EndJog();
  /// Nothing more of what was begun is done; a pulse that was sent is uncertain.
  void Forget();
  void Halt(intaglio_MotionFault fault, std::string why);
  void TakeRecovery();

  Vec3 PlaceOf(const IselSteps& steps) const;
  IselSteps StepsOf(const Vec3& place_mm) const;
  bool has_lamp() const { return lamp_on_; }
  double WarmRatio() const;
  std::chrono::nanoseconds now() const { return clock_(); }
  Status Down() const;

  link::SteadyClock clock_;
  IselLine line_;
  PieceQueue pieces_;
  ProgressTicks ticks_;
  double rate_hz_, warm_up_s_;
  std::vector<double> rates_hz_;

  DriverState state_;
  std::vector<LatchedPositions> positions_;
  IselSteps place_{};           ///< the controller's newest
  Vec3 end_mm_ = Vec3::Zero();  ///< where the newest run ended
  Run run_ = Run::kNone;
  std::uint64_t start_tick_ = 0, executed_through_ = 0;
  std::optional<Move> move_;
  std::optional<JogWay> jog_;
  bool homing_ = false, home_sent_ = false;
  std::uint64_t pulse_tick_ = 0;  ///< of a point where the stage is now; 0: none
  bool is_checked_ = false;       ///< the place of that point was read and is right
  bool is_fired_ = false;         ///< it was sent, and not answered
  bool halted_ = false;           ///< nothing is sent before Reset or ClearFault
  bool clearing_ = false, leaving_safe_ = false;
  bool checks_place_ = false;  ///< the place is to be where the run ended
  bool aborted_ = false;       ///< the run ends where it is
  bool ran_ = false;           ///< a run was there when the line was lost
  bool chain_open_ = false, knows_chain_ = false, asks_chain_ = false;
  std::chrono::nanoseconds planned_end_{0}, passed_at_{0}, next_question_{0};
  double passed_part_ = 0;

  link::LaserIdentity identity_;
  link::LaserStatus status_;
  std::vector<link::PastReport> pasts_;
  std::vector<link::PulseReport> reports_;
  std::uint64_t status_number_ = 0;
  std::chrono::nanoseconds status_at_{0}, lamp_since_{0};
  std::uint32_t disarms_sent_ = 0, power_ups_ = 0, openings_ = 0;
  bool lamp_on_ = false, wanted_open_ = false, stop_ = false, safe_ = false;
};

std::unique_ptr<MotionDriver> MakeIselDriver(const MachineSpec& machine,
                                             link::StreamOpener open,
                                             link::SteadyClock clock);

}  // namespace intaglio::drivers
