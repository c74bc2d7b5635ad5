#include "services/job/machine/head_warnings.h"

#include <fmt/format.h>

#include <utility>

#include "services/job/machine/head_ticks.h"

namespace intaglio {

namespace {

/// What a step of a board's axis is, and its speed, is not published.
std::vector<Error> AxisWarningsOf(const MachineSpec& machine) {
  if (machine.motion_line().protocol() != "bjjcz" ||
      machine.head_over_block().z().has_scale_ratio())
    return {};
  return {
      {ErrorCode::kMissing,
       "head_over_block.z.scale_ratio: is missing, so nobody has measured the axis of "
       "the board: move z by 10 mm (intaglio teach jog z 10), measure it, correct "
       "z.steps_per_mm, and give the rest, measured over commanded: 1 if it is exact",
       ""}};
}

std::vector<Error> JumpWarningsOf(const MachineSpec& machine) {
  const auto ticks = TickOptionsOf(machine.scan_head(), mark::Pen(), 1e5);
  const bool burns_jumps = ticks.lag_s > 0 && !ticks.lead_servo && ticks.run_in_s == 0 &&
                           ticks.jump_delay_s == 0;
  if (!burns_jumps) return {};
  return {{ErrorCode::kInvalidValue,
           fmt::format("scan_head.run_in_s: 0, with no scan_head.jump_delay_s and no "
                       "scan_head.lead_servo: the mirrors are {:g} s behind, so the end "
                       "of each jump is burnt; give a run-in or a jump delay of {:g} s "
                       "or more, or remove lead_servo: false",
                       ticks.lag_s, 3 * ticks.lag_s),
           "0"}};
}

}  // namespace

std::vector<Error> HeadWarningsOf(const MachineSpec& machine) {
  std::vector<Error> warnings = JumpWarningsOf(machine);
  for (Error& warning : AxisWarningsOf(machine)) warnings.push_back(std::move(warning));
  return warnings;
}

}  // namespace intaglio
