#pragma once

// What is engraved: the points of one job in the machine's frame, and the job's choices.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/geometry.h"
#include "engrave/machine/axes_from_glass.h"
#include "engrave/motion/planner.h"
#include "engrave/sort/beam/beam_cone.h"
#include "services/cell/earlier_work.h"
#include "services/job/machine/pulse_energies.h"
#include "services/synchronizer/pulses/cell_names.h"
#include "services/synchronizer/pulses/pulse_trigger.h"

namespace intaglio::synchronizer {

struct EngravingJob {
  std::string uid;
  /// The machine's axes at each point (mm, or rad of those that turn), in the order of
  /// engraving.
  PointList machine_points_mm;
  machine::AxesFromGlass machine_from_glass = {};  ///< for messages
  /// Where the focus is in air, machine frame; empty: the axes are the same numbers.
  PointList places_mm = {};
  sort::BeamCone cone;  ///< the beam above a point, frame machine
  motion::PlanOptions plan;
  motion::Limits machine_limits = {};  ///< of the axes; >= those of `plan`
  const PulseTrigger* trigger = &TriggerAtTick();
  ChannelMask shutter_mask = 1;  ///< of all points
  PointEnergies energies = {};   ///< of the pulses, before a splitter
  /// When points differ, each is made with exactly these shutters open.
  std::vector<ChannelMask> masks = {};
  /// Number of pulses in a row for which no crack was seen, until it pauses.
  std::uint32_t max_missed_in_a_row = 5;
  /// Points that are armed at a time without a result; 0: no limit.
  std::uint32_t max_unsettled_points = 0;
  /// 0: as the laser makes them by itself.
  std::uint16_t pulses_per_point = 0;
  bool needs_door_lock = false;  ///< the profile has one: no pulse while it does not hold
  bool lamp_stays = false;       ///< on when the job has ended by itself
  bool photosensor_feedback = true;  ///< false: no sensor sees cracks, a fired point
                                     ///< counts as made
  double position_tolerance_um = 0;  ///< of the profile; 0: not known
  /// Where the stage that carries the block has to be, by its own axes, mm; none: the
  /// machine has no such stage.
  std::optional<Vec2> block_stage_mm = {};
  /// A person is asked about points of which it is not known whether they were fired.
  bool asks_when_uncertain = false;
  /// Why nothing may be fired into the block that is in the machine; empty: it may.
  std::string block_misfit = {};
  EarlierWork earlier = {};
};

}  // namespace intaglio::synchronizer
