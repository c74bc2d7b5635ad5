#pragma once

// The outcomes of the discretizers, combined from the parts of a job.

#include "engrave/core/warning.h"
#include "engrave/discretize/cloud.h"
#include "proto/job.pb.h"
#include "proto/task.pb.h"
#include "services/job/models/model_sources.h"

namespace intaglio {

/// Of one part. What is true of the models as a whole is reported with the first part.
DiscretizeOutcome OutcomeOf(const JobSources& sources,
                            const discretize::Discretized& made,
                            const discretize::Part& part);

/// Counts are added up, models and warnings taken over.
void AddPart(const DiscretizeOutcome& part, DiscretizeOutcome& all);

/// The outcome's own warnings, and those that follow from the counts of all parts
/// together. `job` with its defaults filled in.
Warnings WarningsOf(const DiscretizeOutcome& all, const JobSpec& job);

}  // namespace intaglio
