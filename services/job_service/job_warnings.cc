#include "services/job_service/job_warnings.h"

#include "services/job/models/discretize_outcome.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::job_service {

Warnings WarningsOf(const AttemptOutcomes& outcomes, std::size_t part_count,
                    const JobSpec& job) {
  DiscretizeOutcome points;
  for (const DiscretizeOutcome& part : outcomes.parts) AddPart(part, points);
  if (outcomes.parts.size() < part_count) points.clear_methods();
  Warnings warnings = intaglio::WarningsOf(points, job);
  if (outcomes.sort) {
    const Warnings of_path = intaglio::WarningsOf(outcomes.sort->warnings());
    warnings.insert(warnings.end(), of_path.begin(), of_path.end());
  }
  return warnings;
}

}  // namespace intaglio::job_service
