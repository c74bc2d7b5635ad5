#pragma once

// Checks the contours of a job (proto/course.proto).

#include <vector>

#include "proto/job.pb.h"
#include "services/job/fields/findings.h"

namespace intaglio {

/// Ranges, files that do not exist, and what excludes each other, e.g. models beside
/// contours. `job` as it was read.
std::vector<Finding> CheckCourse(const JobSpec& job);

/// What a service and a command that makes points say of a job of contours; empty for
/// others.
std::vector<Finding> RefuseCourse(const JobSpec& job);

}  // namespace intaglio
