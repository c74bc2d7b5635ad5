#include "services/cli/flags/job_flags.h"

#include <google/protobuf/descriptor.h>

#include <algorithm>

#include "services/cli/flags/size_limits_flag.h"
#include "services/job/convert/options.h"

namespace intaglio::cli {
namespace {

constexpr const char* kModel = "Model";
constexpr const char* kBlock = "Block";
constexpr const char* kPoints = "Points";
constexpr const char* kOrder = "Order";
constexpr const char* kMotion = "Motion";
constexpr const char* kMachine = "Machine and glass";

std::vector<std::string> ProfileNames() {
  std::vector<std::string> names;
  for (int number = MotionProfile_MIN; number <= MotionProfile_MAX; ++number) {
    names.push_back(ProfileName(static_cast<MotionProfile>(number)));
  }
  return names;
}

std::vector<std::string> OrderNames() {
  std::vector<std::string> names;
  for (int i = 0; i < Ordering::descriptor()->field_count(); ++i) {
    std::string name = Ordering::descriptor()->field(i)->name();
    std::replace(name.begin(), name.end(), '_', '-');
    names.push_back(std::move(name));
  }
  return names;
}

}  // namespace

void AddWhat(command_line::Command command, JobFlags& flags) {
  command.AddOption("JOB|MODEL", flags.what,
                    "job file (.textproto or .json), the name of a supplied job, or "
                    "models: meshes, drawings, images, clouds of points");
}

void AddJobFile(command_line::Command command, JobFlags& flags) {
  command.AddOption("JOB", flags.job_file,
                    "job file (.textproto or .json), or the name of a supplied job");
}

void AddModelFlags(command_line::Command command, JobFlags& flags) {
  command
      .AddOption("--mesh,--model", flags.meshes,
                 "model: a mesh, a drawing, an image or a cloud of points; several "
                 "are merged in one block")
      .Group(kModel);
  const auto height =
      command.AddOption("--height", flags.height_mm, "scale to this height, mm")
          .Group(kModel);
  command.AddOption("--size", flags.size_mm, "scale the largest extent to this, mm")
      .Exclude(height)
      .Group(kModel);
  command
      .AddOption("--unit", flags.unit_mm,
                 "length of a file unit, mm (inches 25.4, m 1000)")
      .Group(kModel);
  command
      .AddOption("--up", flags.up,
                 "axis of the file that points up. Default: y of glTF, drawings, texts "
                 "and images (z lays them flat), what a DAE declares, z of all others "
                 "and with --rotate")
      .OneOf({"z", "y", "x", "-z", "-y", "-x", "declared"})
      .Group(kModel);
  command
      .AddOption("--rotate", flags.rotate_deg,
                 "rotation about x, y, z, degrees, after --up")
      .TakeValues(3)
      .Group(kModel);
}

void AddBlockFlag(command_line::Command command, JobFlags& flags) {
  command.AddOption("--block", flags.block_mm, "block size x y z, mm")
      .TakeValues(3)
      .Group(kBlock);
}

void AddMarginFlag(command_line::Command command, JobFlags& flags) {
  command.AddOption("--margin", flags.margin_mm, "margin without points at each wall, mm")
      .Group(kBlock);
}

void AddBlockFlags(command_line::Command command, JobFlags& flags) {
  AddBlockFlag(command, flags);
  AddMarginFlag(command, flags);
  command
      .AddFlag("--clip", flags.clip, "drop points outside the block instead of failing")
      .Group(kBlock);
  command
      .AddOption(
          "--turn-block", flags.turn_block,
          "turn the block about z with its models in it, degrees, counterclockwise "
          "from above")
      .OneOf({"90", "180", "270"})
      .Group(kBlock);
}

void AddSpacingFlag(command_line::Command command, JobFlags& flags) {
  command
      .AddOption("--spacing", flags.spacing_mm,
                 "required minimum distance of any two points, mm, default 0.1")
      .Group(kPoints);
}

void AddPointFlags(command_line::Command command, JobFlags& flags) {
  AddSpacingFlag(command, flags);
  AddMethodFlags(command, flags.methods);
  command.OptionOf("--method").Group(kPoints);
}

void AddOrderFlags(command_line::Command command, JobFlags& flags) {
  command
      .AddOption(
          "--order", flags.order,
          "of the points, default anneal; of a scan head over a block sweep, of one "
          "that jumps and dwells jump-layers")
      .OneOf(OrderNames())
      .Group(kOrder);
  command
      .AddOption("--order-tries", flags.order_tries,
                 "anneal: changes tried for each point; default as many as are worth it")
      .Group(kOrder);
  command
      .AddOption(
          "--order-pieces", flags.order_pieces,
          "anneal: pieces to be engraved in this order, default 1: for more of them "
          "more changes are worth it")
      .Group(kOrder);
  command.AddOption("--order-time", flags.order_time_s, "anneal: or the time to spend, s")
      .Group(kOrder);
}

void AddMotionFlags(command_line::Command command, JobFlags& flags) {
  command.AddOption("--profile", flags.profile, "motion of the stage, default continuous")
      .OneOf(ProfileNames())
      .Group(kMotion);
  command.AddOption("--rate", flags.rate_hz, "lamp sync rate, Hz; one of the machine's")
      .Group(kMotion);
  command.AddOption("--speed-limit", flags.speed_mm_s, "stage speed limit, mm/s")
      .Group(kMotion);
  command
      .AddOption("--acceleration", flags.acceleration_mm_s2,
                 "stage acceleration limit, mm/s^2")
      .Group(kMotion);
}

void AddLensFlags(command_line::Command command, JobFlags& flags) {
  command
      .AddOption("--machine", flags.machine,
                 "machine profile: els-03 (default), or a file")
      .Group(kMachine);
  command
      .AddOption("--focal", flags.focal_mm,
                 "focal length of the lens, mm; one of the machine's")
      .Group(kMachine);
}

void AddMachineFlags(command_line::Command command, JobFlags& flags) {
  AddLensFlags(command, flags);
  const auto glass = command
                         .AddOption("--glass", flags.glass,
                                    "glass (intaglio materials list), default N-BK7")
                         .Group(kMachine);
  command
      .AddOption("--glass-index", flags.glass_index,
                 "or the refractive index of the glass at the laser's wavelength, as "
                 "--glass n=1.52")
      .Exclude(glass)
      .Group(kMachine);
}

void AddSetFlag(command_line::Command command, JobFlags& flags) {
  command
      .AddOption("--set", flags.fields,
                 "a field of the job by its path, after all other options: "
                 "--set motion.tolerance_um=15; again for each field")
      .TakeOneAtATime();
}

void AddJobFlags(command_line::Command command, JobFlags& flags) {
  AddWhat(command, flags);
  AddJobOptions(command, flags);
}

void AddJobOptions(command_line::Command command, JobFlags& flags) {
  AddModelFlags(command, flags);
  AddTextFlags(command, flags.texts);
  AddBlockFlags(command, flags);
  AddPointFlags(command, flags);
  AddOrderFlags(command, flags);
  AddMotionFlags(command, flags);
  AddMachineFlags(command, flags);
  AddSetFlag(command, flags);
  AddSizeLimitsFlag(command, flags.size_limits);
  command.AddOption("--name", flags.name, "name of the job, for people");
}

}  // namespace intaglio::cli
