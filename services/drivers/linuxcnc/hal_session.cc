#include "services/drivers/linuxcnc/hal_session.h"

#include <fmt/format.h>

#include <array>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/drivers/linuxcnc/hal_folder.h"

namespace intaglio::drivers {
namespace {

using std::chrono::milliseconds;
constexpr milliseconds kOpenPeriod{200}, kSilence{250}, kHeartbeat{10};
// What an opening may take until samples come, and the sampler's old ones are read.
constexpr milliseconds kOpeningTime{2000}, kOldSamples{40};
constexpr std::size_t kMaxLine = 4096;
constexpr std::uint64_t kMaxRecord = 1ull << 32;

std::uint64_t TimeOfDay_ms() {
  return static_cast<std::uint64_t>(
      std::chrono::duration_cast<milliseconds>(
          std::chrono::system_clock::now().time_since_epoch())
          .count());
}

}  // namespace

HalSession::HalSession(HalOpener open, std::filesystem::path folder,
                       link::ExpectedDevice expected, link::SteadyClock clock,
                       HalLaser laser)
    : open_(std::move(open)),
      folder_(std::move(folder)),
      expected_(std::move(expected)),
      clock_(std::move(clock)),
      laser_(laser) {}

const std::vector<HalSample>& HalSession::Poll() {
  samples_.clear();
  if (fenced_) return samples_;
  const auto now = clock_();
  if (phase_ == Phase::kClosed) Open(now);
  if (phase_ == Phase::kClosed) return samples_;
  Read(now);
  if (phase_ == Phase::kOpening) {
    if (!greeted_ && has_sample_ && now - opened_at_ > kOldSamples) Hello();
    if (now - opened_at_ > kOpeningTime) Lose("LinuxCNC's HAL does not answer");
  } else if (phase_ == Phase::kUp && now - sampled_at_ > kSilence) {
    Lose("LinuxCNC's HAL reports nothing any more: start it with deploy/linuxcnc/start");
  }
  if (line_ && greeted_ && now - beaten_at_ >= kHeartbeat) (void)Send();
  if (phase_ != Phase::kUp) samples_.clear();
  return samples_;
}

void HalSession::Open(std::chrono::nanoseconds now) {
  if (now < next_open_) return;
  next_open_ = now + kOpenPeriod;
  const auto identity = ReadHalIdentity(folder_, expected_.line);
  if (!identity && identity.error().code == ErrorCode::kNotFound) {
    refusal_.clear();
    message_ = identity.error().message;
    return;
  }
  refusal_ = identity ? WhyRefused(*identity) : identity.error().message;
  if (!refusal_.empty()) {
    message_ = refusal_;
    return;
  }
  auto line = open_();
  if (!line) {
    message_ = line.error().message;
    return;
  }
  identity_ = *identity;
  line_ = std::move(*line);
  phase_ = Phase::kOpening;
  greeted_ = has_sample_ = false;
  partial_.clear();
  opened_at_ = sampled_at_ = now;
}

std::string HalSession::WhyRefused(const HalIdentity& identity) const {
  if (identity.laser == laser_) return link::RefusalOf(expected_, identity.serial_number);
  return fmt::format(
      "the HAL in {} was started {} --beam, and the protocol of {} wants one {} it: "
      "start it again so with deploy/linuxcnc/start",
      folder_.string(), laser_ == HalLaser::kBeam ? "without" : "with", expected_.line,
      laser_ == HalLaser::kBeam ? "with" : "without");
}

void HalSession::Lose(std::string why) {
  line_.reset();
  phase_ = Phase::kClosed;
  message_ = "LinuxCNC: " + std::move(why);
}

void HalSession::Read(std::chrono::nanoseconds now) {
  std::array<char, 16384> buffer;
  while (line_) {
    const auto count = line_->ReadSamples(buffer);
    if (!count) return Lose(count.error().message);
    if (*count == 0) return;
    partial_.append(buffer.data(), *count);
    std::string_view rest = partial_;
    for (auto end = rest.find('\n'); end != std::string_view::npos;
         end = rest.find('\n')) {
      if (const auto sample = ParseSample(rest.substr(0, end))) {
        sampled_at_ = now;
        Receive(*sample);
      }
      if (!line_) return;
      rest.remove_prefix(end + 1);
    }
    partial_.erase(0, partial_.size() - rest.size());
    if (partial_.size() > kMaxLine) return Lose("halsampler prints no lines");
  }
}

void HalSession::Receive(const HalSample& sample) {
  newest_ = sample;
  has_sample_ = true;
  if (!greeted_) return;
  if (sample.command > command_.number) {
    fenced_ = true;
    return Lose("a newer host has taken the controller over");
  }
  if (sample.command < first_number_) return;
  if (phase_ == Phase::kOpening && RecordIsWhole()) Begin();
  if (phase_ == Phase::kUp) samples_.push_back(sample);
}

// Nothing of the time before is obeyed any more: rows that wait in HAL's stream neither
// fire nor move anything. The lamp and its rate stay as they are.
void HalSession::Hello() {
  const std::uint64_t number = std::max(TimeOfDay_ms(), newest_.command + 1000);
  command_ = {};
  command_.lamp = newest_.Has(kHalLamp);
  command_.periods = newest_.periods;
  command_.number = first_number_ = number;
  command_.arm = command_.motion = number;
  greeted_ = true;
  (void)Send();
}

// Nothing fires from the first answer on, so the record that has as many pulses as HAL
// has counted is complete.
bool HalSession::RecordIsWhole() {
  if (laser_ == HalLaser::kBeam) return true;
  const auto text = io::ReadWholeFile(folder_ / "pulses", kMaxRecord);
  if (!text) return false;
  record_ = ParsePulses(*text);
  return record_.size() == newest_.pulses;
}

void HalSession::Begin() {
  phase_ = Phase::kUp;
  ++sessions_;
  message_.clear();
}

Status HalSession::Send() {
  if (!line_ || fenced_) return Fail(ErrorCode::kLinkLost, message_);
  ++command_.number;
  command_.heartbeat = !command_.heartbeat;
  beaten_at_ = clock_();
  std::string text;
  AppendText(command_, text);
  auto written = line_->WriteCommands(text);
  if (!written) Lose(written.error().message);
  return written;
}

Status HalSession::NextArm() {
  if (!up()) return Fail(ErrorCode::kLinkLost, message_);
  ++command_.arm;
  return Send();
}
Status HalSession::NextMotion() {
  if (!up()) return Fail(ErrorCode::kLinkLost, message_);
  ++command_.motion;
  return Send();
}
Status HalSession::SetStop(bool on) {
  if (!up()) return Fail(ErrorCode::kLinkLost, message_);
  command_.stop = on;
  if (on) command_.shutter = false;
  return Send();
}
Status HalSession::SetShutter(bool open) {
  if (!up()) return Fail(ErrorCode::kLinkLost, message_);
  command_.shutter = open;
  return Send();
}
Status HalSession::SetLamp(bool on) {
  if (!up()) return Fail(ErrorCode::kLinkLost, message_);
  command_.lamp = on;
  return Send();
}

Status HalSession::SetPeriods(std::uint32_t periods) {
  if (!up()) return Fail(ErrorCode::kLinkLost, message_);
  command_.periods = periods;
  return Send();
}

Status HalSession::ResetLaser() {
  command_.shutter = command_.stop = false;
  return Reset({&HalCommand::laser_reset});
}
Status HalSession::ResetMotion() { return Reset({&HalCommand::motion_reset}); }
Status HalSession::ResetBoth() {
  command_.shutter = command_.stop = false;
  return Reset({&HalCommand::laser_reset, &HalCommand::motion_reset});
}

// An edge of the bit that switches the lamp of a laser that is pulsed.
Status HalSession::MakePermission() {
  INTAGLIO_TRY(SetLamp(true));
  return SetLamp(false);
}

// The watchdog first, if it has tripped: it wants two heartbeats before a latch takes its
// reset. HAL plays one command a period.
Status HalSession::Reset(std::initializer_list<bool HalCommand::*> latches) {
  if (!up()) return Fail(ErrorCode::kLinkLost, message_);
  if (!newest_.Has(kHalHostAlive)) {
    command_.wake = true;
    (void)Send();
    command_.wake = false;
  }
  for (int beat = 0; beat < 3; ++beat) (void)Send();
  for (const auto latch : latches) command_.*latch = true;
  (void)Send();
  for (const auto latch : latches) command_.*latch = false;
  return Send();
}

Status HalSession::WriteRows(std::string_view rows) {
  if (!up()) return Fail(ErrorCode::kLinkLost, message_);
  auto written = line_->WriteRows(rows);
  if (!written) Lose(written.error().message);
  return written;
}

}  // namespace intaglio::drivers
