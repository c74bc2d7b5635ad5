#pragma once

// The files of a course, read from this machine's disks, and what is made of them.

#include <string>

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "services/job/course/course_files.h"
#include "services/job/course/course_work.h"

namespace intaglio::cli {

/// Errors of the disk, and as of CourseFilesOf; `warnings` are added before them, too.
Result<CourseFiles> ReadCourseFiles(const Course& course, double size_limits,
                                    Warnings& warnings,
                                    const CourseFileOptions& options = {});

struct MadeContours {
  CourseFiles files;
  ContourWork work;
};

/// The contours of a course with its defaults filled in, behind a progress bar.
/// `start_mm`: where the tool comes from. Errors as of ReadCourseFiles and
/// MakeContourWork; `warnings` are added before them, too.
Result<MadeContours> ContoursFromFiles(const Course& whole, double size_limits,
                                       const Vec2& start_mm, Warnings& warnings,
                                       const CourseFileOptions& options = {});

}  // namespace intaglio::cli
