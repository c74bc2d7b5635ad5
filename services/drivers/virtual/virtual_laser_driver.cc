#include "services/drivers/virtual/virtual_laser_driver.h"

#include "services/drivers/virtual/reported_accessories.h"
#include "services/job/machine/accessories.h"
#include "services/platform/link/expected_device.h"

namespace intaglio::drivers {
namespace {

using link::LaserFrame;

link::PulseTiming TimingOf(const PulseTiming& profile) {
  link::PulseTiming timing;
  if (profile.has_qswitch_delay_us())
    timing.qswitch_delay_us = profile.qswitch_delay_us();
  if (profile.has_qswitch_width_us())
    timing.qswitch_width_us = profile.qswitch_width_us();
  if (profile.has_min_sync_width_us())
    timing.min_sync_width_us = profile.min_sync_width_us();
  if (profile.has_min_sensor_width_us())
    timing.min_sensor_width_us = profile.min_sensor_width_us();
  timing.shutter_time_ms = profile.shutter_time_ms();
  if (profile.has_min_flash_height_mm())
    timing.min_flash_height_mm = profile.min_flash_height_mm();
  if (profile.has_max_flash_height_mm())
    timing.max_flash_height_mm = profile.max_flash_height_mm();
  return timing;
}

// What a motion bridge serves may be a real controller in lockstep.
bool IsSimulated(const MachineSpec& machine) {
  return machine.laser_line().protocol() != kMotionOutput ||
         machine.motion_line().protocol() == "virtual-cell";
}

class VirtualLaserDriver final : public LaserController {
 public:
  VirtualLaserDriver(link::FramePort port, link::SteadyClock clock,
                     link::ExpectedDevice expected, const MachineSpec& machine);

  void Poll(const ReportSink& sink, const PastSink& past) override;

  bool up() const override { return session_.up() && identified_ && status_number_ > 0; }
  bool CanSend() const override { return session_.CanSend() && identified_; }
  bool taken_over() const override { return session_.fenced(); }
  const std::string& message() const override {
    return refusal_.empty() ? session_.message() : refusal_;
  }
  const std::string& refusal() const override { return refusal_; }
  int fd() const override { return session_.fd(); }

  const link::LaserIdentity& identity() const override { return identity_; }
  bool simulates_time() const override { return is_simulated_ && identity_.lockstep; }
  const link::LaserStatus& status() const override { return status_; }
  std::uint64_t status_number() const override { return status_number_; }
  std::chrono::nanoseconds status_at() const override { return status_at_; }
  std::uint64_t session() const override { return sessions_; }
  bool disarmed() const override {
    return up() && status_.disarms_taken == disarms_sent_;
  }

  Status Lamp(bool on, double rate_hz) override;
  Status OpenShutters(std::uint8_t mask) override;
  Status Arm(const link::ArmWindow& window) override;
  Status Disarm() override;
  Status Reset() override;
  Status Stop() override;
  Status RequestStatus() override;
  const Accessories& accessories() const override { return accessories_; }
  Status SwitchOutputs(std::uint8_t on) override;
  bool RequestPast(std::uint64_t first_tick, std::uint16_t count) override;

 private:
  void Handle(link::LaserFrame type, std::span<const std::byte> payload,
              const ReportSink& sink, const PastSink& past);
  void Identify(std::span<const std::byte> payload);
  void Refuse(const std::string& why);
  Status SendFrame(link::LaserFrame type, const link::Bytes& payload = {});

  link::SteadyClock clock_;
  link::ExpectedDevice expected_;
  link::PulseTiming timing_;
  MachineSpec named_;  // outputs and inputs alone
  Accessories accessories_;
  bool is_simulated_;  // no real controller is behind this line
  std::string refusal_;
  link::FramePort session_;
  link::LaserIdentity identity_;
  link::LaserStatus status_;
  bool identified_ = false;
  bool identified_now_ = false, refused_now_ = false;  // in this Poll
  std::uint32_t polled_sessions_ = 0;
  std::uint64_t status_number_ = 0;
  std::chrono::nanoseconds status_at_{0};
  std::uint64_t sessions_ = 0;
  std::uint32_t disarms_sent_ = 0;
};

VirtualLaserDriver::VirtualLaserDriver(link::FramePort port, link::SteadyClock clock,
                                       link::ExpectedDevice expected,
                                       const MachineSpec& machine)
    : clock_(std::move(clock)),
      expected_(std::move(expected)),
      timing_(TimingOf(machine.laser().timing())),
      is_simulated_(IsSimulated(machine)),
      session_(std::move(port)) {
  *named_.mutable_outputs() = machine.outputs();
  *named_.mutable_inputs() = machine.inputs();
  accessories_ = ReportedAccessories(named_, {});
}

void VirtualLaserDriver::Poll(const ReportSink& sink, const PastSink& past) {
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

void VirtualLaserDriver::Identify(std::span<const std::byte> payload) {
  const auto identity = link::Decode<link::LaserIdentity>(payload);
  if (!identity) return Refuse(identity.error().message + ": " + expected_.VersionHint());
  if (const auto why = link::RefusalOf(expected_, identity->serial_number); !why.empty())
    return Refuse(why);
  identity_ = *identity;
  identified_ = identified_now_ = true;
  status_number_ = 0;
  disarms_sent_ = 0;
  ++sessions_;
  // Before all others, so that nothing is fired with that of another host.
  (void)SendFrame(LaserFrame::kPulseTiming, Encode(timing_));
  accessories_ = ReportedAccessories(named_, {});
  if (named_.outputs_size() + named_.inputs_size() > 0) (void)SwitchOutputs(0);
  (void)RequestStatus();
}

// Its own host may have left it open and armed when the cables were swapped.
void VirtualLaserDriver::Refuse(const std::string& why) {
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

void VirtualLaserDriver::Handle(LaserFrame type, std::span<const std::byte> payload,
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
  } else if (type == LaserFrame::kAccessoryState) {
    if (const auto state = link::Decode<link::AccessoryState>(payload))
      accessories_ = ReportedAccessories(named_, *state);
  }
}

Status VirtualLaserDriver::SendFrame(LaserFrame type, const link::Bytes& payload) {
  if (!identified_) return Fail(ErrorCode::kLinkLost, message());
  return session_.Send(static_cast<std::uint8_t>(type), payload);
}

Status VirtualLaserDriver::Lamp(bool on, double rate_hz) {
  return SendFrame(LaserFrame::kLampCommand, Encode(link::LampCommand{on, rate_hz}));
}

Status VirtualLaserDriver::OpenShutters(std::uint8_t mask) {
  return SendFrame(LaserFrame::kShutterCommand, Encode(link::ShutterCommand{mask}));
}

Status VirtualLaserDriver::Arm(const link::ArmWindow& window) {
  return SendFrame(LaserFrame::kArmWindow, Encode(window));
}

Status VirtualLaserDriver::Disarm() {
  auto sent = SendFrame(LaserFrame::kDisarm);
  if (sent) ++disarms_sent_;
  return sent;
}
Status VirtualLaserDriver::Reset() { return SendFrame(LaserFrame::kLaserReset); }
Status VirtualLaserDriver::Stop() { return SendFrame(LaserFrame::kLaserStop); }
Status VirtualLaserDriver::RequestStatus() {
  return SendFrame(LaserFrame::kLaserStatusRequest);
}

Status VirtualLaserDriver::SwitchOutputs(std::uint8_t on) {
  const NeededInputs needed = NeededInputsOf(named_);
  return SendFrame(LaserFrame::kAccessoryCommand,
                   Encode(link::AccessoryCommand{on, needed.watched, needed.levels}));
}

bool VirtualLaserDriver::RequestPast(std::uint64_t first_tick, std::uint16_t count) {
  return CanSend() &&
         SendFrame(LaserFrame::kPastRequest, Encode(link::PastRequest{first_tick, count}))
             .has_value();
}

}  // namespace

std::unique_ptr<LaserController> MakeVirtualLaserDriver(const MachineSpec& machine,
                                                        link::StreamOpener open,
                                                        link::SteadyClock clock) {
  return MakeVirtualLaserDriver(machine, link::FramePort(std::move(open), clock), clock);
}

std::unique_ptr<LaserController> MakeVirtualLaserDriver(const MachineSpec& machine,
                                                        link::FramePort port,
                                                        link::SteadyClock clock) {
  const SerialLine& line = machine.laser_line();
  return std::make_unique<VirtualLaserDriver>(
      std::move(port), std::move(clock),
      link::ExpectedDevice{line.serial_number(), "laser", machine.name(), line.device(),
                           "laser_line"},
      machine);
}

}  // namespace intaglio::drivers
