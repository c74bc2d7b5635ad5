#pragma once

// With which energy each point of a job is made, mJ: that of its model
// (pulse_energies.h), raised at a scan head over the block by what the intensity of an
// oblique beam loses at the place, up to the laser's largest. So all points are as strong
// as an upright beam makes them, as far as the laser can.
//
// Energies are steps of 5 % above the model's, rounded up: neighbours have the same one,
// and a window of ticks or a list of a board has one energy.

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "proto/task.pb.h"
#include "services/job/beams/job_beams.h"
#include "services/job/machine/pulse_energies.h"

namespace intaglio {

/// Largest step from one energy to the next.
inline constexpr double kEnergyStepRatio = 1.05;

/// Why the energy does not follow the place, as a sentence; empty: it follows.
std::string WhyOneEnergy(const FrozenJob& job);

/// Number of the step of energy at each place of the block (glass frame, mm), of points
/// with the job's laser.pulse_energy_mj: for the order of a head that jumps and dwells,
/// whose lists have one energy each. Empty for others, and where one energy serves all.
std::function<std::uint32_t(const Vec3& glass_mm)> EnergyStepsOf(const FrozenJob& job);

/// Raised by place: points in the glass frame, mm; `of_models`: by their models.
PointEnergies RaisedByPlace(const JobBeams& beams, double largest_mj,
                            const PointList& points_mm, const PointEnergies& of_models);

/// `source`: the number of the model of each point. kFault as of pulse_energies.h.
Result<PointEnergies> EnergiesOfPoints(const FrozenJob& job, const PointList& points_mm,
                                       std::span<const std::uint32_t> source);

}  // namespace intaglio
