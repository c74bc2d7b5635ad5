#include "services/synchronizer/engraving/engraving_inputs.h"

namespace intaglio::synchronizer {

ChainLinks LinksOf(const GrantInputs& inputs, const MotionView& motion,
                   const drivers::LaserController& laser, ChannelMask open_mask) {
  ChainLinks links;
  links.permission_fresh = inputs.permission_fresh;
  links.permission_granted = inputs.permission_granted;
  links.grant = inputs.grant;
  links.stop_not_pressed = !inputs.stop_pressed;
  links.laser_line_up = laser.IsFresh(inputs.now);
  links.key_on = laser.Has(link::kKeyOn);
  links.door_closed = laser.Has(link::kDoorClosed);
  links.stop_released = laser.Has(link::kStopReleased);
  links.inputs_hold = laser.accessories().open_input.empty();
  links.no_safe_state = !laser.Has(link::kSafeState);
  links.lamp_sync_counted = !laser.Has(link::kNoLampSync);
  links.lamp_warm = laser.Has(link::kLampOn) && laser.Has(link::kLampWarm);
  links.motion_fresh = motion.fresh;
  links.motion_without_fault = motion.fault == intaglio_MOTION_OK;
  links.motion_line_down = motion.line_down();
  if (laser.simulates_time()) {
    links.laser_late = laser.up() && !links.laser_line_up;
    links.motion_late = motion.answers && !motion.fresh;
  }
  // Another one that is open would let the pulses into another block.
  links.shutters_open = open_mask != 0 && laser.status().shutters_open == open_mask;
  links.counters = {laser.identity().power_up, laser.status().openings};
  return links;
}

std::string OtherDevice(const MotionView& motion, const drivers::LaserController& laser) {
  if (!laser.refusal().empty()) return laser.refusal();
  const bool other_stage =
      motion.fresh && motion.fault == intaglio_MOTION_WRONG_CONTROLLER;
  return other_stage ? motion.message : std::string();
}

}  // namespace intaglio::synchronizer
