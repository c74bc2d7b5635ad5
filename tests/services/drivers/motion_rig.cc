#include "tests/services/drivers/motion_rig.h"

#include "tests/services/drivers/bjjcz/point_rig.h"
#include "tests/services/drivers/grbl_rig.h"
#include "tests/services/drivers/isel/isel_rig.h"
#include "tests/services/virtual_engraver/machine_rig.h"

namespace intaglio::drivers {
namespace {

constexpr char kSerialNumber[] = "S-03";

class VirtualStageRig final : public MotionRig {
 public:
  VirtualStageRig(const MotionDriverKind& kind, const std::string& serial_number)
      : machine_(Options(), kind.switches_laser),
        line_(kind.switches_laser ? machine_.laser : machine_.motion) {
    MachineSpec profile;
    profile.set_name("els-03");
    profile.mutable_motion_line()->set_device("the line");
    profile.mutable_motion_line()->set_serial_number(
        serial_number.empty() ? kSerialNumber : serial_number);
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
    options.stage.serial_number = kSerialNumber;
    options.laser.rates_hz = {rate_hz()};
    return options;
  }

  virtual_engraver::MachineRig machine_;
  virtual_engraver::MachineRig::Line& line_;
};

}  // namespace

std::unique_ptr<MotionRig> MakeMotionRig(std::string_view protocol,
                                         const std::string& serial_number) {
  for (const MotionDriverKind& kind : MotionDriverKinds()) {
    if (kind.protocol == protocol && protocol.starts_with("virtual-"))
      return std::make_unique<VirtualStageRig>(kind, serial_number);
  }
  if (protocol == "bjjcz") return MakeBjjczMotionRig(serial_number);
  if (protocol == "isel") return MakeIselMotionRig(serial_number);
  if (protocol == "grbl") return MakeGrblMotionRig(serial_number);
  return nullptr;
}

}  // namespace intaglio::drivers
