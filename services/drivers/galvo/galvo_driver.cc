#include "services/drivers/galvo/galvo_driver.h"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "engrave/core/try.h"
#include "services/drivers/galvo/mark_player.h"
#include "services/platform/link/expected_device.h"
#include "services/platform/link/line_session.h"

namespace intaglio::drivers {
namespace {

using link::HeadFrame;
using link::HeadRunState;

// Marks that wait here.
constexpr std::size_t kMaxWaitingMarks = 256;
// Marks whose beginning was announced and whose ticks were not all sent.
constexpr std::size_t kMaxAnnounced = 64;
// That a status does not count yet: a window of the line, and a block more.
constexpr std::uint32_t kTicksUnderWay = 33 * link::kMaxHeadTicks;
// On a piece at rest nothing is predicted, so more can be sent ahead.
constexpr double kRestAheadSeconds = 0.2;

std::string FaultOf(HeadRunState state) {
  switch (state) {
    case HeadRunState::kUnderrun:
      return "ticks came too late to the scan head: the computer is too busy; give a "
             "greater scan_head.ahead_ms in the profile";
    case HeadRunState::kInterlocked:
      return "key, door or stop button ended the beam: close them, then reset";
    case HeadRunState::kNoPermit:
      return "the scan head was not permitted to mark for 250 ms and ended the beam: "
             "reset and begin again";
    case HeadRunState::kBadBlock:
      return "the scan head refused a block of ticks: report it with the logs";
    default:
      return {};
  }
}

class GalvoDriver final : public MarkDriver {
 public:
  GalvoDriver(const MachineSpec& machine,
              std::optional<galvo::CorrectionTable> correction, std::string broken,
              link::StreamOpener open, link::SteadyClock clock)
      : head_(machine.scan_head()),
        expected_{machine.mark_line().serial_number(), "scan head", machine.name(),
                  machine.mark_line().device(), "mark_line"},
        broken_(std::move(broken)),
        clock_(clock),
        session_(std::move(open), std::move(clock)),
        player_(machine.scan_head(), std::move(correction)) {}

  void Poll() override;
  int fd() const override { return session_.fd(); }
  const MarkDeviceState& state() const override { return state_; }
  std::vector<MarkEvent> TakeEvents() override;
  Status Permit(bool permitted) override;
  Status Begin(std::uint32_t run, std::span<const mark::Pen> pens) override;
  std::size_t Room() const override {
    return active_ && !ending_ ? kMaxWaitingMarks - waiting_.size() : 0;
  }
  Status Append(const NumberedMark& mark) override;
  Status Finish() override;
  Status Pause() override;
  Status Stop() override;
  Status Reset() override;
  Status RequestPast(std::uint32_t run, std::uint32_t first,
                     std::uint32_t count) override;

 private:
  void Handle(HeadFrame type, std::span<const std::byte> payload);
  void Identify(std::span<const std::byte> payload);
  void Refuse(const std::string& why);
  void TakeStatus(const link::HeadStatus& status);
  void TakeMarks(const link::HeadMarks& marks);
  void TakePast(const link::HeadPast& past);
  void BeginSession();
  void EndRun(const std::string& fault);
  void DropWaiting();
  void Announce();
  void Pump();
  bool SendNext();
  void StopFor(const std::string& fault);
  std::uint64_t TickNow() const;
  Status SendFrame(HeadFrame type, const link::Bytes& payload = {});
  Status SendDrop(HeadFrame type, const link::Bytes& payload = {});
  void UpdateState();

  ScanHead head_;
  link::ExpectedDevice expected_;
  std::string broken_;  // of the profile: nothing is sent
  link::SteadyClock clock_;
  link::LineSession session_;
  MarkPlayer player_;
  MarkDeviceState state_;
  std::string refusal_, fault_;
  bool identified_ = false, identified_now_ = false;
  std::uint32_t polled_sessions_ = 0;
  link::HeadIdentity identity_;
  link::HeadStatus status_;
  std::uint64_t statuses_ = 0;
  std::chrono::nanoseconds status_at_{0};
  std::uint32_t drops_sent_ = 0;
  std::uint32_t credit_ = 0;  // ticks, of the newest status
  std::vector<MarkEvent> events_;

  bool active_ = false;     // a run was begun and has not ended
  bool finishing_ = false;  // Finish was called
  bool finish_sent_ = false;
  bool ending_ = false;  // Pause, Stop, or a fault of its own
  std::uint32_t run_ = 0;
  std::deque<NumberedMark> waiting_;  // the first announced_ of them with kBegun
  std::size_t announced_ = 0, taken_ = 0;
  std::map<std::uint32_t, bool> open_;  // marks that are not ended; begun here
  std::uint64_t next_tick_ = 0;         // of a web
};

void GalvoDriver::Poll() {
  session_.Poll([this](std::uint8_t type, std::span<const std::byte> payload) {
    Handle(static_cast<HeadFrame>(type), payload);
  });
  if (session_.sessions() != polled_sessions_) {
    polled_sessions_ = session_.sessions();
    identified_ = identified_now_;
  }
  identified_now_ = false;
  if (!session_.up()) refusal_.clear();
  UpdateState();
  if (active_ && state_.link_up) Pump();
}

void GalvoDriver::UpdateState() {
  state_.link_up = session_.up() && identified_ && statuses_ > 0 && broken_.empty();
  state_.refusal = broken_.empty() ? refusal_ : broken_;
  state_.message = state_.refusal.empty() ? session_.message() : state_.refusal;
  state_.taken_over = session_.fenced();
  state_.at_rest = state_.settled = !active_;
  state_.fault = fault_;
  state_.web_mm_s = player_.tracker().speed_mm_s();
  if (!state_.link_up) state_.shutter_open = false;
}

void GalvoDriver::Identify(std::span<const std::byte> payload) {
  const auto identity = link::Decode<link::HeadIdentity>(payload);
  if (!identity) return Refuse(identity.error().message + ": " + expected_.VersionHint());
  if (const auto why = link::RefusalOf(expected_, identity->serial_number); !why.empty())
    return Refuse(why);
  if (identity->field_mm != head_.field_mm()) {
    return Refuse(fmt::format(
        "the scan head at {} has a field of {} mm, the profile one of {} mm: correct "
        "scan_head.field_mm",
        expected_.device, identity->field_mm, head_.field_mm()));
  }
  identity_ = *identity;
  refusal_.clear();
  BeginSession();
}

// What was sent in another session was dropped by the controller. What became of it
// RequestPast tells; what was not sent was not begun.
void GalvoDriver::BeginSession() {
  identified_ = identified_now_ = true;
  statuses_ = 0;
  drops_sent_ = 0;
  ++state_.session;
  state_.power_up = fmt::format("{}-{:08x}", identity_.serial_number, identity_.power_up);
  state_.remembers_marks = identity_.remembered_marks >= kRememberedMarks;
  player_.SetRate(identity_.rate_hz);
  player_.tracker().Forget();
  if (!active_) return;
  DropWaiting();
  open_.clear();
  EndRun(
      "the line to the scan head was lost during the run: ask what became of its "
      "marks, reset and begin again");
}

// Its own host may have left it permitted when the cables were swapped.
void GalvoDriver::Refuse(const std::string& why) {
  refusal_ = why;
  identified_ = false;
  (void)session_.Send(static_cast<std::uint8_t>(HeadFrame::kHeadStop), {});
}

void GalvoDriver::Handle(HeadFrame type, std::span<const std::byte> payload) {
  if (type == HeadFrame::kHeadIdentity) return Identify(payload);
  if (!identified_ || !broken_.empty()) return;
  if (type == HeadFrame::kHeadStatus) {
    if (const auto m = link::Decode<link::HeadStatus>(payload)) TakeStatus(*m);
  } else if (type == HeadFrame::kHeadMarks) {
    if (const auto m = link::Decode<link::HeadMarks>(payload)) TakeMarks(*m);
  } else if (type == HeadFrame::kHeadWeb) {
    if (const auto m = link::Decode<link::HeadWeb>(payload))
      player_.tracker().Take(*m, identity_.rate_hz);
  } else if (type == HeadFrame::kHeadPast) {
    if (const auto m = link::Decode<link::HeadPast>(payload)) TakePast(*m);
  }
}

void GalvoDriver::TakeStatus(const link::HeadStatus& status) {
  status_ = status;
  status_at_ = clock_();
  state_.number = ++statuses_;
  const auto has = [&](int bit) { return (status.interlocks & bit) != 0; };
  state_.key_on = has(link::kHeadKeyOn);
  state_.door_closed = has(link::kHeadDoorClosed);
  state_.stop_released = has(link::kHeadStopReleased);
  state_.shutter_open = has(link::kHeadShutterOpen);
  state_.safe_state = has(link::kHeadSafeState);
  state_.openings = status.openings;
  const double step_mm = head_.field_mm() / 65536;
  state_.position_mm =
      Vec3(step_mm * (status.x - 32768.0), step_mm * (status.y - 32768.0), 0);
  // What is still under way to it counts against its credit.
  credit_ = status.free_ticks;
  if (!active_ || status.run != run_ || status.run_state == HeadRunState::kOpen ||
      status.run_state == HeadRunState::kNone)
    return;
  EndRun(FaultOf(status.run_state));
}

void GalvoDriver::TakeMarks(const link::HeadMarks& marks) {
  if (marks.run != run_) return;
  for (const link::HeadMarkEvent& event : marks.events) {
    if (event.fate == link::HeadMarkFate::kBegun || open_.erase(event.mark) == 0)
      continue;
    events_.push_back({run_, event.mark,
                       event.fate == link::HeadMarkFate::kDone ? MarkFate::kDone
                       : event.fate == link::HeadMarkFate::kBroken
                           ? MarkFate::kBroken
                           : MarkFate::kNotBegun});
  }
}

void GalvoDriver::TakePast(const link::HeadPast& past) {
  static constexpr MarkFate kFates[] = {MarkFate::kBegun, MarkFate::kDone,
                                        MarkFate::kBroken, MarkFate::kNotBegun,
                                        MarkFate::kUncertain};
  for (std::size_t i = 0; i < past.fates.size(); ++i) {
    events_.push_back({past.run, past.first_mark + static_cast<std::uint32_t>(i),
                       kFates[static_cast<std::size_t>(past.fates[i])]});
  }
}

// The controller's reports of marks come before the status that ends the run: what is
// still open was never begun.
void GalvoDriver::EndRun(const std::string& fault) {
  for (const auto& [mark, announced] : open_)
    events_.push_back({run_, mark, MarkFate::kNotBegun});
  open_.clear();
  waiting_.clear();
  announced_ = taken_ = 0;
  active_ = finishing_ = finish_sent_ = ending_ = false;
  if (fault_.empty()) fault_ = fault;
}

void GalvoDriver::DropWaiting() {
  for (const NumberedMark& mark : waiting_) {
    if (open_.erase(mark.number) != 0)
      events_.push_back({run_, mark.number, MarkFate::kNotBegun});
  }
  waiting_.clear();
  announced_ = taken_ = 0;
}

std::vector<MarkEvent> GalvoDriver::TakeEvents() {
  taken_ = announced_;
  return std::exchange(events_, {});
}

Status GalvoDriver::SendFrame(HeadFrame type, const link::Bytes& payload) {
  if (!identified_ || !broken_.empty())
    return Fail(ErrorCode::kLinkLost,
                state_.message.empty() ? "the line is not open yet" : state_.message);
  return session_.Send(static_cast<std::uint8_t>(type), payload);
}

Status GalvoDriver::SendDrop(HeadFrame type, const link::Bytes& payload) {
  INTAGLIO_TRY(SendFrame(type, payload));
  ++drops_sent_;
  return {};
}

Status GalvoDriver::Permit(bool permitted) {
  const link::Bytes payload = Encode(link::HeadPermit{permitted});
  if (permitted) return SendFrame(HeadFrame::kHeadPermit, payload);
  ending_ = active_;
  return SendDrop(HeadFrame::kHeadPermit, payload);
}

Status GalvoDriver::Begin(std::uint32_t run, std::span<const mark::Pen> pens) {
  if (!state_.link_up) return Fail(ErrorCode::kLinkLost, state_.message);
  if (active_) return Fail(ErrorCode::kRefused, "the run before has not ended; wait");
  if (!fault_.empty()) return Fail(ErrorCode::kRefused, fault_);
  if (state_.safe_state) {
    return Fail(ErrorCode::kRefused,
                "the scan head is in its safe state: close key, door and stop button, "
                "then reset");
  }
  INTAGLIO_TRY(mark::CheckMarks({{pens.begin(), pens.end()}, {}}));
  INTAGLIO_TRY(SendFrame(HeadFrame::kHeadBegin, Encode(link::HeadBegin{run})));
  run_ = run;
  active_ = true;
  finishing_ = finish_sent_ = ending_ = false;
  next_tick_ = 0;
  player_.Begin(pens, state_.position_mm.head<2>());
  UpdateState();
  return {};
}

Status GalvoDriver::Append(const NumberedMark& mark) {
  if (!active_ || ending_ || finishing_)
    return Fail(ErrorCode::kRefused, "there is no run that takes marks; begin one");
  if (Room() == 0) return Fail(ErrorCode::kRefused, "no room for a mark; wait");
  if (open_.contains(mark.number))
    return Fail(ErrorCode::kRefused,
                fmt::format("mark {} was appended already", mark.number));
  INTAGLIO_TRY(player_.Check(mark));
  waiting_.push_back(mark);
  open_[mark.number] = false;
  return {};
}

Status GalvoDriver::Finish() {
  if (!active_) return Fail(ErrorCode::kRefused, "there is no run to finish");
  finishing_ = true;
  return {};
}

Status GalvoDriver::Pause() {
  if (!active_) return {};
  INTAGLIO_TRY(SendDrop(HeadFrame::kHeadPause));
  ending_ = true;
  return {};
}

Status GalvoDriver::Stop() {
  ending_ = active_;
  return SendDrop(HeadFrame::kHeadStop);
}

Status GalvoDriver::Reset() {
  INTAGLIO_TRY(SendDrop(HeadFrame::kHeadReset));
  fault_.clear();
  return {};
}

Status GalvoDriver::RequestPast(std::uint32_t run, std::uint32_t first,
                                std::uint32_t count) {
  while (count > 0) {
    const auto part =
        static_cast<std::uint16_t>(std::min<std::uint32_t>(count, link::kMaxHeadPast));
    INTAGLIO_TRY(SendFrame(HeadFrame::kHeadPastRequest,
                           Encode(link::HeadPastRequest{run, first, part})));
    first += part;
    count -= part;
  }
  return {};
}

void GalvoDriver::StopFor(const std::string& fault) {
  fault_ = fault;
  (void)Stop();
}

void GalvoDriver::Announce() {
  while (announced_ < waiting_.size() && announced_ < kMaxAnnounced) {
    events_.push_back({run_, waiting_[announced_].number, MarkFate::kBegun});
    open_[waiting_[announced_].number] = true;
    ++announced_;
  }
}

/// In real time it goes on since the newest status.
std::uint64_t GalvoDriver::TickNow() const {
  if (identity_.lockstep) return status_.tick;
  const double since_s = std::chrono::duration<double>(clock_() - status_at_).count();
  return status_.tick + static_cast<std::uint64_t>(since_s * identity_.rate_hz);
}

void GalvoDriver::Pump() {
  if (!ending_) Announce();
  while (!ending_ && SendNext()) {
  }
  if (ending_ || !finishing_ || finish_sent_ || !waiting_.empty() || player_.playing())
    return;
  finish_sent_ = SendFrame(HeadFrame::kHeadFinish).has_value();
}

/// False: nothing more for now.
bool GalvoDriver::SendNext() {
  if (!session_.CanSend() || credit_ < kTicksUnderWay) return false;
  const bool web = player_.tracker().follows();
  double ahead_s = 1e-3 * (head_.has_ahead_ms() ? head_.ahead_ms() : kDefaultAheadMs);
  if (!web) ahead_s = std::max(ahead_s, kRestAheadSeconds);
  const auto ahead = static_cast<std::uint64_t>(ahead_s * identity_.rate_hz);
  // Time for the line, of a web; in lockstep time waits.
  const std::uint64_t now = TickNow();
  const std::uint64_t first =
      std::max(next_tick_, now + 1 + (identity_.lockstep ? 0 : ahead / 2));
  if (web ? first >= now + ahead : identity_.queue_ticks - credit_ > ahead) return false;
  if (!player_.playing()) {
    if (taken_ == 0) return false;
    const Status loaded = player_.Load(waiting_.front());
    if (!loaded) {
      StopFor(loaded.error().message);
      return false;
    }
    waiting_.pop_front();
    --announced_;
    --taken_;
  }
  auto next = player_.NextBlock(player_.placed() ? next_tick_ : first);
  if (!next) {
    StopFor(next.error().message);
    return false;
  }
  const bool holds = !next->has_value();
  if (holds && !identity_.lockstep) return false;
  link::HeadBlock block = holds ? player_.Hold(first) : std::move(**next);
  block.run = run_;
  if (!SendFrame(HeadFrame::kHeadBlock, Encode(block))) return false;
  credit_ -= static_cast<std::uint32_t>(block.ticks.size());
  if (web) next_tick_ = block.first_tick + block.ticks.size();
  if (!holds) player_.Took(block);
  return true;
}

}  // namespace

std::unique_ptr<MarkDriver> MakeGalvoDriver(const MachineSpec& machine,
                                            link::StreamOpener open,
                                            link::SteadyClock clock) {
  auto correction = LoadCorrection(machine.scan_head());
  std::string broken = correction ? "" : correction.error().message;
  return std::make_unique<GalvoDriver>(
      machine, correction ? std::move(*correction) : std::nullopt, std::move(broken),
      std::move(open), std::move(clock));
}

}  // namespace intaglio::drivers
