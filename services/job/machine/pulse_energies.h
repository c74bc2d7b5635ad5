#pragma once

// With which energy a job's points are made, in front of the lens, mJ: it follows from
// their models. All take jobs with every default filled in.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/result.h"
#include "proto/job.pb.h"

namespace intaglio {

/// By model; of a model that names none, and of a job without models, the laser's.
std::vector<double> EnergiesOfModels(const JobSpec& job);

/// The energies that occur, each once, rising.
std::vector<double> DistinctEnergies(const JobSpec& job);

struct PointEnergies {
  std::vector<double> distinct_mj = {0};  ///< each once, rising; one or more
  /// Of each point its place in distinct_mj; empty: all have the first.
  std::vector<std::uint32_t> of_point = {};

  std::uint32_t PlaceOf(std::uint32_t point) const {
    return of_point.empty() ? 0 : of_point[point];
  }
  double Of(std::uint32_t point) const { return distinct_mj[PlaceOf(point)]; }
};

/// `source`: the number of the model of each point. kFault: there is no such model, and
/// the models differ in their energies.
Result<PointEnergies> EnergiesOfPoints(const JobSpec& job,
                                       std::span<const std::uint32_t> source);

}  // namespace intaglio
