#include "services/drivers/bjjcz/lmc_line.h"

#include <fmt/format.h>

#include <array>
#include <chrono>
#include <span>
#include <utility>

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

// An answer of a board takes a millisecond.
constexpr auto kLmcSilence = 200ms;
constexpr auto kLmcStatusPeriod = 5ms;
constexpr LmcCommand kAskStatus = {LmcOperation::kReadPort, {}};

}  // namespace

LmcLine::LmcLine(link::StreamOpener open, link::SteadyClock clock,
                 link::ExpectedDevice expected, std::vector<LmcCommand> set_up)
    : ControllerLine(std::move(open), std::move(clock)),
      expected_(std::move(expected)),
      set_up_(std::move(set_up)) {}

bool LmcLine::Poll(std::vector<LmcAnswer>& answers) {
  if (!stream_) Open();
  if (!stream_) return false;
  const bool was_up = up();
  if (!Read(answers)) return was_up;
  if (asked_ && out_.empty() && now() > asked_at_ + kLmcSilence) {
    return Lose(
        "the board does not answer: check its power and the cable, and that no other "
        "program has it");
  }
  if (phase_ == Phase::kStarting && is_idle()) {
    phase_ = Phase::kUp;
    ++sessions_;
    ++power_ups_;
    message_.clear();
  }
  WriteNext();
  WriteMessages();
  return false;
}

void LmcLine::Open() {
  if (!OpenStream()) {
    // The board that was refused is not there any more.
    if (message_ != refusal_) refusal_.clear();
    return;
  }
  phase_ = Phase::kSerial;
  if (!refusal_.empty()) message_ = refusal_;
  message_left_ = 0;
  reader_.Clear();
  waiting_.clear();
  ready_ = false;
  Ask({LmcOperation::kSerialNumber, {}});
}

bool LmcLine::Read(std::vector<LmcAnswer>& answers) {
  std::array<std::byte, 256> buffer;
  for (;;) {
    const auto count = stream_->Read(buffer);
    if (!count) {
      (void)Lose(count.error().message);
      return false;
    }
    if (*count == 0) break;
    reader_.Feed(std::span(buffer).first(*count));
  }
  while (const auto reply = reader_.Next()) {
    Receive(*reply, answers);
    if (!stream_) return false;
  }
  return true;
}

void LmcLine::Receive(const LmcReply& reply, std::vector<LmcAnswer>& answers) {
  if (!asked_) return;  // nothing was asked
  const LmcOperation operation = *std::exchange(asked_, std::nullopt);
  answered_at_ = now();
  ready_ = reply.is_ready();
  if (phase_ == Phase::kSerial)
    Identify(reply);
  else if (phase_ == Phase::kUp)
    answers.push_back({operation, reply});
}

void LmcLine::Identify(const LmcReply& reply) {
  const auto& numbers = reply.numbers;
  const std::string serial_number =
      fmt::format("{:04x}{:04x}{:04x}", numbers[0], numbers[1], numbers[2]);
  refusal_ = link::RefusalOf(expected_, serial_number);
  if (!refusal_.empty()) {
    (void)Lose(refusal_);
    return;
  }
  phase_ = Phase::kStarting;
  for (const LmcCommand& command : set_up_) waiting_.push_back({{command}, false});
}

void LmcLine::Send(const LmcCommand& command) {
  if (up()) waiting_.push_back({{command}, false});
}

void LmcLine::SendPacket(std::vector<LmcCommand> commands) {
  if (up()) waiting_.push_back({std::move(commands), true});
}

void LmcLine::Ask(const LmcCommand& command) {
  AppendCommand(command, out_);
  if (!IsAnswered(command.operation)) return;
  asked_ = command.operation;
  asked_at_ = now();
}

void LmcLine::WriteNext() {
  while (!asked_ && !waiting_.empty()) {
    const Waiting& next = waiting_.front();
    if (next.is_packet && !ready_) return Ask(kAskStatus);
    if (next.is_packet) {
      AppendPacket(next.commands, out_);
      ready_ = false;  // until the next status
    } else {
      Ask(next.commands.front());
    }
    waiting_.pop_front();
  }
  if (up() && !asked_ && now() >= answered_at_ + kLmcStatusPeriod) Ask(kAskStatus);
}

void LmcLine::WriteMessages() {
  if (!stream_->connected()) return;
  std::size_t written = 0;
  while (written < out_.size()) {
    const auto rest = std::as_bytes(std::span(out_)).subspan(written);
    if (message_left_ == 0) message_left_ = LmcMessageBytes(rest);
    const auto taken = stream_->Write(rest.first(message_left_));
    // An error of the line is found by the next Read.
    if (!taken || *taken == 0) break;
    written += *taken;
    message_left_ -= *taken;
  }
  out_.erase(0, written);
}

bool LmcLine::Lose(std::string why) {
  const bool was_up = up();
  message_ = std::move(why);
  stream_.reset();
  phase_ = Phase::kClosed;
  waiting_.clear();
  asked_.reset();
  return was_up;
}

}  // namespace intaglio::drivers
