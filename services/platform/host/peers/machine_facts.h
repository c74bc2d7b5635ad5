#pragma once

// What is known of a machine at a glance: the one way from the samples of its services to
// what a shop's status says, whether a client receives them or a job service hands them
// on.

#include <vector>

#include "services/platform/bus/topics.h"
#include "services/platform/host/safety/stop_latch.h"

namespace intaglio::host {

struct MachineFacts {
  bool has_interlock = false;  ///< the next thirteen are known only then
  bool laser_line_up = false, key_on = false, door_closed = false, door_locked = false,
       stop_released = false;
  bool lamp_on = false, lamp_warm = false, safe_state = false;
  std::uint8_t shutters_open = 0;     ///< bit 0..3: channels 1..4
  bool stop_pressed = false;          ///< on the bus
  std::vector<StopPress> stops_held;  ///< its presses
  std::string open_input;  ///< of the profile, and what to do; empty: none is open
  std::string outputs_on;  ///< names of the profile, separated by ", "
  bool has_lamp = false;
  double warm_ratio = 0, rate_hz = 0;
  bool has_motion = false;
  intaglio_MotionFault motion_fault = intaglio_MOTION_OK;
  std::string motion_message;
  bool has_block_stage = false;
  double block_x_mm = 0, block_y_mm = 0;  ///< of its own axes

  bool operator==(const MachineFacts&) const = default;
};

/// What the sample says of its machine takes the place of what was known.
void Update(MachineFacts& facts, const intaglio_Interlock& sample);
void Update(MachineFacts& facts, const intaglio_LampSync& sample);
void Update(MachineFacts& facts, const intaglio_MotionState& sample);
void Update(MachineFacts& facts, const intaglio_MachineFacts& sample);
/// What `other` knows takes the place of what was known.
void Update(MachineFacts& facts, const MachineFacts& other);

/// For a sample, which borrows from it.
class WireFacts {
 public:
  explicit WireFacts(const MachineFacts& facts);
  WireFacts(const WireFacts&) = delete;
  const intaglio_MachineFacts& sample() const { return sample_; }

 private:
  MachineFacts facts_;
  std::vector<intaglio_StopPress> stops_;
  intaglio_MachineFacts sample_{};
};

}  // namespace intaglio::host
