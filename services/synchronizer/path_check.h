#pragma once

// Whether every point of a path may be engraved: in the block, and within the reach and
// the travel of this machine's axes. Moves are straight or bounded by the planner's
// travel limits, so points suffice.

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/machine/axes_from_glass.h"
#include "proto/job.pb.h"

namespace intaglio::synchronizer {

/// By model of the job: the space its points may fill, frame glass, mm: the smallest of
/// the block and the blocks of its channels. The discretizer handles margins. One box for
/// a job without models.
std::vector<Box3> BlocksOfModels(const JobSpec& job);

/// The axes at each point, each near the one before, the first near the middle of
/// `travel`. kOutsideBlock, with how many points fail, the first of them, its place and
/// the limit, unless all points are finite, within 1 um inside the box of their model
/// (`path.source`; a model that `blocks` does not have gets the first), within reach, and
/// their axes within `travel`, 1 um and 10 urad allowed, too. `path`: glass frame, mm, in
/// the order of engraving. `blocks`: at least one. `frames`: by model, too; at least one.
Result<PointList> CheckedAxes(const PointCloud& path, const std::vector<Box3>& blocks,
                              const std::vector<machine::AxesFromGlass>& frames,
                              const Box3& travel);

}  // namespace intaglio::synchronizer
