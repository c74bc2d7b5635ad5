#pragma once

// Jobs of marks (a course, ...) and the machines that make them, whose profile has a
// mark_line: neither has anything to do with a block of glass.

#include <vector>

#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/findings.h"

namespace intaglio {

/// What the job asks for is made as marks (engrave/mark), and not as points.
bool MakesMarks(const JobSpec& job);

/// A job of marks, a machine that makes marks, or both: neither is checked as a job of
/// points on a machine that engraves.
inline bool ConcernsMarks(const JobSpec& job, const MachineSpec& machine) {
  return MakesMarks(job) || machine.has_mark_line();
}

/// Everything that is wrong with a job of marks on this machine, the machine's own fields
/// left out: also that one of them makes points.
std::vector<Finding> CheckMarkJob(const JobSpec& job, const MachineSpec& machine);

/// Every default that such a job has.
JobSpec WithMarkDefaults(JobSpec job);

}  // namespace intaglio
