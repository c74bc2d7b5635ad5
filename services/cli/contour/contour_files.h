#pragma once

// The files of a course, read from this machine's disks.

#include <string>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "services/job/course/course_files.h"

namespace intaglio::cli {

/// Errors of the disk, and as of CourseFilesOf; `warnings` are added before them, too.
Result<CourseFiles> ReadCourseFiles(const Course& course, double size_limits,
                                    Warnings& warnings,
                                    const CourseFileOptions& options = {});

}  // namespace intaglio::cli
