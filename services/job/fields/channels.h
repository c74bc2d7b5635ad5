#pragma once

// In which channels a job's points are made, and in which blocks they come to lie: it
// follows from their models. All take jobs with every default filled in.

#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/result.h"
#include "proto/job.pb.h"

namespace intaglio {

/// By model. Without models, or when a model names none, those of the laser.
std::vector<ChannelMask> ChannelsOfModels(const JobSpec& job);

/// One a point, by the number of its model. kFault: there is no such model, and they
/// differ in their channels.
Result<std::vector<ChannelMask>> ChannelsOfPoints(const JobSpec& job,
                                                  std::span<const std::uint32_t> source);

/// What the blocks of the model's channels have in common: as wide, deep and high as each
/// of them, with the job's margin.
Block BlockOf(const JobSpec& job, const Model& model);

}  // namespace intaglio
