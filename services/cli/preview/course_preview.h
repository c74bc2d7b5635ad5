#pragma once

// What a job of contours will look like and take: its contours as the tool follows them,
// their lengths and times. The same files and the same contours as of `intaglio contour`.

#include <filesystem>

#include "engrave/core/result.h"
#include "proto/preview.pb.h"
#include "services/job/models/read_limits.h"

namespace intaglio::cli {

/// The picture of a job of contours, in the folder of its preview.
inline constexpr char kCoursePicture[] = "preview.svg";

/// Reads the files of `job`, which has a course, and writes preview.json and the picture.
/// Errors of the files and of what cannot be made, each with its place.
Result<JobPreview> PreviewCourse(const JobSpec& job, double size_limits,
                                 const std::filesystem::path& folder);

}  // namespace intaglio::cli
