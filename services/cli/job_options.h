#pragma once

// The job that `intaglio run` and the offline commands are given, by a job file or by
// flags; flags given beside a job file replace its values.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "proto/job.pb.h"
#include "proto/machine.pb.h"
#include "services/cli/flags/method_flags.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

struct JobFlags {
  std::string job_file;
  std::vector<std::string> meshes;
  std::optional<double> height_mm, size_mm, unit_mm;
  std::vector<double> rotate_deg;  // none or three
  std::vector<double> block_mm;    // none or three
  std::optional<double> margin_mm;
  std::optional<std::string> glass;
  MethodFlags methods;
  std::optional<double> spacing_mm;
  std::optional<std::string> order;  // of Ordering, - for _
  std::optional<double> order_tries, order_time_s;
  std::optional<std::string> profile;  // of MotionProfile, - for _
  std::optional<double> rate_hz, speed_mm_s, acceleration_mm_s2, focal_mm;
  std::optional<std::string> machine;  // name of a supplied profile, or a file
  std::optional<std::string> name;
  bool clip = false;
  double size_limits = 1;  ///< factor (services/job/models/read_limits.h)
};

/// Adds the positional JOB and the flags.
void AddJobFlags(command_line::Command command, JobFlags& flags);

struct JobAndMachine {
  JobSpec job;
  MachineSpec machine;
  std::vector<std::string>
      notes;  ///< what was chosen for the user, e.g. the block's size
};

/// The job with all paths absolute, and its machine. Every mistake is in the error, one
/// a line, with the field's path.
Result<JobAndMachine> BuildJob(const JobFlags& flags);

/// The same for a job that the caller has read: flags, machine, defaults, checks.
Result<JobAndMachine> CompleteJob(const JobFlags& flags, JobSpec job);

/// The job file of a series, unchanged; --name is refused.
Result<JobSpec> ReadPattern(const JobFlags& flags);

/// As BuildJob, for points that are there already, mm: no model is needed or searched
/// for. Without a block and a model the points decide the block's size.
Result<JobAndMachine> BuildJobOfPoints(const JobFlags& flags, const PointList& points_mm);

/// A supplied machine profile by name ("els-03"), or a file. kNotFound lists the
/// supplied ones.
Result<std::filesystem::path> FindMachineFile(const std::string& name_or_file);

/// Folder of what comes with the product: machines/, jobs/.
std::filesystem::path SuppliedFolder();

}  // namespace intaglio::cli
