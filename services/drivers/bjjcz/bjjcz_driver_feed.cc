// The lists of marks, as they are due, and the outputs.

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "services/drivers/bjjcz/bjjcz_driver.h"
#include "services/drivers/bjjcz/board_outputs.h"

namespace intaglio::drivers {
void BjjczDriver::Feed() {
  if (playing_ && playing_->was_sent()) return CheckList();
  if (!line_.is_idle() || busy_) return;
  if (playing_) return ExecuteList();
  if (!hand_) return TakeNextMark();
  if (stage_ == Hand::kMaking && gate_is_open()) SendList();
}

// The outline, until it is held and the board has played its list.
void BjjczDriver::FeedGuide() {
  if (playing_ && playing_->was_sent()) {
    CheckList();
    if (playing_ || stopping_) return;
    guide_.SetPlayed();
  }
  if (!line_.is_idle() || busy_) return;
  if (!guide_.draws()) {
    playing_.reset();
    return guide_.End();
  }
  // The guide laser is switched on before the first list of its way.
  if (asked_outputs_ != WantedOutputs()) return;
  if (playing_) return playing_->Execute(line_);
  const LmcList list = guide_.Next();
  drivers::SendList(list, line_);
  playing_.emplace(list.seconds);
}

void BjjczDriver::TakeNextMark() {
  if (queue_.empty()) {
    if (finishes_) EndRun();
    return;
  }
  hand_ = std::move(queue_.front());
  queue_.pop_front();
  lists_.Load(hand_->mark);
  begun_ = false;
  stage_ = Hand::kAnnounced;
  AddEvent(hand_->number, MarkFate::kBegun);
}

void BjjczDriver::SendList() {
  const LmcList list = lists_.Next();
  drivers::SendList(list, line_);
  playing_.emplace(list.seconds);
}

// Not one that would outlast the permission: nothing but its end would end it.
void BjjczDriver::ExecuteList() {
  if (!is_permitted_for(playing_->seconds())) return;
  playing_->Execute(line_);
  begun_ = true;
}

void BjjczDriver::CheckList() {
  if (playing_->IsLate(clock_())) {
    return BeginStop(
        "the board does not end its list: it is slower than the profile has it to be, "
        "or waits for an input; switch it off and on, then reset");
  }
  if (!playing_->HasEnded(busy_, clock_())) return;
  playing_.reset();
  if (hand_ && !lists_.has_more()) EndMark(MarkFate::kDone);
}

void BjjczDriver::EndMark(MarkFate fate) {
  AddEvent(hand_->number, fate);
  hand_.reset();
  playing_.reset();
  stage_ = Hand::kNone;
}

void BjjczDriver::DropAll() {
  if (hand_) EndMark(begun_ ? MarkFate::kBroken : MarkFate::kNotBegun);
  for (const NumberedMark& mark : std::exchange(queue_, {}))
    AddEvent(mark.number, MarkFate::kNotBegun);
}

void BjjczDriver::BeginStop(std::string fault) {
  if (state_.fault.empty()) state_.fault = std::move(fault);
  if (stopping_) return;
  DropAll();
  playing_.reset();
  guide_.End();
  stopping_ = true;
  asked_outputs_ = WantedOutputs();
  SendStop(*asked_outputs_, line_);
}

void BjjczDriver::EndRun() {
  if (board_.laser() == BJJCZ_LASER_FIBRE)
    line_.Send({LmcOperation::kFibreOscillator, {0}});
  run_.reset();
}

std::uint16_t BjjczDriver::WantedOutputs() const {
  const bool permitted = is_permitted_for(0) && closed_ && !stopping_ &&
                         !state_.safe_state && state_.fault.empty();
  return OutputBits(board_, {
                                .permitted = permitted,
                                .runs = run_.has_value(),
                                .in_outline = guide_.active(),
                                .shows = guide_.shows() && closed_ && !stopping_,
                            });
}

bool BjjczDriver::gate_is_open() const {
  const auto bit = 1U << board_.gate_output();
  return outputs_ && (*outputs_ & WantedOutputs() & bit) != 0;
}

void BjjczDriver::FeedOutputs() {
  if (!line_.up() || !line_.is_idle()) return;
  const std::uint16_t wanted = WantedOutputs();
  if (asked_outputs_ == wanted) return;
  asked_outputs_ = wanted;
  line_.Send({LmcOperation::kWritePort, {wanted}});
}

}  // namespace intaglio::drivers
