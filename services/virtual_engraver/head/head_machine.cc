#include "services/virtual_engraver/head/head_machine.h"

#include <fmt/format.h>

namespace intaglio::virtual_engraver {
namespace {

using link::HeadFrame;

constexpr double kTickPeriod_ns = 1e4;
constexpr std::chrono::milliseconds kHeadStatusPeriod{20};
constexpr std::chrono::microseconds kHeadIdle{500};
// Between two reads of the line.
constexpr std::uint64_t kHeadTicksAtOnce = 2000;

}  // namespace

Result<std::unique_ptr<HeadMachine>> HeadMachine::Make(
    const HeadOptions& options, const std::filesystem::path& record,
    link::SteadyClock clock) {
  std::ofstream out(record, std::ios::binary | std::ios::trunc);
  const auto header =
      formats::EncodeMarkHeader({options.physics.field_mm, options.power_up});
  out.write(reinterpret_cast<const char*>(header.data()),
            static_cast<std::streamsize>(header.size()));
  out.flush();
  if (!out) {
    return Fail(ErrorCode::kIo,
                fmt::format("cannot write the mark record {}", record.string()),
                record.string());
  }
  return std::unique_ptr<HeadMachine>(
      new HeadMachine(options, std::move(out), std::move(clock)));
}

HeadMachine::HeadMachine(const HeadOptions& options, std::ofstream record,
                         link::SteadyClock clock)
    : lockstep_(options.lockstep),
      record_(std::move(record)),
      clock_(std::move(clock)),
      begun_at_(clock_()),
      controller_(
          options,
          [this](const formats::BurntTick& tick) {
            formats::AppendBurntTick(tick, unwritten_);
            ++burnt_ticks_;
          },
          [this](const formats::PrintMark& mark) {
            formats::AppendPrintMark(mark, unwritten_);
          }) {}

void HeadMachine::Plug(std::unique_ptr<link::ByteStream> end) {
  controller_.LoseHost();
  line_.Plug(std::move(end), clock_, lockstep_);
  line_.ForgetSession();
}

void HeadMachine::Handle(HeadFrame type, std::span<const std::byte> payload) {
  switch (type) {
    case HeadFrame::kHeadPermit:
      if (const auto m = link::Decode<link::HeadPermit>(payload))
        controller_.Permit(m->permitted, clock_());
      return;
    case HeadFrame::kHeadBegin:
      if (const auto m = link::Decode<link::HeadBegin>(payload)) controller_.Begin(*m);
      return;
    case HeadFrame::kHeadBlock:
      if (auto m = link::Decode<link::HeadBlock>(payload))
        controller_.Receive(std::move(*m));
      return;
    case HeadFrame::kHeadFinish:
      return controller_.Finish();
    case HeadFrame::kHeadPause:
      return controller_.Pause();
    case HeadFrame::kHeadStop:
      return controller_.Stop();
    case HeadFrame::kHeadReset:
      return controller_.Reset();
    case HeadFrame::kHeadPastRequest:
      if (const auto m = link::Decode<link::HeadPastRequest>(payload))
        line_.Send(HeadFrame::kHeadPast, Encode(controller_.memory().Past(*m)));
      return;
    default:
      return;
  }
}

void HeadMachine::PollLine() {
  const bool is_new =
      line_.Poll([this](std::uint8_t type, std::span<const std::byte> payload) {
        Handle(static_cast<HeadFrame>(type), payload);
      });
  if (line_.silent()) controller_.LoseHost();
  if (!is_new) return;
  controller_.NewSession();
  line_.Send(HeadFrame::kHeadIdentity, Encode(controller_.Identity()));
}

void HeadMachine::PassTicks() {
  if (line_.is_full() && lockstep_) return;
  if (lockstep_) {
    for (std::uint64_t i = 0; i < kHeadTicksAtOnce && controller_.has_ticks(); ++i)
      controller_.PassTick();
    return;
  }
  const auto due = static_cast<std::uint64_t>(
      static_cast<double>((clock_() - begun_at_).count()) / kTickPeriod_ns);
  for (std::uint64_t i = 0; i < kHeadTicksAtOnce && passed_ticks_ < due; ++i) {
    controller_.PassTick();
    ++passed_ticks_;
  }
}

void HeadMachine::SendReports() {
  for (const link::HeadMarks& marks : controller_.memory().TakeReports())
    line_.Send(HeadFrame::kHeadMarks, Encode(marks));
  const link::HeadStatus status = controller_.Status();
  // What a host has to know at once.
  const auto changed = std::tuple(status.openings, status.run_state, status.drops_taken,
                                  status.interlocks & ~link::kHeadLaserOn);
  const bool drained = lockstep_ && status.queued_ticks == 0 &&
                       status.run_state == link::HeadRunState::kOpen &&
                       clock_() >= line_.next_status() - kHeadStatusPeriod + kHeadIdle;
  if (changed != sent_state_ || line_.IsStatusDue(clock_()) || drained) {
    sent_state_ = changed;
    line_.SetNextStatus(clock_() + kHeadStatusPeriod);
    for (const link::HeadPrint& print : controller_.TakePrints())
      line_.Send(HeadFrame::kHeadPrint, Encode(print));
    for (const link::HeadWeb& web : controller_.TakeWeb())
      line_.Send(HeadFrame::kHeadWeb, Encode(web));
    line_.Send(HeadFrame::kHeadStatus, Encode(status));
  }
}

std::chrono::nanoseconds HeadMachine::Turn() {
  PollLine();
  controller_.Watch(clock_());
  PassTicks();
  (void)Flush();
  if (line_.is_up() && !line_.is_full()) SendReports();
  line_.Flush();
  return lockstep_ && controller_.has_ticks() ? std::chrono::nanoseconds{0}
                                              : std::chrono::nanoseconds(kHeadIdle);
}

Status HeadMachine::Flush() {
  if (unwritten_.empty()) return {};
  record_.write(reinterpret_cast<const char*>(unwritten_.data()),
                static_cast<std::streamsize>(unwritten_.size()));
  record_.flush();
  unwritten_.clear();
  if (!record_) return Fail(ErrorCode::kIo, "cannot write the mark record: disk full?");
  return {};
}

std::string HeadMachine::StatusLine() const {
  const link::HeadStatus s = controller_.Status();
  return fmt::format(R"({{"tick": {}, "interlocks": {}, "run": {}, "run_state": {}, )"
                     R"("queued_ticks": {}, "burnt_ticks": {}, "openings": {}, )"
                     R"("x": {}, "y": {}}})",
                     s.tick, s.interlocks, s.run, static_cast<int>(s.run_state),
                     s.queued_ticks, burnt_ticks_, s.openings, s.x, s.y);
}

}  // namespace intaglio::virtual_engraver
