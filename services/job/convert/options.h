#pragma once

// Converts jobs, which are written for people (degrees, defaults), to the plain options
// of engrave/ (radians, all values set); the methods of discretization do so in their
// rows (methods/method.h). All take jobs with every default filled in (job_defaults.h,
// services/job/files/freeze.h); a broken precondition throws.

#include <string>

#include "engrave/motion/planner.h"
#include "engrave/sort/order.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "proto/task.pb.h"

namespace intaglio {

/// The beam above a point, and what the cracks of the job's lens take of it.
sort::BeamCone BeamConeOf(const FrozenJob& job);

/// The same of cracks that are points: what is counted of an order. Frame glass.
sort::BeamCone PointConeOf(const FrozenJob& job);
/// The same in the frame machine, for places in air (optics/machine_frame.h).
sort::BeamCone PointConeInMachine(const FrozenJob& job);

/// Method, the beam's cone with the cracks of the job's lens, and the stage's limits in
/// the glass, and the energies of places. Where the order Kdz leaves its weight open, it
/// follows from the cone, and the direction of rows from the machine (rows.h).
/// Workers and a time budget (AnnealOrder.time_s) are the caller's to set.
sort::OrderOptions OrderOptionsOf(const FrozenJob& job);

/// "continuous", or the name of the profile in engrave/motion/profiles.h; empty for a
/// number that is none.
std::string ProfileName(MotionProfile profile);

/// How the axes of a job are driven, in their units. Limits: the machine's, capped by the
/// job's, and its travel (machine_axes.h). Its error limit leaves a fifth of the
/// machine's tolerance to what no model has, and half a step of the axes.
motion::PlanOptions MotionOptionsOf(const FrozenJob& job);

}  // namespace intaglio
