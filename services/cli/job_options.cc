#include "services/cli/job_options.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "engrave/core/try.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/job/job_check.h"
#include "services/job/job_defaults.h"
#include "services/job/job_file.h"
#include "services/job/models/model_sources.h"
#include "services/job/models/program_limits.h"
#include "services/job/options.h"
#include "services/platform/command_line/other_programs.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

// A block chosen for the user: this much glass around the object, in whole steps.
constexpr double kChosenMarginMm = 5;
constexpr double kBlockStepMm = 5;
// The size of an object does not depend on its block.
constexpr double kAnyBlockMm = 1000;

void Set(Vector3* to, const std::vector<double>& from) {
  to->set_x(from[0]);
  to->set_y(from[1]);
  to->set_z(from[2]);
}

std::string ProfileNames() {
  std::vector<std::string> names;
  for (int number = MotionProfile_MIN; number <= MotionProfile_MAX; ++number) {
    names.push_back(ProfileName(static_cast<MotionProfile>(number)));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

/// The field of a name on the command line: - for _.
const google::protobuf::FieldDescriptor* OrderField(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  const auto* field = Ordering::descriptor()->FindFieldByName(name);
  return field != nullptr && field->real_containing_oneof() != nullptr ? field : nullptr;
}

std::string OrderNames() {
  std::vector<std::string> names;
  for (int i = 0; i < Ordering::descriptor()->field_count(); ++i) {
    std::string name = Ordering::descriptor()->field(i)->name();
    std::replace(name.begin(), name.end(), '_', '-');
    names.push_back(std::move(name));
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

Status SetOrder(const JobFlags& flags, Ordering& ordering) {
  if (flags.order) {
    const auto* field = OrderField(*flags.order);
    if (field == nullptr) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("--order '{}': unknown order; known are {}", *flags.order,
                              OrderNames()),
                  *flags.order);
    }
    ordering.GetReflection()->MutableMessage(&ordering, field);
  }
  if (!flags.order_tries && !flags.order_time_s) return {};
  if (ordering.method_case() != Ordering::METHOD_NOT_SET && !ordering.has_anneal()) {
    return Fail(ErrorCode::kInvalidValue,
                "--order-tries and --order-time apply only to --order anneal", "");
  }
  AnnealOrder& anneal = *ordering.mutable_anneal();
  if (flags.order_tries) anneal.set_tries_per_point(*flags.order_tries);
  if (flags.order_time_s) anneal.set_time_s(*flags.order_time_s);
  return {};
}

Status SetOrderAndProfile(const JobFlags& flags, JobSpec& job) {
  INTAGLIO_TRY(SetOrder(flags, *job.mutable_ordering()));
  if (!flags.profile) return {};
  MotionProfile profile;
  std::string name = "MOTION_PROFILE_" + *flags.profile;
  for (char& c : name) {
    c = c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  if (!MotionProfile_Parse(name, &profile)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("--profile '{}': unknown profile; known are {}",
                            *flags.profile, ProfileNames()),
                *flags.profile);
  }
  job.mutable_motion()->set_profile(profile);
  return {};
}

void SetModels(const JobFlags& flags, JobSpec& job) {
  if (!flags.meshes.empty()) job.clear_models();
  for (const std::string& mesh : flags.meshes) {
    job.add_models()->set_file(fs::absolute(mesh).lexically_normal().string());
  }
  for (Model& model : *job.mutable_models()) {
    Placement& placement = *model.mutable_placement();
    if (flags.height_mm) placement.set_fit_height_mm(*flags.height_mm);
    if (flags.size_mm) placement.set_fit_size_mm(*flags.size_mm);
    if (flags.unit_mm) placement.set_unit_mm(*flags.unit_mm);
    if (!flags.rotate_deg.empty()) Set(placement.mutable_rotate_deg(), flags.rotate_deg);
  }
}

Status Apply(const JobFlags& flags, JobSpec& job) {
  SetModels(flags, job);
  if (!flags.block_mm.empty())
    Set(job.mutable_block()->mutable_size_mm(), flags.block_mm);
  if (flags.margin_mm) job.mutable_block()->set_margin_mm(*flags.margin_mm);
  if (flags.clip) job.mutable_block()->set_clip(true);
  if (flags.glass) job.set_glass(*flags.glass);
  if (flags.name) job.set_name(*flags.name);
  if (flags.rate_hz) job.mutable_laser()->set_rate_hz(*flags.rate_hz);
  if (flags.speed_mm_s) job.mutable_motion()->set_max_speed_mm_s(*flags.speed_mm_s);
  if (flags.acceleration_mm_s2) {
    job.mutable_motion()->set_max_acceleration_mm_s2(*flags.acceleration_mm_s2);
  }
  if (flags.focal_mm) job.mutable_lens()->set_focal_length_mm(*flags.focal_mm);
  if (flags.spacing_mm) {
    job.mutable_discretization()->set_min_spacing_mm(*flags.spacing_mm);
  }
  INTAGLIO_TRY(SetMethods(flags.methods, job));
  return SetOrderAndProfile(flags, job);
}

/// The block that an object of this size gets: with a margin, in whole steps.
std::vector<double> BlockFor(const Vec3& size_mm) {
  const auto side = [](double extent) {
    return std::max(
        2 * kChosenMarginMm,
        std::ceil((extent + 2 * kChosenMarginMm) / kBlockStepMm) * kBlockStepMm);
  };
  return {side(size_mm.x()), side(size_mm.y()), side(size_mm.z())};
}

// Without a block the objects decide: their joint size and a margin, in whole steps.
Result<std::string> ChooseBlock(JobSpec& job, const MachineSpec& machine,
                                const ReadLimits& limits) {
  JobSpec complete = job;
  Set(complete.mutable_block()->mutable_size_mm(),
      {kAnyBlockMm, kAnyBlockMm, kAnyBlockMm});
  complete = WithDefaults(std::move(complete), machine);
  for (const Model& model : complete.models()) {
    if (!model.placement().has_fit_block()) continue;
    return Fail(
        ErrorCode::kMissing,
        model.file() + " has to fill the block: give the size of the block with --block");
  }
  const auto measured = INTAGLIO_TRY(SizeOf(complete, limits));
  const Vec3& size = measured;
  const std::vector<double> block = BlockFor(size);
  Set(job.mutable_block()->mutable_size_mm(), block);
  return fmt::format(
      "block {:g} x {:g} x {:g} mm, chosen to fit the object ({:.1f} x {:.1f} x {:.1f} "
      "mm); use --block X Y Z for another size",
      block[0], block[1], block[2], size.x(), size.y(), size.z());
}

// Points define where they are in the block as well as their extent.
std::vector<double> BlockAround(const PointList& points_mm) {
  Box3 box;
  for (const Vec3& p : points_mm) box.Extend(p);
  if (box.empty()) return BlockFor(Vec3::Zero());
  const Vec3 to_far_side_mm = box.max_mm - Vec3::Constant(kChosenMarginMm);
  return BlockFor(box.size_mm().cwiseMax(to_far_side_mm));
}

Result<JobSpec> ReadJob(const JobFlags& flags, bool needs_model) {
  if (!flags.job_file.empty()) return ReadJobFile(flags.job_file);
  if (!flags.meshes.empty() || !needs_model) return JobSpec();
  return Fail(ErrorCode::kMissing,
              "nothing to engrave: name a job file, or a model with --mesh");
}

Status SetBlock(JobAndMachine& built, const PointList* points_mm,
                const ReadLimits& limits) {
  if (points_mm != nullptr && built.job.models().empty()) {
    Set(built.job.mutable_block()->mutable_size_mm(), BlockAround(*points_mm));
    return {};
  }
  auto note = INTAGLIO_TRY(ChooseBlock(built.job, built.machine, limits));
  built.notes.push_back(std::move(note));
  return {};
}

/// points_mm: of a job whose points are there already, or null.
Result<JobAndMachine> Build(const JobFlags& flags, JobSpec read,
                            const PointList* points_mm) {
  JobAndMachine built;
  JobSpec& job = built.job = std::move(read);
  INTAGLIO_TRY(Apply(flags, job));
  if (job.glass().empty() && flags.job_file.empty()) job.set_glass("N-BK7");
  if (flags.machine || job.machine_file().empty()) {
    auto file = INTAGLIO_TRY(FindMachineFile(flags.machine.value_or("els-03")));
    job.set_machine_file(file.string());
  }
  auto machine = INTAGLIO_TRY(ReadMachineFile(job.machine_file()));
  built.machine = std::move(machine);
  if (flags.job_file.empty() && !job.discretization().has_min_spacing_mm()) {
    job.mutable_discretization()->set_min_spacing_mm(0.1);
  }
  if (!job.block().has_size_mm() && flags.job_file.empty()) {
    if (auto set =
            SetBlock(built, points_mm, mesh_reader::LimitsOfProgram(flags.size_limits));
        !set)
      return tl::unexpected(set.error());
  }
  job = WithDefaults(job, built.machine);
  auto errors = CheckAll(job, built.machine);
  if (points_mm != nullptr) {
    // What points were made from is not read.
    std::erase_if(errors, [](const Finding& found) { return Concerns(found, "models"); });
  }
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  return built;
}

}  // namespace

void AddJobFlags(command_line::Command command, JobFlags& flags) {
  command.AddOption("JOB", flags.job_file, "job file (.textproto or .json)");
  command.AddOption("--mesh,--model", flags.meshes,
                    "model: a mesh, a drawing, an image or a cloud of points; several "
                    "are merged in one block");
  command.AddOption("--height", flags.height_mm, "scale to this height, mm");
  command.AddOption("--size", flags.size_mm, "scale the largest extent to this, mm")
      .Exclude(command.OptionOf("--height"));
  command.AddOption("--unit", flags.unit_mm,
                    "length of a file unit, mm (inches 25.4, m 1000)");
  command.AddOption("--rotate", flags.rotate_deg, "rotation about x, y, z, degrees")
      .TakeValues(3);
  command.AddOption("--block", flags.block_mm, "block size x y z, mm").TakeValues(3);
  command.AddOption("--margin", flags.margin_mm,
                    "margin without points at each wall, mm");
  command.AddFlag("--clip", flags.clip,
                  "drop points outside the block instead of failing");
  command.AddOption("--glass", flags.glass,
                    "glass (intaglio materials list), default N-BK7");
  AddMethodFlags(command, flags.methods);
  command.AddOption("--spacing", flags.spacing_mm,
                    "minimum distance of any two points, mm");
  command.AddOption("--order", flags.order,
                    "anneal (default), smooth, kdz, layers, boustrophedon or "
                    "published-kdz");
  command.AddOption(
      "--order-tries", flags.order_tries,
      "anneal: changes tried for each point; more changes give a better order");
  command.AddOption("--order-time", flags.order_time_s,
                    "anneal: or the time to spend, s");
  command.AddOption("--profile", flags.profile,
                    "motion of the stage, default continuous: " + ProfileNames());
  command.AddOption("--machine", flags.machine,
                    "machine profile: els-03 (default), or a file");
  command.AddOption("--rate", flags.rate_hz, "lamp sync rate, Hz; one of the machine's");
  command.AddOption("--speed-limit", flags.speed_mm_s, "stage speed limit, mm/s");
  command.AddOption("--acceleration", flags.acceleration_mm_s2,
                    "stage acceleration limit, mm/s^2");
  command.AddOption("--focal", flags.focal_mm,
                    "focal length of the lens, mm; one of the machine's");
  AddSizeLimitsFlag(command, flags.size_limits);
  command.AddOption("--name", flags.name, "name of the job, for people");
}

fs::path SuppliedFolder() {
  const fs::path installed =
      command_line::ProgramFolder().parent_path() / "share" / "intaglio";
  return fs::exists(installed / "machines") ? installed : fs::path(INTAGLIO_DEPLOY_DIR);
}

Result<fs::path> FindMachineFile(const std::string& name_or_file) {
  if (fs::exists(name_or_file)) return fs::absolute(name_or_file).lexically_normal();
  const fs::path folder = SuppliedFolder() / "machines";
  const fs::path supplied = folder / (name_or_file + ".textproto");
  if (fs::exists(supplied)) return supplied;
  std::string known;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    known += (known.empty() ? "" : ", ") + entry.path().stem().string();
  }
  return Fail(
      ErrorCode::kNotFound,
      fmt::format(
          "--machine '{}': neither a file nor a supplied profile; supplied profiles: {}",
          name_or_file, known.empty() ? "none" : known),
      name_or_file);
}

Result<JobAndMachine> BuildJob(const JobFlags& flags) {
  auto read = INTAGLIO_TRY(ReadJob(flags, true));
  return Build(flags, std::move(read), nullptr);
}

Result<JobAndMachine> CompleteJob(const JobFlags& flags, JobSpec job) {
  return Build(flags, std::move(job), nullptr);
}

Result<JobSpec> ReadPattern(const JobFlags& flags) {
  if (flags.name) {
    return Fail(ErrorCode::kInvalidValue,
                "--name would be the same for every piece: put a name with a column into "
                "the job file",
                *flags.name);
  }
  return ReadJob(flags, true);
}

Result<JobAndMachine> BuildJobOfPoints(const JobFlags& flags,
                                       const PointList& points_mm) {
  auto read = INTAGLIO_TRY(ReadJob(flags, false));
  return Build(flags, std::move(read), &points_mm);
}

}  // namespace intaglio::cli
