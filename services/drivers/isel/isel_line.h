#pragma once

// The line to one isel controller: opens it, brings the controller to a known state,
// sends one command after the other, and notices when it is lost.
//
//   kClosed --open--> kDraining --100 ms quiet--> kStarting --@0B1,0 @07 @0P--> kUp
//                      ^  ^                                                      |
//                      |  +-------- a wrong answer, or none in time -------------+
//                      +-- after 500 ms
//
// kDraining spoils half a command that an earlier host left, and drops what is still
// answered: a CR alone would execute it. The first command switches the output off: an
// earlier host may have been cut off while it was on. The controller answers nothing
// during a move, so that the silence that counts as a lost line begins with the end of
// the move.
//
// The controller is switched off or reset when it answers '9', not initialized.

#include <chrono>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "services/drivers/isel/isel_text.h"
#include "services/drivers/lockstep/controller_line.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"

namespace intaglio::drivers {

enum class IselCommand : std::uint8_t {
  kPlace,  ///< where it is
  kProbe,  ///< what holds a move back
  kMove,
  kCheck,  ///< where it is, before a pulse
  kPulse,  ///< two answers
  kHome,
};

struct IselUp {};    ///< a session has begun: the controller is at rest and dark
struct IselLost {};  ///< the line, or the controller's memory
struct IselReply {
  IselCommand command;
  std::vector<IselAnswer> answers;  ///< one; of kPulse two
};

class IselLine final : public ControllerLine {
 public:
  using Event = std::variant<IselUp, IselLost, IselReply>;

  /// `refusal`: why no controller is right, so that none is opened; empty: any is.
  IselLine(link::StreamOpener open, link::SteadyClock clock, std::string refusal);

  /// Moves bytes; appends what has happened.
  void Poll(std::vector<Event>& events);
  bool up() const override { return phase_ == Phase::kUp; }
  /// Up, and the newest command was answered.
  bool is_idle() const { return up() && !reader_.is_expecting(); }
  /// When the session began.
  const IselSteps& first_place() const { return first_place_; }

  /// When it is idle. `planned_s`: until the command is answered.
  void Send(IselCommand command, const std::string& bytes, double planned_s = 0);
  /// At once: the move that is executed ends.
  void SendStop();

 private:
  enum class Phase { kClosed, kDraining, kStarting, kUp };

  void Open();
  void Drain();
  void Read(std::vector<Event>& events);
  void TakeStart(const IselAnswer& answer, std::vector<Event>& events);
  void SendStart();
  void Expect(const std::string& bytes, IselExpected what, double planned_s);
  void Lose(std::string why, std::vector<Event>& events);

  IselAnswerReader reader_;
  Phase phase_ = Phase::kClosed;
  std::size_t step_ = 0;  // of kStarting
  IselCommand command_ = IselCommand::kPlace;
  std::vector<IselAnswer> answers_;
  IselSteps first_place_{};
  std::chrono::nanoseconds quiet_since_{0}, deadline_{0};
};

}  // namespace intaglio::drivers
