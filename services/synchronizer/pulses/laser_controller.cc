#include "services/synchronizer/pulses/laser_controller.h"

namespace intaglio::synchronizer {

using link::LaserFrame;

LaserController::LaserController(link::StreamOpener open, link::SteadyClock clock,
                                 link::ExpectedDevice expected)
    : clock_(std::move(clock)),
      expected_(std::move(expected)),
      session_(std::move(open), clock_) {}

void LaserController::Poll(const ReportSink& sink, const PastSink& past) {
  session_.Poll([&](std::uint8_t type, std::span<const std::byte> payload) {
    Handle(static_cast<LaserFrame>(type), payload, sink, past);
  });
  // Not merely silent for a moment: then the session goes on, and no identity comes
  // again.
  if (session_.sessions() != polled_sessions_) {
    polled_sessions_ = session_.sessions();
    identified_ = identified_now_;
    if (!refused_now_) refusal_.clear();
  }
  identified_now_ = refused_now_ = false;
  if (!session_.up()) refusal_.clear();
}

void LaserController::Identify(std::span<const std::byte> payload) {
  const auto identity = link::Decode<link::LaserIdentity>(payload);
  if (!identity) return Refuse(identity.error().message + ": " + expected_.VersionHint());
  if (const auto why = link::RefusalOf(expected_, identity->serial_number); !why.empty())
    return Refuse(why);
  identity_ = *identity;
  identified_ = identified_now_ = true;
  status_number_ = 0;
  disarms_sent_ = 0;
  ++sessions_;
  (void)RequestStatus();
}

// Its own host may have left it open and armed when the cables were swapped.
void LaserController::Refuse(const std::string& why) {
  refusal_ = why;
  refused_now_ = true;
  identified_ = false;
  const auto send = [this](LaserFrame type, const link::Bytes& payload) {
    (void)session_.Send(static_cast<std::uint8_t>(type), payload);
  };
  send(LaserFrame::kShutterCommand, Encode(link::ShutterCommand{0}));
  send(LaserFrame::kDisarm, {});
  send(LaserFrame::kLampCommand, Encode(link::LampCommand{}));
}

void LaserController::Handle(LaserFrame type, std::span<const std::byte> payload,
                             const ReportSink& sink, const PastSink& past) {
  if (type == LaserFrame::kLaserIdentity) return Identify(payload);
  if (!identified_) return;
  if (type == LaserFrame::kLaserStatus) {
    const auto status = link::Decode<link::LaserStatus>(payload);
    if (!status) return;
    status_ = *status;
    ++status_number_;
    status_at_ = clock_();
  } else if (type == LaserFrame::kPulseReport) {
    if (const auto report = link::Decode<link::PulseReport>(payload)) sink(*report);
  } else if (type == LaserFrame::kPastReport) {
    const auto report = link::Decode<link::PastReport>(payload);
    if (report && past) past(*report);
  }
}

Status LaserController::SendFrame(LaserFrame type, const link::Bytes& payload) {
  if (!identified_) return Fail(ErrorCode::kLinkLost, message());
  return session_.Send(static_cast<std::uint8_t>(type), payload);
}

Status LaserController::Lamp(bool on, double rate_hz) {
  return SendFrame(LaserFrame::kLampCommand, Encode(link::LampCommand{on, rate_hz}));
}

Status LaserController::OpenShutters(std::uint8_t mask) {
  return SendFrame(LaserFrame::kShutterCommand, Encode(link::ShutterCommand{mask}));
}

Status LaserController::Arm(const link::ArmWindow& window) {
  return SendFrame(LaserFrame::kArmWindow, Encode(window));
}

Status LaserController::Disarm() {
  auto sent = SendFrame(LaserFrame::kDisarm);
  if (sent) ++disarms_sent_;
  return sent;
}
Status LaserController::Reset() { return SendFrame(LaserFrame::kLaserReset); }
Status LaserController::Stop() { return SendFrame(LaserFrame::kLaserStop); }
Status LaserController::RequestStatus() {
  return SendFrame(LaserFrame::kLaserStatusRequest);
}

bool LaserController::RequestPast(std::uint64_t first_tick, std::uint16_t count) {
  return CanSend() &&
         SendFrame(LaserFrame::kPastRequest, Encode(link::PastRequest{first_tick, count}))
             .has_value();
}

}  // namespace intaglio::synchronizer
