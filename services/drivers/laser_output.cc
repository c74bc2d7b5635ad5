#include "services/drivers/laser_output.h"

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"

namespace intaglio::drivers {
namespace {

using link::LaserFrame;
using namespace std::chrono_literals;

constexpr auto kStatusPeriod = 20ms;
// The host may be silent for this time while the laser may fire.
constexpr auto kSilenceLimit = 250ms;
// As of a TCP line (tcp_stream.h): then another host may come.
constexpr auto kHostIsGone = 2s;
// More than a host sends ahead; a driver that takes none for so long is no laser.
constexpr std::size_t kMaxCommands = 256;
// A driver takes what it has no room for within a turn or two of its line. What it
// refuses for longer it refuses for good, until a Reset.
constexpr auto kRoomPatience = kSilenceLimit;
constexpr std::size_t kMaxOutgoing = 4096;

}  // namespace

LaserOutput::LaserOutput(LaserController& laser, link::SteadyClock clock)
    : laser_(laser), clock_(std::move(clock)) {}

void LaserOutput::Plug(std::unique_ptr<link::ByteStream> end) {
  Unplug();
  link_ = std::make_unique<link::ReliableLink>(link::Side::kDevice, std::move(end),
                                               clock_, link::LinkOptions{}, epoch_);
  link_session_ = 0;
}

void LaserOutput::Unplug() {
  link_.reset();
  serving_ = false;
  outgoing_.clear();
  EnterSafeState();
}

void LaserOutput::Close() {
  Unplug();
  if (laser_.CanSend()) (void)laser_.Lamp(false, laser_.status().rate_hz);
}

void LaserOutput::EnterSafeState() {
  safe_state_ = true;
  close_owed_ = true;
  commands_.clear();
  refused_at_.reset();
  CloseLaser();
}

void LaserOutput::CloseLaser() {
  if (stop_owed_ && laser_.CanSend()) stop_owed_ = !laser_.Stop();
  if (close_owed_ && laser_.CanSend())
    close_owed_ = !(laser_.OpenShutters(0) && laser_.Disarm());
  if (disarm_owed_ && laser_.CanSend()) disarm_owed_ = !laser_.Disarm();
}

void LaserOutput::PollLaser() {
  laser_.Poll(
      [this](const link::PulseReport& report) {
        if (serving_) Send(LaserFrame::kPulseReport, Encode(report));
      },
      [this](const link::PastReport& report) {
        if (serving_) Send(LaserFrame::kPastReport, Encode(report));
      });
  FollowLaser();
}

void LaserOutput::Poll() {
  PollLaser();
  if (link_) PollHost();
  CloseLaser();
  PassCommandsOn();
  PollLaser();  // what was commanded leaves now, and not after the caller's next wait
  if (!link_) return;
  Identify();
  SendStatus();
  Flush();
  PollHost();  // what was sent leaves now
}

// A session of the laser is one of the host, too: what was sent may be lost.
void LaserOutput::FollowLaser() {
  if (laser_.up() && laser_.session() == laser_session_) return;
  if (laser_.up()) laser_session_ = laser_.session();
  if (link_) {
    Unplug();
  } else {
    close_owed_ = true;
  }
}

void LaserOutput::PollHost() {
  const auto polled =
      link_->Poll([this](std::uint8_t type, std::span<const std::byte> payload) {
        if (link_->session() != link_session_) BeginSession();
        Receive(static_cast<LaserFrame>(type), payload);
      });
  if (!polled || link_->silence() > kHostIsGone || outgoing_.size() > kMaxOutgoing ||
      commands_.size() > kMaxCommands) {
    return Unplug();
  }
  if (link_->up() && link_->session() != link_session_) BeginSession();
  if (link_->silence() > kSilenceLimit && !safe_state_) EnterSafeState();
}

// The host knows nothing of what was decided before, and counts its Disarms anew.
void LaserOutput::BeginSession() {
  link_session_ = link_->session();
  serving_ = false;
  outgoing_.clear();
  commands_.clear();
  refused_at_.reset();
  disarms_taken_ = disarms_confirmed_ = disarms_sent_ = 0;
  disarm_owed_ = true;
  status_number_ = 0;
  CloseLaser();
}

void LaserOutput::Identify() {
  if (serving_ || !link_->up() || link_->session() != link_session_) return;
  if (close_owed_ || disarm_owed_ || !laser_.disarmed()) return;
  serving_ = true;
  status_asked_ = true;
  Send(LaserFrame::kLaserIdentity, Encode(laser_.identity()));
}

void LaserOutput::Receive(LaserFrame type, std::span<const std::byte> payload) {
  switch (type) {
    case LaserFrame::kDisarm:
    case LaserFrame::kLaserStop:
      return TakeAtOnce(type);
    case LaserFrame::kLaserStatusRequest:
      status_asked_ = true;
      return;
    case LaserFrame::kShutterCommand:
      // The newest is what holds, and closing waits for nothing.
      std::erase_if(commands_, [](const Frame& frame) {
        return frame.type == LaserFrame::kShutterCommand;
      });
      refused_at_.reset();
      if (const auto shutter = link::Decode<link::ShutterCommand>(payload);
          shutter && shutter->open_mask == 0 && laser_.OpenShutters(0)) {
        return;
      }
      return Queue(type, payload);
    default:
      return Queue(type, payload);
  }
}

void LaserOutput::TakeAtOnce(LaserFrame type) {
  std::erase_if(commands_,
                [](const Frame& frame) { return frame.type == LaserFrame::kArmWindow; });
  refused_at_.reset();
  if (type == LaserFrame::kDisarm) {
    ++disarms_taken_;
    disarm_owed_ = true;
  } else {
    stop_owed_ = true;
  }
  CloseLaser();
}

void LaserOutput::Queue(LaserFrame type, std::span<const std::byte> payload) {
  commands_.push_back({type, {payload.begin(), payload.end()}});
}

void LaserOutput::PassCommandsOn() {
  while (!commands_.empty() && !close_owed_ && !disarm_owed_ && !stop_owed_ &&
         laser_.CanSend()) {
    if (!PassOn(commands_.front()) && !MustGiveUp()) return;
    refused_at_.reset();
    commands_.pop_front();
  }
}

// The first command was refused. It is repeated for a while, but it never keeps a Reset
// from the laser, which may be what it waits for.
bool LaserOutput::MustGiveUp() {
  if (!refused_at_) refused_at_ = clock_();
  const bool reset_waits = std::any_of(
      commands_.begin() + 1, commands_.end(),
      [](const Frame& frame) { return frame.type == LaserFrame::kLaserReset; });
  if (!reset_waits && clock_() - *refused_at_ < kRoomPatience) return false;
  if (commands_.front().type == LaserFrame::kArmWindow)
    ReportDark(commands_.front(), link::TickOutcome::kTooLate);
  return true;
}

bool LaserOutput::PassOn(const Frame& command) {
  if (command.type == LaserFrame::kPastRequest) {
    const auto asked = link::Decode<link::PastRequest>(command.payload);
    return !asked || laser_.RequestPast(asked->first_tick, asked->count);
  }
  const Status obeyed = Obey(command);
  if (!obeyed && obeyed.error().code == ErrorCode::kRefused) return false;
  if (!obeyed && command.type == LaserFrame::kArmWindow) {
    ReportDark(command, obeyed.error().code == ErrorCode::kUnsupported
                            ? link::TickOutcome::kEnergyOutside
                            : link::TickOutcome::kTooLate);
  }
  return true;
}

// A frame that cannot be read commands nothing.
Status LaserOutput::Obey(const Frame& command) {
  switch (command.type) {
    case LaserFrame::kLampCommand:
      if (const auto lamp = link::Decode<link::LampCommand>(command.payload))
        return laser_.Lamp(lamp->on, lamp->rate_hz);
      return {};
    case LaserFrame::kShutterCommand:
      if (const auto shutter = link::Decode<link::ShutterCommand>(command.payload))
        return laser_.OpenShutters(safe_state_ ? 0 : shutter->open_mask);
      return {};
    case LaserFrame::kArmWindow:
      if (const auto window = link::Decode<link::ArmWindow>(command.payload);
          window && !safe_state_ && !window->fire.empty()) {
        INTAGLIO_TRY(CheckEnergy(laser_.identity(), *window));
        return laser_.Arm(*window);
      }
      return {};
    case LaserFrame::kLaserReset: {
      auto reset = laser_.Reset();
      if (reset) safe_state_ = false;
      return reset;
    }
    default:
      return {};
  }
}

// The driver takes it never: it fires nothing, and its points are known at once.
void LaserOutput::ReportDark(const Frame& command, link::TickOutcome outcome) {
  const auto window = link::Decode<link::ArmWindow>(command.payload);
  if (!window) return;
  for (std::size_t i = 0; i < window->fire.size(); ++i) {
    if (!window->fire[i]) continue;
    Send(LaserFrame::kPulseReport,
         Encode(link::PulseReport{window->first_tick + i, {outcome}}));
  }
}

void LaserOutput::SendStatus() {
  if (!serving_ || status_number_ == laser_.status_number()) return;
  link::LaserStatus status = laser_.status();
  if (!disarm_owed_ && !close_owed_ && laser_.disarmed())
    disarms_confirmed_ = disarms_taken_;
  if (safe_state_)
    status.interlocks = static_cast<std::uint8_t>(status.interlocks | link::kSafeState);
  const std::uint32_t interlocks = status.interlocks | status.shutters_open << 8;
  const auto now = clock_();
  if (!status_asked_ && interlocks == sent_interlocks_ && now < next_status_ &&
      disarms_confirmed_ == disarms_sent_) {
    return;
  }
  status.disarms_taken = disarms_sent_ = disarms_confirmed_;
  status_number_ = laser_.status_number();
  status_asked_ = false;
  sent_interlocks_ = interlocks;
  next_status_ = now + kStatusPeriod;
  Send(LaserFrame::kLaserStatus, Encode(status));
}

void LaserOutput::Send(LaserFrame type, link::Bytes payload) {
  outgoing_.push_back({type, std::move(payload)});
}

void LaserOutput::Flush() {
  while (!outgoing_.empty() && link_ && link_->CanSend()) {
    const Frame& frame = outgoing_.front();
    if (!link_->Send(static_cast<std::uint8_t>(frame.type), frame.payload)) return;
    outgoing_.pop_front();
  }
}

}  // namespace intaglio::drivers
