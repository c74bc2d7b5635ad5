// What the driver of isel's controllers makes of their answers (isel_driver.h).

#include <fmt/format.h>

#include <utility>

#include "services/drivers/isel/isel_driver.h"

namespace intaglio::drivers {

void IselDriver::TakeAnswers() {
  std::vector<IselLine::Event> events;
  line_.Poll(events);
  TakePowerUps();
  for (const IselLine::Event& event : events) {
    if (std::holds_alternative<IselUp>(event)) {
      TakeUp();
    } else if (std::holds_alternative<IselLost>(event)) {
      TakeLost();
    } else {
      TakeReply(std::get<IselReply>(event));
    }
  }
}

void IselDriver::TakeUp() {
  BeginSession(
      "the line to the controller was lost in a run: check the block, then resume");
  knows_chain_ = asks_chain_ = false;
  next_question_ = {};
  TakePlace(line_.first_place());
}

void IselDriver::TakeReply(const IselReply& reply) {
  const IselAnswer& answer = reply.answers.front();
  if (answer.code == 'H') SetChain(true);
  switch (reply.command) {
    case IselCommand::kPlace:
      return TakePlace(*answer.place);
    case IselCommand::kCheck:
      return TakeCheck(*answer.place);
    case IselCommand::kProbe:
      return TakeProbe(answer.code);
    case IselCommand::kMove:
      return TakeMove(answer.code);
    case IselCommand::kPulse:
      return TakePulse(answer.code, reply.answers.back().code);
    case IselCommand::kHome:
      return TakeHome(answer.code);
  }
}

void IselDriver::TakePlace(const IselSteps& place) {
  place_ = place;
  state_.position_mm = PlaceOf(place);
  ++state_.number;
  if (!knows_chain_) return;
  ++status_number_;
  status_at_ = now();
  CheckPlace();
}

void IselDriver::SetChain(bool open) {
  if (open && (!chain_open_ || !knows_chain_)) ++openings_;
  chain_open_ = open;
  knows_chain_ = true;
}

void IselDriver::TakeProbe(char code) {
  SetChain(code == 'H');
  if (code == 'H') {
    Halt(intaglio_MOTION_SAFE_STATE,
         "the controller's " + TextOfIselError(code) + ", check the block, then resume",
         StoppedBy::kChain);
    return;
  }
  state_.homed = code != 'R';
  if (code != '0' && code != 'R') Refuse(code, "to be ready");
}

void IselDriver::Refuse(char code, const std::string& what) {
  if (code == 'R' || code == '2') state_.homed = false;
  Halt(code == '2' ? intaglio_MOTION_LIMIT : intaglio_MOTION_SAFE_STATE,
       fmt::format("the controller refused {}: {}; check the block, then resume", what,
                   TextOfIselError(code)),
       code == 'H' ? StoppedBy::kChain : StoppedBy::kController);
}

void IselDriver::TakeMove(char code) {
  if (!move_) return;  // it was stopped, or forgotten
  const Move move = *std::exchange(move_, std::nullopt);
  if (code != '0') return Refuse(code, "a move");
  TakePlace(move.to);
  Execute(move);
}

// The point's own step, or no pulse.
void IselDriver::TakeCheck(const IselSteps& place) {
  const IselSteps expected = place_;
  TakePlace(place);
  if (pulse_tick_ == 0) return;
  if (place == expected) {
    is_checked_ = true;
    return;
  }
  ticks_.Settle(pulse_tick_, link::TickOutcome::kNotInPosition);
  pulse_tick_ = 0;
  SetFault(intaglio_MOTION_FOLLOWING_ERROR,
           "the controller is not at the place of its last move: check its zero, then "
           "resume");
}

void IselDriver::TakePulse(char on, char off) {
  const std::uint64_t tick = std::exchange(pulse_tick_, 0);
  is_fired_ = is_checked_ = false;
  if (tick != 0) {
    ticks_.Settle(tick, on == '0'   ? link::TickOutcome::kFiredUnseen
                        : on == 'H' ? link::TickOutcome::kInterlocked
                                    : link::TickOutcome::kNotInPosition);
  }
  if (on != '0') return Refuse(on, "a pulse");
  if (off != '0') Refuse(off, "to switch its output off");
}

void IselDriver::TakeHome(char code) {
  homing_ = home_sent_ = false;
  next_question_ = {};
  if (code == '0') {
    state_.homed = true;
    return TakePlace({});  // where it counts from
  }
  if (code != 'F') Refuse(code, "to home");
}

void IselDriver::Execute(const Move& move) {
  if (!move.piece || run_ == Run::kNone) return;
  const Piece& piece = *move.piece;
  executed_through_ = std::max(executed_through_, TickOf(piece.end_subticks));
  // The place before the move was a whole step, too.
  if (!piece.at_ticks_mm.empty()) {
    positions_.push_back({state_.run,
                          TickOf(piece.start_subticks) + 1,
                          PlacesOnChord(move.from_mm, piece),
                          {}});
  }
  if (!piece.pulse || aborted_) return;
  pulse_tick_ = TickOf(piece.end_subticks);
  is_checked_ = false;
}

// The controller counts its steps; another place than that of its last move is another
// host, or a reset.
void IselDriver::CheckPlace() {
  if (!std::exchange(checks_place_, false) || state_.fault != intaglio_MOTION_OK) return;
  state_.following_error_max_um = (state_.position_mm - end_mm_).norm() * 1000;
  if (StepsOf(end_mm_) == place_) return;
  SetFault(intaglio_MOTION_FOLLOWING_ERROR,
           "the controller ended elsewhere than the run: check its zero, then resume");
}

}  // namespace intaglio::drivers
