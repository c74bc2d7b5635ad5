#include "services/drivers/laser_drivers.h"
#include "services/drivers/motion_drivers.h"
#include "tests/services/drivers/laser_rig.h"
#include "tests/services/drivers/rig_row.h"
#include "tests/services/virtual_engraver/machine_rig.h"

namespace intaglio::drivers {
namespace {

constexpr char kLaserNumber[] = "A-03";

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
        serial_number.empty() ? kLaserNumber : serial_number);
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
    options.laser.serial_number = kLaserNumber;
    return options;
  }

  virtual_engraver::MachineRig machine_;
};

template <typename Kind>
std::unique_ptr<LaserRig> RigOf(std::span<const Kind> kinds, const std::string& name,
                                const std::string& serial_number) {
  const auto kind = std::ranges::find(kinds, name, &Kind::protocol);
  return std::make_unique<VirtualLaserRig>(*kind, serial_number);
}

const RigRow<LaserRig> kVirtualLaser{
    "virtual-laser", "virtual-laser",
    [](const std::string& name, const std::string& serial_number) {
      return RigOf(LaserDriverKinds(), name, serial_number);
    }};
const RigRow<LaserRig> kVirtualCellLaser{
    "virtual-cell", "virtual-cell",
    [](const std::string& name, const std::string& serial_number) {
      return RigOf(MotionDriverKinds(), name, serial_number);
    }};

}  // namespace
}  // namespace intaglio::drivers
