#pragma once

// The driver of marks with LinuxCNC itself and a beam, in real time: a step is a
// millisecond or more.

#include <memory>
#include <string>

#include "proto/machine.pb.h"
#include "tests/services/drivers/linuxcnc/hal_machine.h"
#include "tests/services/drivers/linuxcnc/hal_tap.h"
#include "tests/services/drivers/marks/mark_rig.h"

namespace intaglio::linuxcnc {

/// Its axes are those of simulated.hal; the work begins at 10, 20 mm of them.
MachineSpec CutterProfile(const std::filesystem::path& folder);
mark::Pen CutterPen(double speed_mm_s);

class BeamRig final : public drivers::MarkRig {
 public:
  /// `change`: of its profile; null: none.
  explicit BeamRig(const std::string& serial_number = "",
                   void (*change)(MachineSpec& profile) = nullptr);
  ~BeamRig() override;

  void CutLine(bool cut) override { tap.Cut(cut); }
  bool Inflict(drivers::ControllerFault fault) override;
  void Relieve(drivers::ControllerFault fault) override;
  void SetDoor(bool closed) override;
  bool knows_power_ups() const override { return false; }
  std::unique_ptr<drivers::MarkDriver> MakeDriver(
      const std::string& serial_number) override;
  std::uint64_t work_count() override { return tap.work_count(); }
  bool is_on() override { return tap.newest().Has(drivers::kHalLaser); }
  /// The axes' file finds the place, nobody through the driver.
  bool can_lose_place() const override { return false; }
  mark::MarkSet MarksFor(int count) override;
  std::chrono::milliseconds stop_time() const override {
    return std::chrono::milliseconds(200);
  }
  /// halcmd takes it, and some periods see it.
  void Command(const std::string& command);

  HalTap tap;
  HalMachine machine;

 private:
  void (*change_)(MachineSpec& profile);
  void AdvanceController() override;
};

/// In a folder of the test's own; null when HAL cannot run here.
std::unique_ptr<drivers::MarkRig> MakeBeamRig(const std::string& serial_number = "");

}  // namespace intaglio::linuxcnc
