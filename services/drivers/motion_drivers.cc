#include "services/drivers/motion_drivers.h"

#include <fmt/format.h>

#include <array>

#include "engrave/core/try.h"
#include "services/drivers/bjjcz/board_profile.h"
#include "services/drivers/bjjcz/point_driver.h"
#include "services/drivers/grbl/grbl_driver.h"
#include "services/drivers/grbl/grbl_settings.h"
#include "services/drivers/isel/isel_driver.h"
#include "services/drivers/laser_drivers.h"
#include "services/drivers/linuxcnc/hal_limits.h"
#include "services/drivers/linuxcnc/linuxcnc_driver.h"
#include "services/drivers/virtual/virtual_cell_driver.h"
#include "services/drivers/virtual/virtual_stage_driver.h"
#include "services/platform/link/driver_table.h"

namespace intaglio::drivers {
namespace {

constexpr std::array kMotionKinds = {
    MotionDriverKind{"virtual-stage", true, &MakeVirtualStageDriver, false, nullptr,
                     nullptr, true, true},
    MotionDriverKind{"virtual-cell", true, &MakeVirtualCellDriver, true, nullptr, nullptr,
                     true, true},
    MotionDriverKind{"grbl", true, &MakeGrblDriver, true, &CheckGrblProfile,
                     &CompareGrblController},
    MotionDriverKind{"isel", true, &MakeIselDriver, true},
    MotionDriverKind{"bjjcz", true, &MakeBjjczPointDriver, true, &CheckBjjczPointProfile},
    MotionDriverKind{"linuxcnc", false, &MakeLinuxcncDriver, true, &CheckLinuxcncProfile,
                     &CompareLinuxcnc},
};

}  // namespace

std::span<const MotionDriverKind> MotionDriverKinds() { return kMotionKinds; }

Status CheckMotionOutput(const MachineSpec& machine) {
  const std::string& protocol = machine.motion_line().protocol();
  std::string known;
  for (const MotionDriverKind& kind : MotionDriverKinds()) {
    if (!kind.switches_laser) continue;
    if (kind.protocol == protocol) return {};
    known += (known.empty() ? "" : ", ") + std::string(kind.protocol);
  }
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("laser_line.protocol: 'motion-output' needs a motion controller "
                  "that switches the laser, and motion_line.protocol is '{}'; "
                  "there are: {}",
                  protocol, known.empty() ? "none" : known),
      protocol);
}

Status CheckAir(const MachineSpec& machine, const MotionDriverKind& kind) {
  if (!machine.compressed_air() || kind.watches_air) return {};
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("compressed_air: the driver '{}' does not watch compressed air; "
                  "connect the pressure switch to the controller's own chain and "
                  "remove the field",
                  kind.protocol));
}

Status CheckBlockStage(const MachineSpec& machine, const MotionDriverKind& kind) {
  if (!machine.head_over_block().has_block_stage() || kind.moves_block) return {};
  std::string able;
  for (const MotionDriverKind& other : MotionDriverKinds()) {
    if (other.moves_block)
      able += (able.empty() ? "" : ", ") + std::string(other.protocol);
  }
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("head_over_block.block_stage: the driver '{}' moves no stage that "
                  "carries the block; those of {} do; remove the field, and move "
                  "the block by hand between the jobs of intaglio tiles",
                  kind.protocol, able),
      std::string(kind.protocol));
}

Result<std::unique_ptr<MotionDriver>> MakeMotionDriver(const MachineSpec& machine) {
  const SerialLine& line = machine.motion_line();
  const auto kind = INTAGLIO_TRY(link::FindDriver(
      MotionDriverKinds(), {"motion_line", line.protocol(), line.device()}));
  INTAGLIO_TRY(CheckAir(machine, *kind));
  INTAGLIO_TRY(CheckBlockStage(machine, *kind));
  if (kind->check != nullptr) {
    if (const auto errors = kind->check(machine); !errors.empty())
      return tl::unexpected(errors.front());
  }
  return kind->make(machine, link::EndpointOpener(line.device(), line.baud()),
                    link::MonotonicClock());
}

}  // namespace intaglio::drivers
