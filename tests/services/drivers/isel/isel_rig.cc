#include "tests/services/drivers/isel/isel_rig.h"

#include <array>
#include <span>

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

class IselMotionRig final : public MotionRig {
 public:
  explicit IselMotionRig(const std::string& serial_number) : machine_(FineIsel()) {
    MachineSpec profile = IselProfile();
    profile.mutable_motion_line()->set_serial_number(serial_number);
    driver = machine_.MakeDriver(profile);
  }
  void CutLine(bool cut) override { machine_.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override { machine_.CutAfter(bytes); }
  void PowerCycle() override {
    machine_.SwitchOff();
    StepFor(1s);
    machine_.SwitchOn();
  }
  bool LosePlace() override {
    machine_.SwitchOff();
    StepFor(1s);
    machine_.SwitchOn(false);
    return true;
  }
  bool FindPlace() override {
    return driver->Home() && Until([this] { return driver->state().at_rest; }, 60s);
  }
  // Its own stop key ends a move; door and stop button are its chain.
  bool Inflict(ControllerFault fault) override {
    if (fault == ControllerFault::kEmergencyStop) {
      machine_.isel.SetCover(true);
      return true;
    }
    if (fault == ControllerFault::kHold && machine_.isel.moves()) {
      machine_.isel.PressStop();
      return true;
    }
    return MotionRig::Inflict(fault);
  }
  void Relieve(ControllerFault fault) override {
    if (fault == ControllerFault::kEmergencyStop) machine_.isel.SetCover(false);
    MotionRig::Relieve(fault);
  }
  Vec3 actual_mm() override {
    const isel::Steps& place = machine_.isel.place();
    return Vec3(place[0], place[1], place[2]) / kIselStepsPerMm;
  }
  bool moves() override { return machine_.isel.moves(); }
  double rate_hz() const override { return kIselRateHz; }
  Vec3 travel_min_mm() const override { return Vec3::Constant(-50); }
  Vec3 travel_max_mm() const override { return Vec3::Constant(50); }
  // Half a step, and rounding.
  double tolerance_mm() const override { return 0.0001; }
  // A piece of 50 ms, and the command that is on its way.
  std::chrono::milliseconds braking_time() const override { return 120ms; }

 private:
  void AdvanceController() override { machine_.Advance(); }
  IselMachine machine_;
};

}  // namespace

isel::VirtualIselOptions FineIsel() {
  isel::VirtualIselOptions options;
  options.max_speed = 1000000;
  options.travel_min.fill(static_cast<std::int32_t>(-50 * kIselStepsPerMm));
  options.travel_max.fill(static_cast<std::int32_t>(50 * kIselStepsPerMm));
  return options;
}

IselMachine::IselMachine(isel::VirtualIselOptions options)
    : isel(options),
      to_isel_(std::make_shared<link::FaultyPipe>()),
      to_host_(std::make_shared<link::FaultyPipe>()) {
  end_ = std::make_unique<link::FaultyEnd>(to_isel_, to_host_, random_,
                                           [this] { return now_; });
  isel.HomeAtPanel();
}

void IselMachine::Advance() {
  now_ += 1ms;
  if (!on_) return;
  std::array<std::byte, 97> bytes;
  while (const std::size_t count = end_->Read(bytes).value_or(0)) {
    isel.Write({reinterpret_cast<const char*>(bytes.data()), count});
  }
  isel.Advance(1000);
  const std::string sent = isel.Read();
  (void)end_->Write(std::as_bytes(std::span(sent)));
  if (to_isel_->cut) to_host_->cut = true;
}

void IselMachine::Cut(bool cut) {
  to_isel_->cut = to_host_->cut = cut;
  to_isel_->cut_after = UINT64_MAX;
}

void IselMachine::CutAfter(std::uint64_t bytes) {
  to_isel_->cut_after = to_isel_->taken_count + bytes;
}

void IselMachine::SwitchOn(bool homed) {
  to_isel_->bytes.clear();
  to_host_->bytes.clear();
  isel.PowerCycle();
  if (homed) isel.HomeAtPanel();
  on_ = true;
}

MachineSpec IselProfile() {
  MachineSpec profile;
  profile.set_name("isel");
  for (AxisLimits* axis :
       {profile.mutable_x(), profile.mutable_y(), profile.mutable_z()}) {
    axis->set_travel_min_mm(-50);
    axis->set_travel_max_mm(50);
    axis->set_steps_per_mm(kIselStepsPerMm);
  }
  profile.mutable_laser()->add_rates_hz(kIselRateHz);
  profile.mutable_laser()->add_rates_hz(kIselFastRateHz);
  profile.mutable_laser()->set_warm_up_s(0.1);
  profile.mutable_laser()->set_pulse_energy_mj(10);
  profile.mutable_motion_line()->set_device("the line");
  return profile;
}

std::unique_ptr<IselDriver> IselMachine::MakeDriver(const MachineSpec& profile) {
  return std::make_unique<IselDriver>(
      profile,
      [this]() -> Result<std::unique_ptr<link::ByteStream>> {
        return std::make_unique<link::FaultyEnd>(to_host_, to_isel_, random_,
                                                 [this] { return now_; });
      },
      [this] { return now_; });
}

IselLaserRig::IselLaserRig(const std::string& serial_number) : machine_(FineIsel()) {
  MachineSpec profile = IselProfile();
  profile.mutable_motion_line()->set_serial_number(serial_number);
  driver = machine_.MakeDriver(profile);
}

void IselLaserRig::SwitchOn() {
  machine_.SwitchOn();
  fired_.clear();
}

// What holds instead: isel_driver_test.cc.
std::string IselLaserRig::stated_violation(std::string_view check) const {
  if (check == "L7_cut_at_any_byte") return "L6: tick ";  // fired, and uncertain
  if (check == "L9_interlocks") return "L9: lettings go are not counted";
  return "";
}

void IselLaserRig::AdvanceController() {
  machine_.Advance();
  const auto& flashes = machine_.isel.flashes();
  for (; flash_count_ < flashes.size(); ++flash_count_) fired_.push_back(tick() + 1);
}

std::unique_ptr<MotionRig> MakeIselMotionRig(const std::string& /*name*/,
                                             const std::string& serial_number) {
  return std::make_unique<IselMotionRig>(serial_number);
}

std::unique_ptr<LaserRig> MakeIselLaserRig(const std::string& /*name*/,
                                           const std::string& serial_number) {
  return std::make_unique<IselLaserRig>(serial_number);
}

}  // namespace intaglio::drivers
