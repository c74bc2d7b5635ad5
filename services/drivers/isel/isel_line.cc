#include "services/drivers/isel/isel_line.h"

#include <array>
#include <utility>

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

// From the end of a command to its answer: the longest write and answer take 20 ms.
constexpr auto kIselSilence = 200ms;
constexpr auto kQuiet = 100ms;
constexpr auto kIselRetryPause = 500ms;

struct StartStep {
  const char* bytes;
  IselExpected expected;
};
// Spoils half a command of before ("@0B1,1" among them), so that its end is no command,
// and darkens; the answers are not awaited.
constexpr char kFirst[] = "x\r@0B1,0\r";
// The first may be answered with '9': then the controller was switched on just now.
constexpr std::array kStart = {StartStep{kIselOff, IselExpected::kCode},
                               StartStep{kIselInit, IselExpected::kCode},
                               StartStep{kIselOff, IselExpected::kCode},
                               StartStep{kIselPlace, IselExpected::kPlace}};

}  // namespace

IselLine::IselLine(link::StreamOpener open, link::SteadyClock clock, std::string refusal)
    : ControllerLine(std::move(open), std::move(clock)) {
  refusal_ = std::move(refusal);
  if (!refusal_.empty()) message_ = refusal_;
}

void IselLine::Poll(std::vector<Event>& events) {
  if (!refusal_.empty()) return;
  if (!stream_) Open();
  if (!stream_) return;
  Read(events);
  if (!stream_) return;
  if (phase_ == Phase::kDraining) Drain();
  if (reader_.is_expecting() && now() > deadline_) {
    Lose("the controller has not answered: check its power, the cable and the baud rate",
         events);
  }
  Write();
}

void IselLine::Open() {
  if (!OpenStream()) return;
  phase_ = Phase::kDraining;
  reader_.Clear();
  out_ = kFirst;
  quiet_since_ = now();
}

void IselLine::Drain() {
  if (now() - quiet_since_ < kQuiet || !out_.empty()) return;
  phase_ = Phase::kStarting;
  step_ = 0;
  SendStart();
}

void IselLine::SendStart() {
  const StartStep& step = kStart[step_];
  Expect(step.bytes, step.expected, 0);
}

void IselLine::Expect(const std::string& bytes, IselExpected what, double planned_s) {
  reader_.Expect(what);
  out_ += bytes;
  deadline_ = now() + kIselSilence +
              std::chrono::nanoseconds(static_cast<std::int64_t>(planned_s * 1e9));
  Write();
}

void IselLine::Read(std::vector<Event>& events) {
  std::array<std::byte, 256> buffer;
  std::vector<IselAnswer> answers;
  for (;;) {
    const auto count = stream_->Read(buffer);
    if (!count) {
      Lose(count.error().message, events);
      stream_.reset();
      phase_ = Phase::kClosed;
      return;
    }
    if (*count == 0) break;
    quiet_since_ = now();
    reader_.Feed(std::span(buffer).first(*count), answers);
  }
  for (const IselAnswer& answer : answers) {
    if (phase_ == Phase::kStarting) {
      TakeStart(answer, events);
      continue;
    }
    if (phase_ != Phase::kUp) return;
    if (answer.code == '9') {
      ++power_ups_;
      return Lose("the controller was reset or switched off", events);
    }
    const bool of_place =
        command_ == IselCommand::kPlace || command_ == IselCommand::kCheck;
    if (of_place && !answer.place) {
      return Lose("an answer of the controller is damaged: check the cable", events);
    }
    answers_.push_back(answer);
    if (reader_.is_expecting()) continue;
    events.emplace_back(IselReply{command_, std::exchange(answers_, {})});
  }
}

void IselLine::TakeStart(const IselAnswer& answer, std::vector<Event>& events) {
  const bool may_be_new = step_ == 0 && answer.code == '9';
  if (may_be_new) ++power_ups_;
  const bool wants_place = kStart[step_].expected == IselExpected::kPlace;
  const bool good = answer.code == '0' && (!wants_place || answer.place);
  if (step_ != 0 && !good) {
    return Lose("the controller does not begin: " + TextOfIselError(answer.code), events);
  }
  if (++step_ < kStart.size()) return SendStart();
  first_place_ = *answer.place;
  phase_ = Phase::kUp;
  ++sessions_;
  message_.clear();
  answers_.clear();
  events.emplace_back(IselUp{});
}

void IselLine::Send(IselCommand command, const std::string& bytes, double planned_s) {
  if (!is_idle()) return;
  command_ = command;
  answers_.clear();
  const bool of_place = command == IselCommand::kPlace || command == IselCommand::kCheck;
  if (command == IselCommand::kPulse) reader_.Expect(IselExpected::kCode);
  Expect(bytes, of_place ? IselExpected::kPlace : IselExpected::kCode, planned_s);
}

void IselLine::SendStop() {
  if (!up()) return;
  out_ += kIselStopByte;
  Write();
}

void IselLine::Lose(std::string why, std::vector<Event>& events) {
  const bool was_up = up();
  message_ = std::move(why);
  phase_ = Phase::kDraining;
  reader_.Clear();
  answers_.clear();
  out_ = kFirst;
  // Another attempt at the end of a long move.
  quiet_since_ = now() + (was_up ? 0ms : std::chrono::milliseconds(kIselRetryPause));
  if (was_up) events.emplace_back(IselLost{});
}

}  // namespace intaglio::drivers
