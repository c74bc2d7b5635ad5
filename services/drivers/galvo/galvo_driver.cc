#include "services/drivers/galvo/galvo_driver.h"

#include <fmt/format.h>

#include <utility>

#include "engrave/core/try.h"
#include "services/job/head/head_correction.h"

namespace intaglio::drivers {
namespace {

using link::HeadFrame;
using link::HeadRunState;

// Marks that wait here.
constexpr std::size_t kMaxWaitingMarks = 256;
constexpr std::chrono::milliseconds kPermitPeriod{20};

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
    case HeadRunState::kOutside:
      return "the web ran so unevenly that a mark left the field: let it run slower or "
             "more "
             "evenly, or keep marks farther from the border";
    default:
      return {};
  }
}

}  // namespace

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
  if (permit_due_ && identified_ && session_.CanSend()) (void)Permit(true);
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
  state_.print_text = PrintText();
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
  permit_due_ = false;
  ++state_.session;
  state_.power_up = link::HeadPowerUpText(identity_.serial_number, identity_.power_up);
  state_.can_hold = identity_.lockstep;
  state_.remembers_marks = identity_.remembered_marks >= kRememberedMarks;
  player_.SetRate(identity_.rate_hz);
  player_.tracker().Forget();
  prints_.Forget();
  next_print_.reset();
  begin_tick_ = 0;
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
    if (const auto m = link::Decode<link::HeadWeb>(payload)) TakeWeb(*m);
  } else if (type == HeadFrame::kHeadPrint) {
    if (const auto m = link::Decode<link::HeadPrint>(payload)) TakePrint(*m);
  } else if (type == HeadFrame::kHeadPast) {
    if (const auto m = link::Decode<link::HeadPast>(payload)) TakePast(*m);
  }
}

void GalvoDriver::TakeWeb(const link::HeadWeb& web) {
  HeadTracker& tracker = player_.tracker();
  tracker.Receive(web, identity_.rate_hz);
  prints_.PassTo(static_cast<double>(web.samples.back().encoder_count) *
                 tracker.count_mm());
}

void GalvoDriver::TakePrint(const link::HeadPrint& print) {
  ExpectPrint(print.first);
  for (const link::HeadPrintMark& mark : print.marks)
    prints_.See(mark.count * player_.tracker().count_mm(), mark.tick > begin_tick_);
  next_print_ = print.first + static_cast<std::uint32_t>(print.marks.size());
}

void GalvoDriver::ExpectPrint(std::uint32_t number) {
  const bool lost = next_print_ && *next_print_ != number;
  next_print_ = number;
  if (lost && active_ && eye_ && !ending_) {
    StopFor(
        "print marks that the photo eye has seen were lost on the line: report it with "
        "the logs, then resume");
  }
}

std::string GalvoDriver::PrintText() const {
  if (!eye_ || (prints_.ignored_count() == 0 && skipped_.empty())) return {};
  return fmt::format("print marks ignored, away from their expected places: {}{}",
                     prints_.ignored_count(),
                     skipped_.empty() ? "" : "; left out without one: " + skipped_);
}

void GalvoDriver::TakeStatus(const link::HeadStatus& status) {
  ExpectPrint(status.prints);
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
  state_.newest_run = status.run;
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
  active_ = finishing_ = finish_sent_ = ending_ = pausing_ = held_ = false;
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
  if (permitted) {
    held_ = false;
    // The line is for blocks, however often the host repeats it.
    if (state_.shutter_open && clock_() - permitted_at_ < kPermitPeriod) return {};
    // Blocks would take each place that becomes free before the next turn of the host.
    permit_due_ = identified_ && !session_.CanSend();
    if (permit_due_) return {};
    permitted_at_ = clock_();
    return SendFrame(HeadFrame::kHeadPermit, payload);
  }
  ending_ = active_;
  permit_due_ = false;
  permitted_at_ = {};
  return SendDrop(HeadFrame::kHeadPermit, payload);
}

Status GalvoDriver::Hold() {
  if (!identity_.lockstep) return MarkDriver::Hold();
  if (!active_ || ending_) return Fail(ErrorCode::kRefused, "there is no run to hold");
  held_ = true;
  return {};
}

Status GalvoDriver::UseEye(const std::optional<PrintEye>& eye) {
  if (eye && !head_.has_eye_mm()) return MarkDriver::UseEye(eye);
  if (eye && !identity_.has_eye) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("marks.web.eye: the controller at {} reports no photo eye; "
                            "connect one, or remove scan_head.eye_mm from the profile",
                            expected_.device));
  }
  eye_ = eye;
  return {};
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
  finishing_ = finish_sent_ = ending_ = pausing_ = false;
  next_tick_ = 0;
  player_.Begin(pens, state_.position_mm.head<2>());
  if (eye_) prints_.Begin(*eye_);
  begin_tick_ = TickNow();
  skipped_.clear();
  skipped_count_ = 0;
  UpdateState();
  return {};
}

std::size_t GalvoDriver::Room() const {
  return active_ && !ending_ && !pausing_ ? kMaxWaitingMarks - waiting_.size() : 0;
}

Status GalvoDriver::Append(const NumberedMark& mark) {
  if (!active_ || ending_ || pausing_ || finishing_)
    return Fail(ErrorCode::kRefused, "there is no run that takes marks; begin one");
  if (Room() == 0) return Fail(ErrorCode::kRefused, "no room for a mark; wait");
  if (open_.contains(mark.number))
    return Fail(ErrorCode::kRefused,
                fmt::format("mark {} was appended already", mark.number));
  if (eye_ && RepeatOf(mark.mark.web_mm, eye_->pitch_mm) < eye_->first_repeat) {
    return Fail(
        ErrorCode::kRefused,
        fmt::format("mark {} is of a repeat before the run's first", mark.number));
  }
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
  pausing_ = true;
  return {};
}

Status GalvoDriver::Stop() {
  ending_ = active_;
  permit_due_ = false;
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
