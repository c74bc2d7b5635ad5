#pragma once

// The marks of a job of contours (JobSpec.course), for a machine that follows them: what
// the tool does in its order, with one pen for contours and one for holes.
//
// A machine without a tool changer makes one tool's work a job: where the files hold the
// work of several (contours and holes, holes of several diameters), drill_diameter_mm of
// the course says which. A laser cuts holes as circles, half the kerf inside.
//
// Frame: that of the files, mm; its origin is the machine's work zero.

#include <string>
#include <vector>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/mark/mark.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/job/models/model_sources.h"

namespace intaglio {

/// The names of the files, in the order in which MakeCourseMarks takes their bytes.
std::vector<std::string> CourseMarkFilesOf(const JobSpec& job);

/// In the order in which they are made. `job` has a course; its defaults are filled in
/// here. Errors as of CourseFilesOf and MakeContourWork. kUnsupported: work of several
/// tools, or of a tool that the machine has not; kInvalidValue: a hole narrower than the
/// kerf, more power than there is. kCancelled when `progress` returns false.
/// What files hold that is not made is added to `warnings`.
Result<mark::MarkSet> MakeCourseMarks(const JobSpec& job, const MachineSpec& machine,
                                      std::vector<FileBytes> files,
                                      const ReadLimits& limits, Warnings& warnings,
                                      const ProgressSink& progress);

/// As they are: MakeCourseMarks makes them in their order, inner contours of parts before
/// outer ones. Errors as of CheckMarks.
Result<mark::MarkSet> OrderCourseMarks(const JobSpec& job, const MachineSpec& machine,
                                       mark::MarkSet marks);

}  // namespace intaglio
