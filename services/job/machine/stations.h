#pragma once

// The stations of a machine's table: where the block of each lies, and whether a
// profile's loading and the station of a job are possible. Trochimczuk 2008 ch. 8.3:
// several pieces on the table, on a round one by a constant turn; (129): a piece of side
// a, y2 from the axis of a table of radius r2, lies on it when y2 + a <= r2.

#include <cstdint>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// 1 without a loading.
std::uint32_t StationCountOf(const MachineSpec& machine);

/// Of a block, from where that of station 1 lies: moved, then turned about the axis of
/// the table, which is the origin of the machine frame, counterclockwise seen from above.
struct StationPlace {
  Vec3 offset_mm = Vec3::Zero();  ///< of its corner, machine frame
  double turn_rad = 0;            ///< of an arm and a table, -2 pi..2 pi
};

/// That of station 1 for a number that is no station of the machine.
StationPlace StationPlaceOf(const MachineSpec& machine, std::uint32_t station);
StationPlace StationPlaceOf(const MachineSpec& machine, const JobSpec& job);

/// Of a profile whose kinematics are good.
void CheckLoading(const MachineSpec& machine, std::vector<Error>& errors);

/// Whether the machine has the job's station, the block lies on the table, and at another
/// station than the first, whether blocks of this size have room beside one another.
/// `job` with its defaults, and a block.
void CheckStation(const JobSpec& job, const MachineSpec& machine, Findings& findings);

}  // namespace intaglio
