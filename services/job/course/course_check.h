#pragma once

// Checks and completes the contours of a job (proto/course.proto).

#include <vector>

#include "proto/job.pb.h"
#include "services/job/findings.h"

namespace intaglio {

/// Every default but the speed of plunging, which is that at work, and depth_mm, which a
/// laser does not have, with the height of tabs, half of it, is a constant of
/// course.proto.
Course WithDefaults(Course course);

/// Ranges, files that do not exist, and what excludes each other, e.g. models beside
/// contours. `job` as it was read.
std::vector<Finding> CheckCourse(const JobSpec& job);

/// What a service and a command that makes points say of a job of contours; empty for
/// others.
std::vector<Finding> RefuseCourse(const JobSpec& job);

}  // namespace intaglio
