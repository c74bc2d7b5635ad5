#pragma once

// What the Engraving and the PermissionChain are given from outside at one turn.

#include <chrono>
#include <cstdint>
#include <string>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "idl/motion.h"
#include "services/cell/grant_inputs.h"
#include "services/cell/permission_chain.h"
#include "services/drivers/interface/laser_controller.h"
#include "services/synchronizer/pulses/cell_names.h"
#include "services/synchronizer/pulses/motion_clock.h"

namespace intaglio::synchronizer {

/// The bridge's newest MotionState, and whether it is young enough to act on.
struct MotionView {
  bool fresh = false;
  std::uint64_t tick = 0;
  Vec3 position_mm = Vec3::Zero();
  std::uint32_t run = 0;
  std::uint32_t highest_run = 0;
  std::uint64_t covered_through_tick = 0;
  bool at_rest = false;
  intaglio_MotionFault fault = intaglio_MOTION_LINK_LOST;
  std::string message;
  std::uint32_t clock = 0;  ///< the controller's own; 0: it runs on the lamp's ticks
  double position_tolerance_um = 0;  ///< of the controller; 0: not known
  bool has_block_stage = false;  ///< the controller moves a stage that carries the block
  Vec2 block_mm = Vec2::Zero();  ///< its place, by its own axes
  bool answers = false;  ///< a state has come, and its bridge is not known to have ended

  /// Nothing is known of the stage and nothing reaches it.
  bool line_down() const {
    return fault == intaglio_MOTION_LINK_LOST ||
           fault == intaglio_MOTION_WRONG_CONTROLLER;
  }
  /// The bridge clears the fault when it begins a run, or there is none. Every other one
  /// refuses the run until its cause is gone: a line, air or a place that is lost.
  bool is_cleared_by_a_run() const {
    return !line_down() && fault != intaglio_MOTION_NO_AIR &&
           fault != intaglio_MOTION_PLACE_LOST;
  }
  /// The controller reports the block at this place, by its stage's axes.
  bool HasBlockAt(const Vec2& place_mm, double tolerance_mm) const {
    return has_block_stage && (block_mm - place_mm).norm() <= tolerance_mm;
  }
};

/// The line to the controller is down, or what it carries came too late; every other
/// fault is one that the controller reports of itself.
constexpr bool IsLateMotion(intaglio_MotionFault fault) {
  return fault == intaglio_MOTION_LINK_LOST || fault == intaglio_MOTION_STARVED ||
         fault == intaglio_MOTION_LATE;
}

/// The state of the world outside, of one turn.
struct EngravingInputs : GrantInputs {
  MotionView motion;
  /// A controller with a clock of its own has it; lives as long as the Engraving.
  MotionClock* motion_clock = nullptr;
  /// The stage is driven to where the job begins: no run begins meanwhile.
  bool stage_approaches = false;
  /// Why the block was not brought to the job's place, in the turn in which its motion
  /// ended; empty: it was, or has not ended.
  std::string block_failure = {};
};

/// The links of the permission chain as the inputs and the laser controller have them.
/// `open_mask`: the shutters that have to be open, and no other; 0: none may fire.
ChainLinks LinksOf(const GrantInputs& inputs, const MotionView& motion,
                   const drivers::LaserController& laser, ChannelMask open_mask);

/// Why one of the lines leads to another device than the profile's; empty: none does.
std::string OtherDevice(const MotionView& motion, const drivers::LaserController& laser);

}  // namespace intaglio::synchronizer
