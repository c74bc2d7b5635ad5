#pragma once

// The options of a job, in groups by what a command does with it: a command has those
// that change its result.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "services/cli/flags/method_flags.h"
#include "services/cli/flags/text_flags.h"
#include "services/job/models/kept_meshes.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

struct JobFlags {
  /// What stands without an option: a job file, or models; BuildJob and the like tell
  /// them apart.
  std::vector<std::string> what;
  std::string job_file;
  std::vector<std::string> meshes;
  std::optional<double> height_mm, size_mm, unit_mm;
  std::optional<std::string> up;   // of UpAxis: "z", "-y", "declared"
  std::vector<double> rotate_deg;  // none or three
  std::vector<double> block_mm;    // none or three
  std::optional<double> margin_mm;
  std::optional<std::string> glass;
  std::optional<double> glass_index;
  MethodFlags methods;
  TextFlags texts;
  std::optional<double> spacing_mm;
  std::optional<std::string> order;  // of Ordering, - for _
  std::optional<double> order_tries, order_time_s;
  std::optional<std::uint32_t> order_pieces;
  std::optional<std::string> profile;  // of MotionProfile, - for _
  std::optional<double> rate_hz, speed_mm_s, acceleration_mm_s2, focal_mm;
  std::optional<std::string> machine;  // name of a supplied profile, or a file
  std::optional<std::string> name;
  // "PATH=VALUE" of JobSpec, services/job/fields/field_path.h
  std::vector<std::string> fields;
  std::optional<std::string> turn_block;  // degrees: "90", "180", "270"
  bool clip = false;
  double size_limits = 1;  ///< factor (services/job/models/read_limits.h)
  /// Not null in a command that makes points several times.
  std::shared_ptr<KeptMeshes> kept_meshes = nullptr;
};

/// The positional JOB|MODEL: what the job is made from.
void AddWhat(command_line::Command command, JobFlags& flags);
/// The positional JOB: the job file, where models are of no use.
void AddJobFile(command_line::Command command, JobFlags& flags);
/// --mesh, and how it comes into the block.
void AddModelFlags(command_line::Command command, JobFlags& flags);
/// --block alone, for points that are placed already.
void AddBlockFlag(command_line::Command command, JobFlags& flags);
void AddMarginFlag(command_line::Command command, JobFlags& flags);
/// --block, --margin, --clip, --turn-block.
void AddBlockFlags(command_line::Command command, JobFlags& flags);
void AddSpacingFlag(command_line::Command command, JobFlags& flags);
/// --spacing, --method and the options of the methods.
void AddPointFlags(command_line::Command command, JobFlags& flags);
void AddOrderFlags(command_line::Command command, JobFlags& flags);
/// --profile, --rate and the limits of the stage.
void AddMotionFlags(command_line::Command command, JobFlags& flags);
/// --machine, --glass, --glass-index, --focal.
void AddMachineFlags(command_line::Command command, JobFlags& flags);
/// --machine and --focal, where the glass does not matter.
void AddLensFlags(command_line::Command command, JobFlags& flags);

/// --set: any field of the job by its path.
void AddSetFlag(command_line::Command command, JobFlags& flags);

/// All but the positional JOB|MODEL, --name and --size-limits.
void AddJobOptions(command_line::Command command, JobFlags& flags);
/// JOB|MODEL and all options: of a command that engraves.
void AddJobFlags(command_line::Command command, JobFlags& flags);

}  // namespace intaglio::cli
