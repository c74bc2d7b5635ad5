#pragma once

// How long a course takes, and its figures for people.

#include <string>
#include <vector>

#include "proto/job.pb.h"
#include "services/job/course/course_work.h"

namespace intaglio::cli {

/// How long it takes at these speeds, without acceleration, s. Idle ways include those up
/// and down.
struct WorkTime {
  double work_s = 0, idle_s = 0, drill_s = 0;
  double sum_s() const { return work_s + idle_s + drill_s; }
};
WorkTime TimeOf(const ContourWork& work, const Course& whole);

/// Lines of name and value.
std::vector<std::string> FiguresOf(const ContourWork& work, const Course& whole);

}  // namespace intaglio::cli
