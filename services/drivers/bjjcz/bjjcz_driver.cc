#include "services/drivers/bjjcz/bjjcz_driver.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "engrave/core/try.h"
#include "services/drivers/bjjcz/board_profile.h"
#include "services/drivers/interface/power_up.h"

namespace intaglio::drivers {
namespace {

link::ExpectedDevice ExpectedBoard(const MachineSpec& machine) {
  const SerialLine& line = machine.mark_line();
  return {line.serial_number(), "board", machine.name(), line.device(), "mark_line"};
}

Status RefuseBoard(std::string why) { return Fail(ErrorCode::kRefused, std::move(why)); }

}  // namespace

BjjczDriver::BjjczDriver(const MachineSpec& machine, std::vector<LmcCommand> set_up,
                         std::string broken, link::StreamOpener open,
                         link::SteadyClock clock)
    : board_(machine.bjjcz_board()),
      broken_(std::move(broken)),
      clock_(clock),
      line_(std::move(open), std::move(clock), ExpectedBoard(machine), std::move(set_up)),
      lists_(machine),
      guide_(machine, lists_, [this] { return Reset(); }) {
  state_.message = state_.refusal = broken_;
}

void BjjczDriver::Poll() {
  if (!broken_.empty()) return;
  const std::uint64_t sessions = line_.sessions();
  std::vector<LmcAnswer> answers;
  const bool lost = line_.Poll(answers);
  for (const LmcAnswer& answer : answers) Receive(answer);
  if (lost) TakeLost();
  if (line_.sessions() != sessions)
    state_.power_up = fmt::format("bjjcz-{:08x}", DrawPowerUp());
  if (run_ && !stopping_ && !is_permitted_for(0)) {
    BeginStop("it was not permitted to mark for 250 ms: reset and begin again");
  }
  if (stopping_ && line_.is_idle() && has_inputs_ && !busy_) {
    stopping_ = false;
    EndRun();
  }
  if (run_ && !stopping_) Feed();
  if (guide_.active() && !stopping_) FeedGuide();
  FeedOutputs();
  Report();
}

void BjjczDriver::Receive(const LmcAnswer& answer) {
  busy_ = answer.reply.is_busy();
  switch (answer.operation) {
    case LmcOperation::kReadPort:
      ++state_.number;
      TakeInputs(answer.reply.numbers[1]);
      break;
    case LmcOperation::kWritePort:
      outputs_ = asked_outputs_;
      break;
    default:
      break;
  }
  if (playing_) playing_->Receive(answer, clock_());
}

void BjjczDriver::TakeInputs(std::uint16_t inputs) {
  const bool was_closed =
      std::exchange(closed_, (inputs >> board_.door_input() & 1) != 0);
  has_inputs_ = true;
  if (!was_closed || closed_) return;
  ++state_.openings;
  state_.safe_state = true;
  if (run_) BeginStop("key, door or stop button ended the run: close them, then reset");
  if (guide_.active()) BeginStop("");
}

// The board plays the list that it has to the end.
void BjjczDriver::TakeLost() {
  has_inputs_ = closed_ = stopping_ = false;
  asked_outputs_.reset();
  outputs_.reset();
  playing_.reset();
  guide_.End();
  if (!run_) return;
  DropAll();
  run_.reset();
  state_.fault = "the line to the board was lost during the run: reset and begin again";
}

std::vector<MarkEvent> BjjczDriver::TakeEvents() {
  if (stage_ == Hand::kAnnounced) stage_ = Hand::kMaking;
  return std::exchange(events_, {});
}

Status BjjczDriver::Permit(bool permitted) {
  if (permitted) {
    permit_at_ = clock_();
    return {};
  }
  permit_at_.reset();
  return Stop();
}

bool BjjczDriver::is_permitted_for(double seconds) const {
  return permit_at_ &&
         std::chrono::duration<double>(clock_() - *permit_at_).count() + seconds <=
             std::chrono::duration<double>(kLease).count();
}

Status BjjczDriver::Begin(std::uint32_t run, std::span<const mark::Pen> pens) {
  if (!state_.link_up) return Fail(ErrorCode::kLinkLost, state_.message);
  if (guide_.active()) return RefuseBoard("an outline is drawn: end it");
  if (!state_.settled) return RefuseBoard("a run is not at its end: wait");
  if (!state_.fault.empty()) return RefuseBoard(state_.fault);
  if (!closed_ || state_.safe_state) return RefuseBoard(kChainWasOpened);
  if (run <= state_.newest_run)
    return RefuseBoard(fmt::format("run {} is not above {}", run, state_.newest_run));
  INTAGLIO_TRY(lists_.Begin(pens));
  state_.newest_run = run;
  run_ = run;
  finishes_ = false;
  if (board_.laser() == BJJCZ_LASER_FIBRE)
    line_.Send({LmcOperation::kFibreOscillator, {1}});
  Report();
  return {};
}

std::size_t BjjczDriver::Room() const {
  return run_ && !finishes_ && !stopping_ ? kMaxQueuedMarks - queue_.size() : 0;
}

Status BjjczDriver::Append(const NumberedMark& mark) {
  if (Room() == 0)
    return RefuseBoard("there is no room for a mark: wait, or begin a run");
  INTAGLIO_TRY(lists_.Check(mark.number, mark.mark));
  queue_.push_back(mark);
  return {};
}

Status BjjczDriver::Finish() {
  if (!run_) return RefuseBoard("there is no run to finish");
  finishes_ = true;
  return {};
}

Status BjjczDriver::Pause() {
  if (!run_) return {};
  for (const NumberedMark& mark : std::exchange(queue_, {}))
    AddEvent(mark.number, MarkFate::kNotBegun);
  finishes_ = true;
  return {};
}

Status BjjczDriver::Stop() {
  if (run_ && !stopping_) BeginStop("");
  return {};
}

Status BjjczDriver::Reset() {
  if (!state_.link_up) return Fail(ErrorCode::kLinkLost, state_.message);
  if (!closed_) return RefuseBoard("key, door or stop button is open: close them");
  if (run_ && !stopping_) return RefuseBoard("a run is under way: stop it before");
  state_.fault.clear();
  state_.safe_state = false;
  return {};
}

Status BjjczDriver::RequestPast(std::uint32_t run, std::uint32_t first,
                                std::uint32_t count) {
  if (!state_.link_up) return Fail(ErrorCode::kLinkLost, state_.message);
  return seen_.Answer(run, first, count, events_);
}

void BjjczDriver::AddEvent(std::uint32_t mark, MarkFate fate) {
  events_.push_back({*run_, mark, fate});
  seen_.Receive(events_.back());
}

void BjjczDriver::Report() {
  state_.link_up = line_.up() && has_inputs_;
  state_.message = line_.message();
  state_.refusal = line_.refusal();
  state_.session = line_.sessions();
  state_.key_on = state_.door_closed = state_.stop_released = state_.link_up && closed_;
  state_.shutter_open = state_.link_up && gate_is_open();
  state_.at_rest = !run_ && !guide_.active() && !stopping_ && !busy_;
  state_.settled = state_.link_up && state_.at_rest;
  const Vec2 at_mm = lists_.at_mm();
  state_.position_mm = Vec3(at_mm.x(), at_mm.y(), 0);
  guide_.TakeState(state_);
}

std::unique_ptr<MarkDriver> MakeBjjczDriver(const MachineSpec& machine,
                                            link::StreamOpener open,
                                            link::SteadyClock clock) {
  auto set_up = BoardSetUp(machine);
  std::string broken = set_up ? "" : set_up.error().message;
  return std::make_unique<BjjczDriver>(
      machine, set_up ? std::move(*set_up) : std::vector<LmcCommand>(), std::move(broken),
      std::move(open), std::move(clock));
}

}  // namespace intaglio::drivers
