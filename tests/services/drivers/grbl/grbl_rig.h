#pragma once

// A virtual grbl at the driver of its family, behind a line that a test cuts: as the rig
// of a motion driver, and as that of a laser driver.

#include <map>
#include <memory>
#include <string>

#include "proto/machine.pb.h"
#include "services/drivers/grbl/grbl_driver.h"
#include "services/platform/link/endpoint.h"
#include "services/platform/link/steady_clock.h"
#include "services/virtual_engraver/mill/virtual_grbl.h"
#include "tests/services/drivers/laser_rig.h"
#include "tests/services/drivers/motion_rig.h"
#include "tests/services/platform/link/faulty_line.h"

namespace intaglio::drivers {

/// 100 Hz, 250 steps/mm, travel of +-50 mm.
MachineSpec GrblProfile();

/// The controller, its line and its mains switch, on a clock that a test moves by 1 ms.
class GrblMachine {
 public:
  explicit GrblMachine(grbl::VirtualGrblOptions options);
  GrblMachine(const GrblMachine&) = delete;
  GrblMachine& operator=(const GrblMachine&) = delete;

  void Advance();
  void Cut(bool cut);
  void CutAfter(std::uint64_t bytes);
  void SwitchOff();
  /// Driven by its panel to where no controller is that was switched on just now.
  void LeaveZero();
  void SwitchOn();

  /// `serial_number` empty: the controller's.
  std::unique_ptr<GrblDriver> MakeDriver(const std::string& serial_number);
  /// For other drivers at this line.
  link::StreamOpener opener();
  link::SteadyClock clock() {
    return [this] { return now_; };
  }

  /// What a person or the machine does to the controller itself, of those kinds that need
  /// neither the line nor the mains switch; false: another kind.
  bool Inflict(ControllerFault fault);
  void Relieve(ControllerFault fault);

  grbl::VirtualGrbl grbl;
  MachineSpec profile = GrblProfile();  ///< of the drivers that are made

 private:
  bool on_ = true;
  std::chrono::nanoseconds now_ = std::chrono::hours(3);
  std::shared_ptr<link::FaultyPipe> to_grbl_, to_host_;
  std::shared_ptr<std::mt19937_64> random_ = std::make_shared<std::mt19937_64>(1);
  std::unique_ptr<link::ByteStream> end_;
};

inline constexpr double kGrblRateHz = 100, kGrblFastRateHz = 4000;

class GrblLaserRig final : public LaserRig {
 public:
  explicit GrblLaserRig(const std::string& serial_number = "");
  void CutLine(bool cut) override { machine_.Cut(cut); }
  void CutLineAfter(std::uint64_t bytes) override { machine_.CutAfter(bytes); }
  void SwitchOff() override { machine_.SwitchOff(); }
  void SwitchOn() override;
  bool Inflict(ControllerFault fault) override {
    return machine_.Inflict(fault) ||
           (fault != ControllerFault::kError &&
            fault != ControllerFault::kEmergencyStop && LaserRig::Inflict(fault));
  }
  void Relieve(ControllerFault fault) override {
    machine_.Relieve(fault);
    if (fault == ControllerFault::kUnplug) LaserRig::Relieve(fault);
  }
  // One chain on the door's input.
  void Set(Interlock, bool holds) override { machine_.grbl.SetDoor(!holds); }
  std::uint64_t tick() override { return driver->status().tick; }
  // By the controller's record: the line number has the tick modulo 1000.
  std::vector<std::uint64_t> FiredTicks() override { return fired_; }
  std::uint8_t shutters() override { return machine_.grbl.spindle_on() ? 1 : 0; }
  bool lamp_on() override { return driver->Has(link::kLampOn); }
  double rate_hz() const override { return kGrblRateHz; }
  double fast_rate_hz() const override { return kGrblFastRateHz; }
  bool sees_cracks() const override { return false; }
  // What was sent ahead is executed, and two barriers.
  std::chrono::milliseconds disarm_time() const override {
    return std::chrono::milliseconds(400);
  }
  std::string stated_violation(std::string_view check) const override;
  const grbl::VirtualGrbl& grbl() const { return machine_.grbl; }

 private:
  void AdvanceController() override;
  GrblMachine machine_;
  std::vector<std::uint64_t> fired_;
  std::size_t flash_count_ = 0;
};

std::unique_ptr<MotionRig> MakeGrblMotionRig(const std::string& name,
                                             const std::string& serial_number);
std::unique_ptr<LaserRig> MakeGrblLaserRig(const std::string& name,
                                           const std::string& serial_number);

}  // namespace intaglio::drivers
