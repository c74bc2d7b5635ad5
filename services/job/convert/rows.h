#pragma once

// Straight rows of an order (BoustrophedonOrder): what their defaults follow from.

#include <optional>

#include "engrave/sort/order.h"
#include "proto/job.pb.h"
#include "proto/task.pb.h"

namespace intaglio {

/// The distance of the lattice (engrave/discretize/mesh/solid_lattice.h) that all points
/// of a job with the defaults of its models lie on, mm; nothing: not all models are
/// solids, their distances differ, or thinning leaves out some of the points.
std::optional<double> FindLatticeDistance(const JobSpec& job);

/// Fills in width and layer of the rows where the job leaves them open: those of the
/// lattice, else the minimum distance of its points. The job has its other defaults.
void FillRows(BoustrophedonOrder& rows, const JobSpec& job);

/// Of a job with its defaults on a machine with an arm and a rotary table: of the
/// directions of the lattice's rows, of others of 0 and 90 degrees, the one in which the
/// focus has the greatest speed in the middle of the block, of equal ones the greatest
/// acceleration, of equal ones the first. Of other machines 0, along x.
double DefaultRowTurnDeg(const FrozenJob& job);

/// `rows` has its width and layer; a direction that it leaves open is the default.
sort::BoustrophedonOptions RowOptionsOf(const FrozenJob& job,
                                        const BoustrophedonOrder& rows);

}  // namespace intaglio
