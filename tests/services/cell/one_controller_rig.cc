#include "tests/services/cell/one_controller_rig.h"

#include "tests/services/cell/one_controller.h"

namespace intaglio::cell {

virtual_engraver::StageOptions StageOfOne() {
  virtual_engraver::StageOptions options;
  options.mechanics.lag_s = 0;
  options.travel_min_mm = Vec3::Constant(-50);
  options.travel_max_mm = Vec3::Constant(50);
  options.queue_capacity = 64;
  options.serial_number = kOneSerialNumber;
  return options;
}

virtual_engraver::LaserOptions LaserOfOne() {
  virtual_engraver::LaserOptions options;
  options.rates_hz = {OneMachine::kRateHz, OneMachine::kFastRateHz};
  options.warm_up_s = 0.1;
  options.serial_number = kOneSerialNumber;
  return options;
}

namespace {

// A command for some 30 bytes of a line.
constexpr std::uint64_t kBytesOfACommand = 30;

class AsMotion final : public drivers::MotionRig {
 public:
  explicit AsMotion(const std::string& serial_number) {
    driver = std::make_unique<OneController>(
        machine_, serial_number.empty() ? kOneSerialNumber : serial_number);
  }
  void CutLine(bool cut) override { machine_.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override {
    machine_.CutAfter(bytes / kBytesOfACommand);
  }
  void PowerCycle() override {
    machine_.SwitchOff();
    StepFor(std::chrono::seconds(1));
    machine_.SwitchOn();
  }
  Vec3 actual_mm() override { return machine_.stage->actual_mm(); }
  bool moves() override { return machine_.stage->running(); }
  double rate_hz() const override { return OneMachine::kRateHz; }
  Vec3 travel_min_mm() const override { return Vec3::Constant(-50); }
  Vec3 travel_max_mm() const override { return Vec3::Constant(50); }
  double tolerance_mm() const override { return 2e-6; }
  std::chrono::milliseconds braking_time() const override {
    return std::chrono::milliseconds(30);
  }

 private:
  void AdvanceController() override { machine_.Advance(); }
  OneMachine machine_{StageOfOne(), LaserOfOne()};
};

class AsLaser final : public drivers::LaserRig {
 public:
  explicit AsLaser(const std::string& serial_number) {
    driver = std::make_unique<OneController>(
        machine_, serial_number.empty() ? kOneSerialNumber : serial_number);
  }
  void CutLine(bool cut) override { machine_.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override {
    machine_.CutAfter(bytes / kBytesOfACommand);
  }
  void SwitchOff() override { machine_.SwitchOff(); }
  void SwitchOn() override { machine_.SwitchOn(); }
  void Set(Interlock interlock, bool holds) override {
    if (interlock == Interlock::kKey) machine_.laser->SetKey(holds);
    if (interlock == Interlock::kDoor) machine_.laser->SetDoor(holds);
    if (interlock == Interlock::kStopButton) machine_.laser->SetStopButton(!holds);
  }
  std::uint64_t tick() override { return machine_.laser->tick(); }
  std::vector<std::uint64_t> FiredTicks() override { return machine_.fired_ticks(); }
  std::uint8_t shutters() override { return machine_.laser->shutters(); }
  bool lamp_on() override {
    return (machine_.laser->Report().interlocks & link::kLampOn) != 0;
  }
  double rate_hz() const override { return OneMachine::kRateHz; }
  double fast_rate_hz() const override { return OneMachine::kFastRateHz; }

 private:
  void AdvanceController() override { machine_.Advance(); }
  OneMachine machine_{StageOfOne(), LaserOfOne()};
};

}  // namespace

std::unique_ptr<drivers::MotionRig> MakeOneControllerMotionRig(
    const std::string& serial_number) {
  return std::make_unique<AsMotion>(serial_number);
}

std::unique_ptr<drivers::LaserRig> MakeOneControllerLaserRig(
    const std::string& serial_number) {
  return std::make_unique<AsLaser>(serial_number);
}

}  // namespace intaglio::cell
