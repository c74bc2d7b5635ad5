#pragma once

// What is engraved: the points of one job in the machine's frame, and the job's choices.

#include <cstdint>
#include <string>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "engrave/motion/planner.h"
#include "engrave/optics/machine_frame.h"
#include "services/synchronizer/pulses/earlier_work.h"

namespace intaglio::synchronizer {

struct EngravingJob {
  std::string uid;
  PointList machine_points_mm;  ///< in the order of engraving, machine frame
  optics::MachineFromGlass machine_from_glass = {};  ///< for messages
  double cone_tangent = 0;  ///< half angle of the beam above a point, machine frame
  motion::PlanOptions plan;
  ChannelMask shutter_mask = 1;  ///< of all points
  /// Of each point, when they differ: it is made with these shutters open and no other.
  std::vector<ChannelMask> masks = {};
  /// Pulses that no crack was seen of, until it pauses.
  std::uint32_t max_missed_in_a_row = 5;
  bool photosensor_feedback = true;  ///< false: nothing sees cracks, fired is made
  /// Points of which nobody knows whether they were fired: a person is asked.
  bool asks_when_uncertain = false;
  /// Why nothing is to be fired into the block that is in the machine; empty: it is.
  std::string block_misfit = {};
  EarlierWork earlier = {};
};

}  // namespace intaglio::synchronizer
