#include "tests/services/drivers/bjjcz/point_rig.h"

#include "services/drivers/bjjcz/point_driver.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

// A tick is shorter than the list of one point, 8 ms with what passes on the line.
constexpr double kPointRate_hz = 200, kFastPointRate_hz = 4000;
constexpr double kMiddle = 32768;
// z = 0: the origin of the axis is 1 mm below the travel.
constexpr double kOriginMm = -51;
constexpr std::int32_t kHomedSteps = 51000;

Vec3 PlaceOfBoard(const bjjcz::VirtualBjjcz& board) {
  const auto at = board.place();
  return {(at[0] - kMiddle) / kBoardPlacesPerMm, (at[1] - kMiddle) / kBoardPlacesPerMm,
          kOriginMm + board.axis() / kBoardStepsPerMm};
}

/// Names this board; empty: the one of the rig.
MachineSpec ProfileOf(const std::string& serial_number) {
  MachineSpec profile = BjjczPointProfile();
  if (!serial_number.empty())
    profile.mutable_motion_line()->set_serial_number(serial_number);
  return profile;
}

class BjjczMotionRig final : public MotionRig {
 public:
  explicit BjjczMotionRig(const MachineSpec& profile) : machine_(false, true) {
    driver = MakeBjjczPointDriverAt(machine_, profile);
  }
  void CutLine(bool cut) override { machine_.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override { machine_.CutAfter(bytes); }
  void PowerCycle() override {
    machine_.SwitchOff();
    StepFor(1s);
    machine_.SwitchOn();
    machine_.board.SetAxis(++homed_steps_);
  }
  bool Inflict(ControllerFault fault) override {
    if (fault == ControllerFault::kEmergencyStop) {
      machine_.board.SetInput(kBjjczDoorInput, false);
      return true;
    }
    return MotionRig::Inflict(fault);
  }
  void Relieve(ControllerFault fault) override {
    if (fault == ControllerFault::kEmergencyStop)
      machine_.board.SetInput(kBjjczDoorInput, true);
    MotionRig::Relieve(fault);
  }
  Vec3 actual_mm() override { return PlaceOfBoard(machine_.board); }
  bool moves() override { return machine_.board.moves(); }
  bool guide_is_on() override {
    return (machine_.board.outputs() >> kBoardGuideOutput & 1) != 0;
  }
  bool may_fire() override {
    return (machine_.board.outputs() & 1) != 0 || machine_.board.lit();
  }
  double rate_hz() const override { return kPointRate_hz; }
  Vec3 travel_min_mm() const override { return Vec3::Constant(-50); }
  Vec3 travel_max_mm() const override { return Vec3::Constant(50); }
  // Half a place of the board, and rounding.
  double tolerance_mm() const override { return 0.51 / kBoardPlacesPerMm; }
  // A list of 150 ms, and the next command.
  std::chrono::milliseconds braking_time() const override { return 170ms; }

 private:
  void AdvanceController() override { machine_.Advance(); }
  BjjczMachine machine_;
  std::int32_t homed_steps_ = kHomedSteps;
};

class BjjczLaserRig final : public LaserRig {
 public:
  explicit BjjczLaserRig(const std::string& serial_number) : machine_(false, true) {
    const MachineSpec profile = ProfileOf(serial_number);
    driver.reset(MakeBjjczPointDriverAt(machine_, profile).release()->laser());
  }
  void CutLine(bool cut) override { machine_.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override { machine_.CutAfter(bytes); }
  void SwitchOff() override { machine_.SwitchOff(); }
  void SwitchOn() override {
    machine_.SwitchOn();
    machine_.board.SetAxis(++homed_steps_);
    fired_.clear();
  }
  // One chain at the door's input.
  void Set(Interlock, bool holds) override {
    machine_.board.SetInput(kBjjczDoorInput, holds);
  }
  std::uint64_t tick() override { return driver->status().tick; }
  std::vector<std::uint64_t> FiredTicks() override { return fired_; }
  std::uint8_t shutters() override { return driver->status().shutters_open; }
  bool lamp_on() override { return driver->Has(link::kLampOn); }
  double rate_hz() const override { return kPointRate_hz; }
  double fast_rate_hz() const override { return kFastPointRate_hz; }
  bool sees_cracks() const override { return false; }
  // What holds instead: point_driver_test.cc.
  std::string stated_violation(std::string_view check) const override {
    if (check == "L9_interlocks") return "L9: lettings go are not counted";
    return "";
  }

 private:
  void AdvanceController() override {
    machine_.Advance();
    const auto& flashes = machine_.board.flashes();
    for (; flash_count_ < flashes.size(); ++flash_count_) {
      if (flashes[flash_count_].lit_us > 0) fired_.push_back(tick() + 1);
    }
  }
  BjjczMachine machine_;
  std::vector<std::uint64_t> fired_;
  std::size_t flash_count_ = 0;
  std::int32_t homed_steps_ = kHomedSteps;
};

}  // namespace

MachineSpec BjjczPointProfile() {
  MachineSpec machine;
  machine.set_name("board");
  machine.mutable_motion_line()->set_protocol("bjjcz");
  machine.mutable_motion_line()->set_device("/dev/null");
  machine.mutable_motion_line()->set_serial_number(kBjjczSerialNumber);
  for (AxisLimits* axis :
       {machine.mutable_x(), machine.mutable_y(), machine.mutable_z()}) {
    axis->set_travel_min_mm(-50);
    axis->set_travel_max_mm(50);
    axis->set_max_speed_mm_s(20);
    axis->set_max_acceleration_mm_s2(1000);
  }
  machine.mutable_z()->set_steps_per_mm(kBoardStepsPerMm);
  machine.mutable_scan_head()->set_field_mm(kBoardFieldMm);
  JumpAndDwell& jumps = *machine.mutable_head_over_block()->mutable_jump_and_dwell();
  jumps.set_z_step_mm(0.066);
  jumps.set_jump_mm_s(3000);
  jumps.set_jump_delay_s(0.0002);
  jumps.set_dwell_s(0.0005);
  machine.mutable_bjjcz_board()->set_laser(BJJCZ_LASER_UV);
  machine.mutable_bjjcz_board()->set_door_input(kBjjczDoorInput);
  machine.mutable_bjjcz_board()->set_guide_output(kBoardGuideOutput);
  machine.mutable_bjjcz_board()->set_point_frequency_hz(30000);
  machine.mutable_laser()->add_rates_hz(kPointRate_hz);
  machine.mutable_laser()->add_rates_hz(kFastPointRate_hz);
  machine.mutable_laser()->set_warm_up_s(0.1);
  machine.mutable_laser()->set_max_unsettled_points(kBoardListPoints);
  machine.mutable_laser()->set_pulse_energy_mj(10);
  return machine;
}

std::unique_ptr<MotionDriver> MakeBjjczPointDriverAt(BjjczMachine& machine,
                                                     const MachineSpec& profile) {
  machine.board.SetAxis(kHomedSteps);
  return MakeBjjczPointDriver(profile, machine.Opener(), machine.clock());
}

std::unique_ptr<MotionRig> MakeBjjczMotionRig(const std::string& /*name*/,
                                              const std::string& serial_number) {
  return MakeBjjczMotionRigOf(ProfileOf(serial_number));
}

std::unique_ptr<MotionRig> MakeBjjczMotionRigOf(const MachineSpec& profile) {
  return std::make_unique<BjjczMotionRig>(profile);
}

std::unique_ptr<LaserRig> MakeBjjczLaserRig(const std::string& /*name*/,
                                            const std::string& serial_number) {
  return std::make_unique<BjjczLaserRig>(serial_number);
}

}  // namespace intaglio::drivers
