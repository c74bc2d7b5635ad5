#pragma once

// Jobs of marks (a course, ...) and the machines that make them, whose profile has a
// mark_line: neither has anything to do with a block of glass.

#include "proto/job.pb.h"
#include "proto/machine.pb.h"

namespace intaglio {

/// What the job asks for is made as marks (engrave/mark), and not as points.
inline bool MakesMarks(const JobSpec& job) { return job.has_course() || job.has_marks(); }

/// A job of marks, a machine that makes marks, or both: neither is checked as a job of
/// points on a machine that engraves.
inline bool ConcernsMarks(const JobSpec& job, const MachineSpec& machine) {
  return MakesMarks(job) || machine.has_mark_line();
}

}  // namespace intaglio
