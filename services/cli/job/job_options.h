#pragma once

// The job that a command is given, by a job file or by flags (flags/job_flags.h); flags
// given beside a job file replace its values.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/cli/flags/job_flags.h"

namespace intaglio::cli {

struct JobAndMachine {
  JobSpec job;
  MachineSpec machine;
  std::vector<std::string>
      notes;  ///< what was chosen for the user, e.g. the block's size
  /// Warnings of its texts, as the discretizer will report them, each with its field.
  Warnings warnings = {};
  /// About places that were chosen for its models; in `notes`, too.
  Warnings of_arrangement = {};
};

/// The job with all paths absolute, and its machine. Every mistake is in the error, one
/// a line, with the field's path. A job of marks is refused.
Result<JobAndMachine> BuildJob(const JobFlags& flags);

/// The same of a job of points or of marks.
Result<JobAndMachine> BuildJobOfAnyKind(const JobFlags& flags);

/// As BuildJobOfAnyKind, of a job that is made: a model that is far too large or too
/// small for the block is refused before anything runs
/// (services/job/models/unfitted_sizes.h).
Result<JobAndMachine> BuildJobToEngrave(const JobFlags& flags);

/// As BuildJob, for a job that the caller has read: flags, machine, defaults, checks.
Result<JobAndMachine> CompleteJob(const JobFlags& flags, JobSpec job);

/// The job of a file that has a course (proto/course.proto); none of others, and of a
/// file that cannot be read, which BuildJob reports. kInvalidValue: options of points
/// beside it, which would do nothing.
Result<std::optional<JobSpec>> FindCourseJob(const JobFlags& flags);

/// The job file of a series, unchanged; --name is refused.
Result<JobSpec> ReadPattern(const JobFlags& flags);

/// As BuildJob, for points that are there already, mm: no model is needed or searched
/// for. Without a block and a model the points decide the block's size.
Result<JobAndMachine> BuildJobOfPoints(const JobFlags& flags, const PointList& points_mm);

/// A supplied machine profile by name ("els-03"), or a file. kNotFound lists the
/// supplied ones.
Result<std::filesystem::path> FindMachineFile(const std::string& name_or_file);

}  // namespace intaglio::cli
