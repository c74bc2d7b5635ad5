#pragma once

// Whether every point of a path may be engraved: in the block, and within the travel of
// this machine. Moves are straight or bounded by the planner's travel limits, so points
// suffice.

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/optics/machine_frame.h"
#include "proto/job.pb.h"

namespace intaglio::synchronizer {

/// By model of the job: the space its points may fill, frame glass, mm: the smallest of
/// the block and the blocks of its channels. Margins are the discretizer's affair. One
/// box for a job without models.
std::vector<Box3> BlocksOfModels(const JobSpec& job);

/// kOutsideBlock, with how many points fail, the first of them, its place and the limit,
/// unless all points are finite, within 1 um inside the box of their model
/// (`path.source`; a model that `blocks` does not have gets the first), and their machine
/// positions within `travel`, 1 um allowed, too. `path`: glass frame, mm, in the order of
/// engraving. `blocks`: at least one.
Status CheckPath(const PointCloud& path, const std::vector<Box3>& blocks,
                 const optics::MachineFromGlass& machine_from_glass, const Box3& travel);

}  // namespace intaglio::synchronizer
