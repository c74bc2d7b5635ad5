#include "services/drivers/motion_drivers.h"
#include "tests/services/drivers/motion_rig.h"
#include "tests/services/drivers/rig_row.h"
#include "tests/services/virtual_engraver/machine_rig.h"

namespace intaglio::drivers {
namespace {

constexpr char kStageNumber[] = "S-03";

class VirtualStageRig final : public MotionRig {
 public:
  VirtualStageRig(const MotionDriverKind& kind, const std::string& serial_number)
      : machine_(Options(), kind.switches_laser),
        line_(kind.switches_laser ? machine_.laser : machine_.motion) {
    MachineSpec profile;
    profile.set_name("els-03");
    profile.mutable_motion_line()->set_device("the line");
    profile.mutable_motion_line()->set_serial_number(
        serial_number.empty() ? kStageNumber : serial_number);
    // What it expects of the controller; its axes are checked where profiles are.
    profile.mutable_head_over_block()->mutable_block_stage();
    driver = kind.make(profile, machine_.Opener(line_), machine_.clock());
  }

  void CutLine(bool cut) override { line_.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override { line_.CutAfter(bytes); }
  void PowerCycle() override {
    machine_.SwitchOff();
    StepFor(std::chrono::seconds(1));
    machine_.SwitchOn();
  }
  Vec3 actual_mm() override { return machine_.machine().stage().actual_mm(); }
  Vec2 block_mm() override { return machine_.machine().stage().block_mm(); }
  bool moves() override { return machine_.machine().stage().running(); }
  double rate_hz() const override { return 100; }
  Vec3 travel_min_mm() const override { return Vec3::Constant(-50); }
  Vec3 travel_max_mm() const override { return Vec3::Constant(50); }
  // No lag; the line rounds to nanometres.
  double tolerance_mm() const override { return 2e-6; }
  // 7000 mm/s^2, in whole ticks.
  std::chrono::milliseconds braking_time() const override {
    return std::chrono::milliseconds(30);
  }

 private:
  void AdvanceController() override { machine_.Advance(); }
  virtual_engraver::MachineOptions Options() const {
    virtual_engraver::MachineOptions options;
    options.stage.mechanics.lag_s = 0;
    options.stage.travel_min_mm = travel_min_mm();
    options.stage.travel_max_mm = travel_max_mm();
    options.stage.queue_capacity = 64;
    options.stage.serial_number = kStageNumber;
    options.stage.block_stage = virtual_engraver::BlockStageOptions{
        Vec2::Constant(-100), Vec2::Constant(100), 50, 500};
    options.laser.rates_hz = {rate_hz()};
    return options;
  }

  virtual_engraver::MachineRig machine_;
  virtual_engraver::MachineRig::Line& line_;
};

std::unique_ptr<MotionRig> MakeVirtualMotionRig(const std::string& name,
                                                const std::string& serial_number) {
  const auto kind =
      std::ranges::find(MotionDriverKinds(), name, &MotionDriverKind::protocol);
  return std::make_unique<VirtualStageRig>(*kind, serial_number);
}

const RigRow<MotionRig> kVirtualStage{"virtual-stage", "virtual-stage",
                                      &MakeVirtualMotionRig};
const RigRow<MotionRig> kVirtualCell{"virtual-cell", "virtual-cell",
                                     &MakeVirtualMotionRig};

}  // namespace
}  // namespace intaglio::drivers
