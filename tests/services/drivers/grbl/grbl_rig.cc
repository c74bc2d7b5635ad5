#include "tests/services/drivers/grbl/grbl_rig.h"

#include <array>
#include <cmath>

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

// So fine that a millisecond's way shows the speed.
grbl::VirtualGrblOptions FineSteps() {
  grbl::VirtualGrblOptions options = grbl::Grbl11();
  options.motion.steps_per_mm = 10000;
  return options;
}

class GrblMotionRig final : public MotionRig {
 public:
  explicit GrblMotionRig(const std::string& serial_number) : machine_(FineSteps()) {
    machine_.LeaveZero();
    driver = machine_.MakeDriver(serial_number);
  }
  void CutLine(bool cut) override { machine_.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override { machine_.CutAfter(bytes); }
  void PowerCycle() override {
    machine_.SwitchOff();
    StepFor(1s);
    machine_.SwitchOn();
  }
  bool LosePlace() override {
    PowerCycle();
    return true;
  }
  bool Inflict(ControllerFault fault) override {
    return machine_.Inflict(fault) || MotionRig::Inflict(fault);
  }
  void Relieve(ControllerFault fault) override {
    machine_.Relieve(fault);
    MotionRig::Relieve(fault);
  }
  Vec3 actual_mm() override { return machine_.grbl.WorkPosition_mm(); }
  bool moves() override {
    return !machine_.grbl.motion().is_empty() ||
           machine_.grbl.state() == grbl::VirtualGrbl::State::kHome;
  }
  double rate_hz() const override { return kGrblRateHz; }
  Vec3 travel_min_mm() const override { return Vec3::Constant(-50); }
  Vec3 travel_max_mm() const override { return Vec3::Constant(50); }
  // The status has three decimals.
  double tolerance_mm() const override { return 0.0012; }
  // What was sent ahead is executed: kAhead_s, and a barrier of 50 ms.
  std::chrono::milliseconds braking_time() const override { return 300ms; }

 private:
  void AdvanceController() override { machine_.Advance(); }
  GrblMachine machine_;
};

}  // namespace

// On for a while when a host connects: its banner is gone.
GrblMachine::GrblMachine(grbl::VirtualGrblOptions options)
    : grbl(std::move(options)),
      to_grbl_(std::make_shared<link::FaultyPipe>()),
      to_host_(std::make_shared<link::FaultyPipe>()) {
  end_ = std::make_unique<link::FaultyEnd>(to_grbl_, to_host_, random_,
                                           [this] { return now_; });
  grbl.Advance(100e3);
  (void)grbl.Read();
}

void GrblMachine::SwitchOff() {
  on_ = false;
  grbl.SwitchOff();
}

void GrblMachine::Advance() {
  now_ += 1ms;
  if (!on_) return grbl.Advance(1000);
  std::array<std::byte, 97> bytes;
  while (const std::size_t count = end_->Read(bytes).value_or(0)) {
    grbl.Write({reinterpret_cast<const char*>(bytes.data()), count});
  }
  grbl.Advance(1000);
  const std::string sent = grbl.Read();
  (void)end_->Write(std::as_bytes(std::span(sent)));
  if (to_grbl_->cut) to_host_->cut = true;
}

void GrblMachine::LeaveZero() {
  grbl.Write("G0X0.5\n");
  grbl.Advance(1e6);
  (void)grbl.Read();
}

bool GrblMachine::Inflict(ControllerFault fault) {
  switch (fault) {
    case ControllerFault::kReset:
      grbl.PressReset();
      return true;
    case ControllerFault::kEmergencyStop:
      grbl.SetEmergencyStop(true);
      return true;
    case ControllerFault::kHold:
      grbl.PressHold();
      return true;
    case ControllerFault::kLimit:
      grbl.HitLimit();
      return true;
    case ControllerFault::kAlarm:
      grbl.FailDrive();
      return true;
    case ControllerFault::kError:
      // Nothing is sent to it at rest.
      if (!grbl.motion().is_empty()) grbl.RefuseNextLine();
      return !grbl.motion().is_empty();
    case ControllerFault::kPowerCycle:
    case ControllerFault::kUnplug:
      break;
  }
  return false;
}

void GrblMachine::Relieve(ControllerFault fault) {
  if (fault == ControllerFault::kEmergencyStop) grbl.SetEmergencyStop(false);
}

void GrblMachine::Cut(bool cut) {
  to_grbl_->cut = to_host_->cut = cut;
  to_grbl_->cut_after = UINT64_MAX;
}

void GrblMachine::CutAfter(std::uint64_t bytes) {
  to_grbl_->cut_after = to_grbl_->taken_count + bytes;
}

void GrblMachine::SwitchOn() {
  to_grbl_->bytes.clear();
  to_host_->bytes.clear();
  grbl.PowerCycle();
  on_ = true;
}

MachineSpec GrblProfile() {
  MachineSpec profile;
  profile.set_name("grbl");
  for (AxisLimits* axis :
       {profile.mutable_x(), profile.mutable_y(), profile.mutable_z()}) {
    axis->set_travel_min_mm(-50);
    axis->set_travel_max_mm(50);
  }
  profile.mutable_laser()->add_rates_hz(kGrblRateHz);
  profile.mutable_laser()->add_rates_hz(kGrblFastRateHz);
  profile.mutable_laser()->set_warm_up_s(0.1);
  profile.mutable_laser()->set_pulse_energy_mj(10);
  profile.mutable_motion_line()->set_device("the line");
  return profile;
}

std::unique_ptr<GrblDriver> GrblMachine::MakeDriver(const std::string& serial_number) {
  MachineSpec machine = profile;
  machine.mutable_motion_line()->set_serial_number(
      serial_number.empty() ? grbl::VirtualGrblOptions().serial_number : serial_number);
  return std::make_unique<GrblDriver>(machine, opener(), clock());
}

link::StreamOpener GrblMachine::opener() {
  return [this]() -> Result<std::unique_ptr<link::ByteStream>> {
    return std::make_unique<link::FaultyEnd>(to_host_, to_grbl_, random_, clock());
  };
}

std::unique_ptr<MotionRig> MakeGrblMotionRig(const std::string& /*name*/,
                                             const std::string& serial_number) {
  return std::make_unique<GrblMotionRig>(serial_number);
}
GrblLaserRig::GrblLaserRig(const std::string& serial_number) : machine_(grbl::Grbl11()) {
  machine_.LeaveZero();
  driver = machine_.MakeDriver(serial_number);
}

void GrblLaserRig::SwitchOn() {
  machine_.SwitchOn();
  fired_.clear();
}

// What holds instead: planted/grbl_checks.cc.
std::string GrblLaserRig::stated_violation(std::string_view check) const {
  if (check == "L9_interlocks") return "L9: lettings go are not counted";
  if (check == "L7L8_cut" || check == "L7_cut_at_any_byte")
    return "L7: the shutters are open without a host";
  return "";
}

void GrblLaserRig::AdvanceController() {
  const std::uint64_t near = tick();
  machine_.Advance();
  const auto& flashes = machine_.grbl.motion().flashes();
  for (; flash_count_ < flashes.size(); ++flash_count_) {
    const std::int64_t number = flashes[flash_count_].line - 1;
    const auto off =
        (number - static_cast<std::int64_t>(near) % 1000 + 1500) % 1000 - 500;
    fired_.push_back(near + static_cast<std::uint64_t>(off));
  }
}

std::unique_ptr<LaserRig> MakeGrblLaserRig(const std::string& /*name*/,
                                           const std::string& serial_number) {
  return std::make_unique<GrblLaserRig>(serial_number);
}

}  // namespace intaglio::drivers
