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
// What it shares with other controllers that have no clock: lockstep_driver.h.
//
// What this family does not keep by itself of the numbered guarantees, and what bounds
// it:
//  - M9, L7: there is no watchdog. A controller whose host is gone ends its move, 50 ms
//    at most, and a pulse. If the line is cut between on and off, the output stays on
//    until the line comes back: an external pulse former and gate are needed.
//  - L6: the pulse that was sent when the line was lost is uncertain
//    (TickOutcome::kNoLongerKnown); one point at most.
//  - L9: openings of the chain are seen while the line is up, by a move by nothing every
//    40 ms and by every command.
//  - L10: the shutter and the lamp are this driver's: without them nothing is sent.
//  - M13, L12: the family reports no serial number; a profile that names one is refused,
//    and so is one without steps_per_mm.
//  - Home is one command, which the controller executes without an answer, for a minute:
//    a host that dies meanwhile ends it no more. Hold does.

#include <optional>
#include <string>

#include "proto/machine.pb.h"
#include "services/drivers/isel/isel_line.h"
#include "services/drivers/lockstep/lockstep_driver.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

class IselDriver final : public LockstepDriver {
 public:
  IselDriver(const MachineSpec& machine, link::StreamOpener open,
             link::SteadyClock clock);

  Status AbortRun() override;

 private:
  /// A move that is executed, and what has passed with it.
  struct Move {
    IselSteps to{};
    Vec3 from_mm = Vec3::Zero();
    std::optional<Piece> piece;  ///< of a run
  };

  const ControllerLine& line() const override { return line_; }
  PieceQueue& pieces() override { return pieces_; }
  const PieceQueue& pieces() const override { return pieces_; }
  bool HasSent() const override { return move_.has_value(); }
  bool IsSettled() const override { return !is_fired_; }
  bool HasPending() const override { return pulse_tick_ != 0; }
  bool HasRecovered() const override { return line_.up() && !chain_open_; }
  bool chain_is_open() const override { return chain_open_; }
  std::uint32_t openings() const override { return openings_; }
  std::uint64_t LimitedByPulses(std::uint64_t tick) const override;
  void EndRun() override;
  std::uint64_t ForgetSent() override;
  void StopController() override;
  void AskStatus() override { next_question_ = {}; }
  void StopHoming() override { line_.SendStop(); }

  // isel_driver_replies.cc.
  void TakeAnswers() override;
  void TakeUp();
  void TakeReply(const IselReply& reply);
  void TakePlace(const IselSteps& place);
  void TakeProbe(char code);
  void TakeMove(char code);
  void TakeCheck(const IselSteps& place);
  void TakePulse(char on, char off);
  void TakeHome(char code);
  void SetChain(bool open);
  void Refuse(char code, const std::string& what);
  void CheckPlace();
  void Execute(const Move& move);

  // Sending: isel_driver_feed.cc.
  void Feed() override;
  bool FeedJog();
  bool FeedPulse();
  bool FeedRun();
  bool FeedPiece();
  bool FeedAside();
  void FeedQuestion();
  void SendMove(const IselSteps& to, double seconds, std::optional<Piece> piece);

  Vec3 PlaceOf(const IselSteps& steps) const;
  IselSteps StepsOf(const Vec3& place_mm) const;

  IselLine line_;
  PieceQueue pieces_;
  IselSteps place_{};           ///< the controller's newest
  Vec3 end_mm_ = Vec3::Zero();  ///< where the newest run ended
  std::optional<Move> move_;
  std::uint64_t pulse_tick_ = 0;  ///< of a point where the stage is now; 0: none
  bool is_checked_ = false;       ///< the place of that point was read and is right
  bool is_fired_ = false;         ///< it was sent, and not answered
  bool chain_open_ = false, knows_chain_ = false, asks_chain_ = false;
  std::uint32_t openings_ = 0;
  std::chrono::nanoseconds next_question_{0};
};

std::unique_ptr<MotionDriver> MakeIselDriver(const MachineSpec& machine,
                                             link::StreamOpener open,
                                             link::SteadyClock clock);

}  // namespace intaglio::drivers
