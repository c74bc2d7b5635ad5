#include "tests/services/drivers/laser_rig.h"

#include "tests/services/cell/one_controller_rig.h"
#include "tests/services/drivers/bjjcz/point_rig.h"
#include "tests/services/drivers/grbl_rig.h"
#include "tests/services/drivers/isel/isel_rig.h"
#include "tests/services/drivers/motion_output_rig.h"
#include "tests/services/virtual_engraver/machine_rig.h"

namespace intaglio::drivers {
namespace {

constexpr char kSerialNumber[] = "A-03";

class VirtualLaserRig final : public LaserRig {
 public:
  VirtualLaserRig(const LaserDriverKind& kind, const std::string& serial_number)
      : machine_(Options()) {
    driver = kind.make(Profile(serial_number), machine_.Opener(machine_.laser),
                       machine_.clock());
  }
  /// A rig of the engraver with one line.
  VirtualLaserRig(const MotionDriverKind& kind, const std::string& serial_number)
      : machine_(Options(), true) {
    driver = LaserOf(kind.make(Profile(serial_number), machine_.Opener(machine_.laser),
                               machine_.clock()));
  }
  static MachineSpec Profile(const std::string& serial_number) {
    MachineSpec profile;
    profile.set_name("els-03");
    profile.mutable_laser_line()->set_device("the line");
    profile.mutable_laser_line()->set_serial_number(
        serial_number.empty() ? kSerialNumber : serial_number);
    return profile;
  }

  void CutLine(bool cut) override { machine_.laser.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override { machine_.laser.CutAfter(bytes); }
  void SwitchOff() override { machine_.SwitchOff(); }
  void SwitchOn() override { machine_.SwitchOn(); }
  void Set(Interlock interlock, bool holds) override {
    if (interlock == Interlock::kKey) laser().SetKey(holds);
    if (interlock == Interlock::kDoor) laser().SetDoor(holds);
    if (interlock == Interlock::kStopButton) laser().SetStopButton(!holds);
  }
  std::uint64_t tick() override { return laser().tick(); }
  std::vector<std::uint64_t> FiredTicks() override {
    std::vector<std::uint64_t> ticks;
    for (const auto& crack : machine_.Cracks()) ticks.push_back(crack.tick);
    return ticks;
  }
  std::uint8_t shutters() override { return laser().shutters(); }
  bool lamp_on() override { return (laser().Report().interlocks & link::kLampOn) != 0; }
  double rate_hz() const override { return 100; }
  double fast_rate_hz() const override { return 4000; }

 private:
  virtual_engraver::Laser& laser() { return machine_.machine().laser(); }
  void AdvanceController() override { machine_.Advance(); }
  virtual_engraver::MachineOptions Options() const {
    virtual_engraver::MachineOptions options;
    options.laser.rates_hz = {rate_hz(), fast_rate_hz()};
    options.laser.warm_up_s = 0.1;
    // Around the place where the stage is, so that the photosensor sees every crack.
    options.block.origin_mm = Vec3::Constant(-50);
    options.laser.serial_number = kSerialNumber;
    return options;
  }

  virtual_engraver::MachineRig machine_;
};

}  // namespace

std::unique_ptr<LaserController> LaserOf(std::unique_ptr<MotionDriver> both) {
  return std::unique_ptr<LaserController>(both.release()->laser());
}

std::unique_ptr<LaserRig> MakeLaserRig(std::string_view protocol,
                                       const std::string& serial_number) {
  if (protocol == kMotionOutput) {
    return std::make_unique<MotionOutputRig>(cell::MakeOneControllerLaserRig(),
                                             CutLineOf::kSynchronizer, serial_number);
  }
  for (const MotionDriverKind& kind : MotionDriverKinds()) {
    if (kind.protocol == protocol && protocol == "virtual-cell")
      return std::make_unique<VirtualLaserRig>(kind, serial_number);
  }
  if (protocol == "bjjcz") return MakeBjjczLaserRig(serial_number);
  if (protocol == "isel") return MakeIselLaserRig(serial_number);
  if (protocol == "grbl") return MakeGrblLaserRig(serial_number);
  for (const LaserDriverKind& kind : LaserDriverKinds()) {
    if (kind.protocol == protocol && protocol == "virtual-laser")
      return std::make_unique<VirtualLaserRig>(kind, serial_number);
  }
  return nullptr;
}

}  // namespace intaglio::drivers
