#pragma once

// A virtual isel at the driver of its family, behind a line that a test cuts: as the rig
// of a motion driver, and as that of a laser driver.

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "proto/machine.pb.h"
#include "services/drivers/isel/isel_driver.h"
#include "tests/services/drivers/isel/virtual_isel.h"
#include "tests/services/drivers/laser_rig.h"
#include "tests/services/drivers/motion_rig.h"
#include "tests/services/platform/link/faulty_line.h"

namespace intaglio::drivers {

/// The controller, its line and its mains switch, on a clock that a test moves by 1 ms.
/// It was homed at its own panel.
class IselMachine {
 public:
  explicit IselMachine(isel::VirtualIselOptions options);
  IselMachine(const IselMachine&) = delete;
  IselMachine& operator=(const IselMachine&) = delete;

  void Advance();
  void Cut(bool cut);
  void CutAfter(std::uint64_t bytes);
  void SwitchOff() { on_ = false; }
  /// And homed at its panel, if it is to be.
  void SwitchOn(bool homed = true);

  /// `serial_number`: of the profile.
  std::unique_ptr<IselDriver> MakeDriver(const MachineSpec& profile);

  isel::VirtualIsel isel;

 private:
  bool on_ = true;
  std::chrono::nanoseconds now_ = std::chrono::hours(3);
  std::shared_ptr<link::FaultyPipe> to_isel_, to_host_;
  std::shared_ptr<std::mt19937_64> random_ = std::make_shared<std::mt19937_64>(1);
  std::unique_ptr<link::ByteStream> end_;
};

inline constexpr double kIselRateHz = 100, kIselFastRateHz = 4000;
/// So fine that a millisecond's way shows the speed.
inline constexpr double kIselStepsPerMm = 10000;

class IselLaserRig final : public LaserRig {
 public:
  explicit IselLaserRig(const std::string& serial_number = "");
  void CutLine(bool cut) override { machine_.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override { machine_.CutAfter(bytes); }
  void SwitchOff() override { machine_.SwitchOff(); }
  void SwitchOn() override;
  // One chain at the cover's input.
  void Set(Interlock, bool holds) override { machine_.isel.SetCover(!holds); }
  std::uint64_t tick() override { return driver->status().tick; }
  // By the controller's record: a flash is the pulse of the next tick, for no tick passes
  // before its outcome is known.
  std::vector<std::uint64_t> FiredTicks() override { return fired_; }
  // The driver's own: the family has none.
  std::uint8_t shutters() override { return driver->status().shutters_open; }
  bool lamp_on() override { return driver->Has(link::kLampOn); }
  double rate_hz() const override { return kIselRateHz; }
  double fast_rate_hz() const override { return kIselFastRateHz; }
  bool sees_cracks() const override { return false; }
  std::string stated_violation(std::string_view check) const override;
  const isel::VirtualIsel& isel() const { return machine_.isel; }

 private:
  void AdvanceController() override;
  IselMachine machine_;
  std::vector<std::uint64_t> fired_;
  std::size_t flash_count_ = 0;
};

/// 100 Hz, travel of +-50 mm.
MachineSpec IselProfile();
isel::VirtualIselOptions FineIsel();

std::unique_ptr<MotionRig> MakeIselMotionRig(const std::string& name,
                                             const std::string& serial_number);
std::unique_ptr<LaserRig> MakeIselLaserRig(const std::string& name,
                                           const std::string& serial_number);

}  // namespace intaglio::drivers
