#pragma once

// Whether lens and head of a machine keep clear of the block and of what is fixed beside
// it: the rule of engrave/machine/clearance.h with the data of a profile. Every place
// that refuses a focus asks here: preview, admission, sorter and synchronizer.
//
// What a profile does not have is taken so that nothing is permitted that may collide: a
// lens without free_distance_mm has its lowest edge at its focal length above the focus,
// one without mount_diameter_mm is wider than the table. A head without head_body, or a
// lens without working_distance_mm, is unknown, and its head is not checked.

#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/machine/clearance.h"
#include "proto/task.pb.h"

namespace intaglio {

/// From the lowest edge of the lens to its focus in air, at most, mm: free_distance_mm,
/// else focal_length_mm.
double FreeDistanceMm(const MachineLens& lens);

/// The deepest focus below the top face that the lens allows over an open block, mm:
/// FreeDistanceMm over stage_per_glass_ratio, 0 < ratio <= 1.
double ReachMm(const MachineLens& lens, double stage_per_glass_ratio);

/// Bodies and solids of a job, each with its name. Frame: from the corner of the job's
/// block, along its sides, the focus in air, mm.
struct HeadClearance {
  machine::Clearance clearance;
  std::vector<std::string> bodies;  ///< "the lens f43", "the head of els-03"
  std::vector<std::string> solids;  ///< "the block", "the fixture \"stop\""
};

/// `job` with its defaults, a block, and one of the machine's lenses.
HeadClearance HeadClearanceOf(const JobSpec& job, const MachineSpec& machine);

/// The points in any order.
enum class PointOrder { kNone, kOfEngraving };

/// kOutsideBlock unless every point, and in the order of engraving the straight way
/// between any two that follow one another, keeps clear: how many do not, the worst of
/// them, what meets what, by how much, and what to do. Points in the glass frame, mm,
/// finite. A job whose lens is none of the machine's passes: CheckLens refuses it.
Status CheckHeadClearance(const FrozenJob& job, const PointList& points_mm,
                          PointOrder order);

}  // namespace intaglio
