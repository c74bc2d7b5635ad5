#include "services/cli/job/job_options.h"

#include <fmt/format.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cctype>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "materials_db/index_glass.h"
#include "services/cli/job/job_limits.h"
#include "services/job/beams/laser_wavelength.h"
#include "services/job/checks/course_check.h"
#include "services/job/checks/job_check.h"
#include "services/job/checks/mark_job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/convert/model_kind.h"
#include "services/job/fields/field_path.h"
#include "services/job/fields/job_kind.h"
#include "services/job/files/job_file.h"
#include "services/job/models/arrangement.h"
#include "services/job/models/chosen_block.h"
#include "services/job/models/text_model.h"
#include "services/job/models/unfitted_sizes.h"
#include "services/platform/command_line/supplied_files.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

void Set(Vector3* to, const std::vector<double>& from) {
  to->set_x(from[0]);
  to->set_y(from[1]);
  to->set_z(from[2]);
}

/// The field of a name on the command line: - for _.
const google::protobuf::FieldDescriptor* OrderField(std::string name) {
  std::replace(name.begin(), name.end(), '-', '_');
  return FindChoice(*Ordering::descriptor(), name);
}

Status SetOrder(const JobFlags& flags, Ordering& ordering) {
  if (flags.order) {
    const auto* field = OrderField(*flags.order);
    Require(field != nullptr, "--order '{}' has passed its check", *flags.order);
    ordering.GetReflection()->MutableMessage(&ordering, field);
  }
  if (!flags.order_tries && !flags.order_time_s && !flags.order_pieces) return {};
  if (ordering.method_case() != Ordering::METHOD_NOT_SET && !ordering.has_anneal()) {
    return Fail(ErrorCode::kInvalidValue,
                "--order-tries, -pieces and -time apply only to --order anneal", "");
  }
  AnnealOrder& anneal = *ordering.mutable_anneal();
  if (flags.order_tries) anneal.set_tries_per_point(*flags.order_tries);
  if (flags.order_pieces) anneal.set_pieces(*flags.order_pieces);
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
  Require(MotionProfile_Parse(name, &profile), "--profile '{}' has passed its check",
          *flags.profile);
  job.mutable_motion()->set_profile(profile);
  return {};
}

/// -y is UP_AXIS_MINUS_Y.
UpAxis UpOf(const std::string& name) {
  std::string value = "UP_AXIS_";
  for (const char c : name) {
    const char upper = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    value += c == '-' ? "MINUS_" : std::string(1, upper);
  }
  UpAxis up = UP_AXIS_DEFAULT;
  UpAxis_Parse(value, &up);
  return up;
}

void SetMeshes(const JobFlags& flags, JobSpec& job) {
  if (!flags.meshes.empty()) job.clear_models();
  for (const std::string& mesh : flags.meshes) {
    job.add_models()->set_file(fs::absolute(mesh).lexically_normal().string());
  }
}

/// Places the models; the texts only where there is nothing else.
void SetPlacements(const JobFlags& flags, JobSpec& job) {
  const bool texts_alone = std::all_of(job.models().begin(), job.models().end(), IsText);
  for (Model& model : *job.mutable_models()) {
    if (IsText(model) && !texts_alone) continue;
    Placement& placement = *model.mutable_placement();
    if (flags.height_mm) placement.set_fit_height_mm(*flags.height_mm);
    if (flags.size_mm) placement.set_fit_size_mm(*flags.size_mm);
    if (flags.unit_mm) placement.set_unit_mm(*flags.unit_mm);
    if (flags.up) placement.set_up(UpOf(*flags.up));
    if (!flags.rotate_deg.empty()) Set(placement.mutable_rotate_deg(), flags.rotate_deg);
  }
}

/// By 90, 180 or 270 degrees: width and depth of the blocks are exchanged, or not.
void TurnBlock(int angle_deg, JobSpec& job) {
  const std::uint32_t turns = static_cast<std::uint32_t>(angle_deg / 90);
  Block& block = *job.mutable_block();
  block.set_quarter_turns((block.quarter_turns() + turns) % 4);
  if (turns % 2 == 0) return;
  const auto exchange = [](Vector3& size) {
    const double x = size.x();
    size.set_x(size.y());
    size.set_y(x);
  };
  if (block.has_size_mm()) exchange(*block.mutable_size_mm());
  for (ChannelBlock& own : *job.mutable_channel_blocks())
    exchange(*own.mutable_size_mm());
}

/// "PATH=VALUE" each.
Status SetFields(const std::vector<std::string>& fields, JobSpec& job) {
  for (const std::string& field : fields) {
    const std::size_t equals = field.find('=');
    if (equals == std::string::npos) {
      return Fail(
          ErrorCode::kInvalidValue,
          fmt::format("--set: \"{}\" has no =; write it as block.margin_mm=5", field),
          field);
    }
    if (auto set = SetField(job, field.substr(0, equals), field.substr(equals + 1));
        !set) {
      return Fail(set.error().code, "--set: " + set.error().message, set.error().value);
    }
  }
  return {};
}

Status Apply(const JobFlags& flags, JobSpec& job) {
  SetMeshes(flags, job);
  INTAGLIO_TRY(SetTexts(flags.texts, job));
  SetPlacements(flags, job);
  if (!flags.block_mm.empty())
    Set(job.mutable_block()->mutable_size_mm(), flags.block_mm);
  if (flags.margin_mm) job.mutable_block()->set_margin_mm(*flags.margin_mm);
  if (flags.clip) job.mutable_block()->set_clip(true);
  if (flags.turn_block) TurnBlock(std::stoi(*flags.turn_block), job);
  if (flags.glass) job.set_glass(*flags.glass);
  if (flags.glass_index)
    job.set_glass(materials_db::NameOfIndexGlass(*flags.glass_index));
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
  INTAGLIO_TRY(SetOrderAndProfile(flags, job));
  return SetFields(flags.fields, job);
}

/// Other words name models.
bool NamesJobFile(const std::string& word) {
  const fs::path extension = fs::path(word).extension();
  return extension == ".textproto" || extension == ".txtpb" || extension == ".json" ||
         extension.empty();  // a supplied one
}

/// `what` as job_file or meshes. kInvalidValue: a job file beside models.
Result<JobFlags> SortOut(JobFlags flags) {
  const std::vector<std::string> what = std::exchange(flags.what, {});
  if (what.size() == 1 && NamesJobFile(what.front())) {
    flags.job_file = what.front();
    return flags;
  }
  for (const std::string& word : what) {
    if (NamesJobFile(word)) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("'{}': give one job file, or models, not both", word),
                  word);
    }
  }
  flags.meshes.insert(flags.meshes.begin(), what.begin(), what.end());
  return flags;
}

Result<JobSpec> ReadJob(const JobFlags& flags, bool needs_model) {
  if (!flags.job_file.empty()) {
    return ReadJobFile(INTAGLIO_TRY(
        command_line::FindSupplied(flags.job_file, command_line::kSuppliedJobs)));
  }
  const bool has_model = !flags.meshes.empty() || flags.texts.text || flags.texts.code;
  if (has_model || !needs_model) return JobSpec();
  return Fail(ErrorCode::kMissing,
              "nothing to engrave: name a job file, a model, a text with --text, or a "
              "code with --code");
}

Status SetBlock(JobAndMachine& built, const PointList* points_mm,
                const ReadLimits& limits) {
  if (points_mm != nullptr && built.job.models().empty()) {
    *built.job.mutable_block()->mutable_size_mm() = BlockAround(*points_mm);
    return {};
  }
  return ChooseBlock(built.job, built.machine, limits, built.notes);
}

/// By --machine, else by the job, which may name a supplied profile.
Status SetMachineFile(const JobFlags& flags, JobSpec& job) {
  const bool by_flag = flags.machine || job.machine_file().empty();
  const auto file =
      FindMachineFile(by_flag ? flags.machine.value_or("els-03") : job.machine_file());
  if (!file) {
    return Fail(file.error().code,
                (by_flag ? "--machine: " : "machine_file: ") + file.error().message,
                file.error().value);
  }
  job.set_machine_file(file->string());
  return {};
}

/// All that is wrong; the texts are set only in a block that is right.
std::vector<Finding> CheckWithTexts(JobAndMachine& built,
                                    const std::vector<Finding>& of_fonts) {
  std::vector<Finding> errors = CheckAll(built.job, built.machine);
  errors.insert(errors.end(), of_fonts.begin(), of_fonts.end());
  const bool can_be_set =
      std::none_of(errors.begin(), errors.end(), [](const Finding& found) {
        return Concerns(found, "models") || Concerns(found, "block") ||
               Concerns(found, "channel_blocks") || Concerns(found, "laser");
      });
  if (!can_be_set) return errors;
  for (Finding& found : CheckTexts(built.job, built.warnings)) {
    errors.push_back(std::move(found));
  }
  return errors;
}

/// Before they are measured.
Status CheckModelsAlone(const JobSpec& job, const std::vector<Finding>& of_fonts) {
  std::vector<Finding> errors = CheckJob(job);
  std::erase_if(errors, [](const Finding& found) { return !Concerns(found, "models"); });
  errors.insert(errors.end(), of_fonts.begin(), of_fonts.end());
  if (errors.empty()) return {};
  return tl::unexpected(JoinErrors(errors));
}

/// What points were made from is not read.
std::vector<Finding> CheckWithoutModels(const JobAndMachine& built) {
  std::vector<Finding> errors = CheckAll(built.job, built.machine);
  std::erase_if(errors, [](const Finding& found) {
    return Concerns(found, "models") || Concerns(found, "name");
  });
  return errors;
}

/// points_mm: of a job whose points are there already, or null.
Result<JobAndMachine> Build(const JobFlags& flags, JobSpec read,
                            const PointList* points_mm) {
  if (const auto refused = RefuseCourse(read); !refused.empty())
    return tl::unexpected(JoinErrors(refused));
  if (read.has_marks()) {
    return Fail(ErrorCode::kUnsupported,
                "marks: are of a surface, and this makes points in a block: see them by "
                "intaglio marks preview JOB, or submit the job to a machine that marks",
                read.name());
  }
  JobAndMachine built;
  JobSpec& job = built.job = std::move(read);
  INTAGLIO_TRY(Apply(flags, job));
  if (job.glass().empty() && flags.job_file.empty()) job.set_glass("N-BK7");
  INTAGLIO_TRY(SetMachineFile(flags, job));
  built.machine = INTAGLIO_TRY(ReadMachineFile(job.machine_file()));
  INTAGLIO_TRY(CheckMakesPoints(built.machine));
  if (flags.job_file.empty() && !job.discretization().has_min_spacing_mm()) {
    job.mutable_discretization()->set_min_spacing_mm(0.1);
  }
  const std::vector<Finding> of_fonts = ResolveFonts(job);
  const ReadLimits limits = LimitsOf(flags);
  const bool is_typed = flags.job_file.empty() && IsFreeToArrange(job);
  if (points_mm == nullptr && (flags.texts.place || is_typed)) {
    INTAGLIO_TRY(CheckModelsAlone(job, of_fonts));
    INTAGLIO_TRY(
        Arrange(flags.texts.place, built.machine, limits, job, built.of_arrangement));
    for (const Warning& warning : built.of_arrangement)
      built.notes.push_back("warning: " + warning.text);
  }
  if (!job.block().has_size_mm() && flags.job_file.empty()) {
    if (points_mm == nullptr) INTAGLIO_TRY(CheckModelsAlone(job, of_fonts));
    INTAGLIO_TRY(SetBlock(built, points_mm, limits));
  }
  built.machine = ForWavelengthOf(job.laser(), std::move(built.machine));
  job = WithDefaults(job, built.machine);
  const auto errors =
      points_mm == nullptr ? CheckWithTexts(built, of_fonts) : CheckWithoutModels(built);
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  return built;
}

}  // namespace

Result<fs::path> FindMachineFile(const std::string& name_or_file) {
  return command_line::FindSupplied(name_or_file, command_line::kSuppliedProfiles);
}

Result<JobAndMachine> BuildJob(const JobFlags& given) {
  const JobFlags flags = INTAGLIO_TRY(SortOut(given));
  auto read = INTAGLIO_TRY(ReadJob(flags, true));
  return Build(flags, std::move(read), nullptr);
}

namespace {

/// Fills in nothing of a job of marks: the job service does it.
Result<JobAndMachine> BuildMarkJob(const JobFlags& flags, JobSpec read) {
  if (flags.name) read.set_name(*flags.name);
  INTAGLIO_TRY(SetFields(flags.fields, read));
  JobAndMachine built;
  built.job = std::move(read);
  INTAGLIO_TRY(SetMachineFile(flags, built.job));
  built.machine = INTAGLIO_TRY(ReadMachineFile(built.job.machine_file()));
  const auto errors = CheckAll(built.job, built.machine);
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  built.job = WithMarkDefaults(std::move(built.job));
  return built;
}

}  // namespace

Result<JobAndMachine> BuildJobOfAnyKind(const JobFlags& given) {
  const JobFlags flags = INTAGLIO_TRY(SortOut(given));
  if (const auto read = ReadJob(flags, true); read && MakesMarks(*read))
    return BuildMarkJob(flags, *read);
  return BuildJob(flags);
}

Result<JobAndMachine> BuildJobToEngrave(const JobFlags& flags) {
  auto built = INTAGLIO_TRY(BuildJobOfAnyKind(flags));
  if (MakesMarks(built.job)) return built;
  INTAGLIO_TRY(CheckUnfittedSizes(built.job, LimitsOf(flags)));
  return built;
}

Result<JobAndMachine> CompleteJob(const JobFlags& flags, JobSpec job) {
  if (MakesMarks(job)) return BuildMarkJob(flags, std::move(job));
  return Build(flags, std::move(job), nullptr);
}

Result<std::optional<JobSpec>> FindCourseJob(const JobFlags& given) {
  const JobFlags flags = INTAGLIO_TRY(SortOut(given));
  const auto read = ReadJob(flags, true);
  if (!read || !read->has_course()) return std::optional<JobSpec>();
  // No option at all leaves empty messages behind, too. A model, so that it would change.
  JobSpec changed, unchanged;
  changed.add_models(), unchanged.add_models();
  INTAGLIO_TRY(Apply(JobFlags(), unchanged));
  const Status applied = Apply(flags, changed);
  if (applied && !flags.machine &&
      changed.SerializeAsString() == unchanged.SerializeAsString()) {
    return std::optional<JobSpec>(*read);
  }
  return Fail(
      ErrorCode::kInvalidValue,
      flags.job_file +
          ": has a course, which options of a machine, of models and of points do "
          "not change; write them into its field course, or leave them out",
      flags.job_file);
}

Result<JobSpec> ReadPattern(const JobFlags& given) {
  const JobFlags flags = INTAGLIO_TRY(SortOut(given));
  if (flags.name) {
    return Fail(ErrorCode::kInvalidValue,
                "--name would be the same for every piece: put a name with a column into "
                "the job file",
                *flags.name);
  }
  return ReadJob(flags, true);
}

Result<JobAndMachine> BuildJobOfPoints(const JobFlags& given,
                                       const PointList& points_mm) {
  const JobFlags flags = INTAGLIO_TRY(SortOut(given));
  auto read = INTAGLIO_TRY(ReadJob(flags, false));
  return Build(flags, std::move(read), &points_mm);
}

}  // namespace intaglio::cli
