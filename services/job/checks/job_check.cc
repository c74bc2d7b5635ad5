#include "services/job/checks/job_check.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <google/protobuf/descriptor.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <set>

#include "engrave/core/check.h"
#include "engrave/drawing/font_list.h"
#include "services/job/beams/laser_wavelength.h"
#include "services/job/checks/block_place_check.h"
#include "services/job/checks/course_check.h"
#include "services/job/checks/laser_check.h"
#include "services/job/checks/layers_check.h"
#include "services/job/checks/lens_check.h"
#include "services/job/checks/mark_job_check.h"
#include "services/job/checks/marks_check.h"
#include "services/job/checks/model_check.h"
#include "services/job/checks/reach_check.h"
#include "services/job/checks/taught_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/convert/mark_defaults.h"
#include "services/job/convert/model_kind.h"
#include "services/job/convert/placeholders.h"
#include "services/job/fields/field_ranges.h"
#include "services/job/fields/findings.h"
#include "services/job/fields/job_kind.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/stations.h"
#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;

void CheckFile(const std::string& file, const std::string& path, Findings& findings) {
  if (file.empty()) return findings.Missing(path, "name a file");
  std::error_code error;
  const auto status = fs::status(file, error);
  if (!fs::exists(status)) {
    const auto names = PlaceholdersOf(file);
    if (!names.empty())
      return findings.Wrong(path, file, "{}", UnfilledText(names.front()));
    if (path.find(".text.") == std::string::npos || drawing::IsFontFile(file)) {
      return findings.Wrong(path, file, "does not exist");
    }
    const auto font = drawing::FindFontFile(file);
    return findings.Wrong(path, file, "{}",
                          font ? "is a family: name its file, " + *font
                               : "is no font: " + font.error().message);
  }
  if (!fs::is_regular_file(status)) findings.Wrong(path, file, "is not a file");
}

void CheckModels(const JobSpec& job, Findings& findings) {
  if (job.models().empty()) findings.Missing("models", "give at least one model file");
  JobSpec copy = job;
  ForEachFile(copy, [&](const std::string& file, const std::string& path) {
    CheckFile(file, path, findings);
  });
  for (int i = 0; i < job.models_size(); ++i) {
    CheckModel(job.models(i), fmt::format("models[{}]", i), findings);
  }
}

// Whether the models can fit between the margins at all.
void CheckRoom(const JobSpec& job, Findings& findings) {
  const Vector3& size = job.block().size_mm();
  const double margin_mm = job.block().margin_mm();
  const double min_mm = std::min({size.x(), size.y(), size.z()});
  if (2 * margin_mm >= min_mm) {
    return findings.Wrong(
        "block.margin_mm", margin_mm,
        "leaves no space in a block of {} x {} x {} mm; it has to be below {}", size.x(),
        size.y(), size.z(), min_mm / 2);
  }
  if (job.block().clip()) return;
  const double height_mm = size.z() - 2 * margin_mm;
  const double largest_mm = std::max({size.x(), size.y(), size.z()}) - 2 * margin_mm;
  for (int i = 0; i < job.models_size(); ++i) {
    const Placement& placement = job.models(i).placement();
    const std::string path = fmt::format("models[{}].placement.", i);
    if (placement.fit_height_mm() > height_mm) {
      findings.Wrong(path + "fit_height_mm", placement.fit_height_mm(),
                     "is more than the {} mm between the margins of the block",
                     height_mm);
    }
    if (placement.fit_size_mm() > largest_mm) {
      findings.Wrong(path + "fit_size_mm", placement.fit_size_mm(),
                     "is more than the {} mm between the margins of the block",
                     largest_mm);
    }
  }
}

void CheckOrdering(const Ordering& ordering, Findings& findings) {
  const PublishedKdzOrder& published = ordering.published_kdz();
  if (!published.has_angle_deg()) return;
  if (published.has_up_ratio() || published.has_down_ratio()) {
    findings.Wrong("ordering.published_kdz.angle_deg", published.angle_deg(),
                   "excludes up_ratio and down_ratio, which follow from it; remove them");
  }
}

void CheckMethods(const JobSpec& job, Findings& findings) {
  for (int i = 0; i < job.models_size(); ++i) {
    const Method* method = MethodOf(job.models(i));
    if (method == nullptr || method->faults == nullptr) continue;
    for (const MethodFault& fault : method->faults(job, job.models(i))) {
      findings.Wrong(fmt::format("models[{}].{}.{}", i, method->name(), fault.field),
                     fault.value, "{}", fault.what);
    }
  }
}

/// Each of `channels` once, and one that the laser opens.
template <typename Channels>
void CheckAmongLasers(const Channels& channels, const LaserOptions& laser,
                      const std::function<std::string(int)>& path_of,
                      Findings& findings) {
  std::set<std::uint32_t> seen;
  int i = 0;
  for (const std::uint32_t channel : channels) {
    const std::string path = path_of(i++);
    const auto& open = laser.channels();
    if (std::find(open.begin(), open.end(), channel) == open.end()) {
      findings.Wrong(path, channel,
                     "is not among laser.channels, {}; add it there or remove it here",
                     fmt::join(open, " "));
    } else if (!seen.insert(channel).second) {
      findings.Wrong(path, channel, "occurs twice");
    }
  }
}

void CheckChannelBlock(const ChannelBlock& own, const Block& block,
                       const std::string& path, Findings& findings) {
  if (!own.has_size_mm()) {
    return findings.Missing(path + ".size_mm",
                            "give the block's size, 1..1000 mm in each axis");
  }
  const Vector3& size = own.size_mm();
  const Vector3& largest = block.size_mm();
  const auto check_side = [&](const char* axis, double size_mm, double max_mm) {
    if (size_mm > max_mm) {
      findings.Wrong(path + ".size_mm." + axis, size_mm,
                     "is more than that of the block, {}; give the size of the largest "
                     "block as block.size_mm",
                     max_mm);
    } else if (size_mm <= 2 * block.margin_mm()) {
      findings.Wrong(path + ".size_mm." + axis, size_mm,
                     "leaves no space between the margins; reduce block.margin_mm, {}",
                     block.margin_mm());
    }
  };
  check_side("x", size.x(), largest.x());
  check_side("y", size.y(), largest.y());
  if (size.z() != largest.z()) {
    findings.Wrong(path + ".size_mm.z", size.z(),
                   "is not the height of the block, {}; all channels have the same "
                   "focus: use blocks of one height",
                   largest.z());
  }
}

void CheckChannels(const JobSpec& job, Findings& findings) {
  for (int i = 0; i < job.models_size(); ++i) {
    CheckAmongLasers(
        job.models(i).channels(), job.laser(),
        [i](int at) { return fmt::format("models[{}].channels[{}]", i, at); }, findings);
  }
  const auto path_of = [](int i) { return fmt::format("channel_blocks[{}]", i); };
  std::vector<std::uint32_t> with_block;
  for (const ChannelBlock& own : job.channel_blocks()) {
    CheckChannelBlock(own, job.block(), path_of(static_cast<int>(with_block.size())),
                      findings);
    with_block.push_back(own.channel());
  }
  CheckAmongLasers(
      with_block, job.laser(), [&](int at) { return path_of(at) + ".channel"; },
      findings);
}

/// Half of the crack's length above or below its place, a crack would no longer be there.
void CheckDepthTolerance(const JobSpec& job, const MachineSpec& machine,
                         Findings& findings) {
  const MachineLens* lens = FindLens(machine, job.lens().focal_length_mm());
  if (lens == nullptr || lens->crack_length_mm() <= 0) return;
  const double max_um = 1e3 * lens->crack_length_mm() / 2;
  if (job.motion().depth_tolerance_um() <= max_um) return;
  findings.Wrong("motion.depth_tolerance_um", job.motion().depth_tolerance_um(),
                 "is above half of the length of a crack of the lens {}, {:g}",
                 lens->name(), max_um);
}

void CheckMotion(const MotionOptions& motion, double min_spacing_mm,
                 const MachineSpec& machine, Findings& findings) {
  // Numbers pass the readers of files.
  if (!MotionProfile_IsValid(motion.profile())) {
    findings.Wrong("motion.profile", static_cast<int>(motion.profile()),
                   "is not a profile, 0..{}", static_cast<int>(MotionProfile_MAX));
  }
  const MotionOptions largest = WithDefaults(JobSpec(), machine).motion();
  if (motion.max_speed_mm_s() > largest.max_speed_mm_s()) {
    findings.Wrong("motion.max_speed_mm_s", motion.max_speed_mm_s(),
                   "is above the speed of {}, {}", machine.name(),
                   largest.max_speed_mm_s());
  }
  if (motion.max_acceleration_mm_s2() > largest.max_acceleration_mm_s2()) {
    findings.Wrong("motion.max_acceleration_mm_s2", motion.max_acceleration_mm_s2(),
                   "is above the acceleration of {}, {}", machine.name(),
                   largest.max_acceleration_mm_s2());
  }
  if (motion.has_parabola_height_mm() && motion.profile() != MOTION_PROFILE_PARABOLA) {
    findings.Wrong("motion.parabola_height_mm", motion.parabola_height_mm(),
                   "is of the profile MOTION_PROFILE_PARABOLA alone; remove it");
  }
  if (motion.has_lq() && motion.profile() != MOTION_PROFILE_LQ) {
    findings.Wrong("motion.lq", motion.lq().moving_mass_kg(),
                   "kg and the other fields are of the profile MOTION_PROFILE_LQ alone; "
                   "remove them");
  }
  // Further off, a crack could no longer be distinguished from its neighbours'.
  const double max_um = 1000 * min_spacing_mm / 4;
  if (motion.tolerance_um() > max_um) {
    findings.Wrong("motion.tolerance_um", motion.tolerance_um(),
                   "is above a quarter of the minimum spacing, {:g}", max_um);
  }
}

}  // namespace

std::vector<Finding> CheckJob(const JobSpec& job) {
  if (job.has_marks()) return CheckMarks(job);
  if (job.has_course()) return RefuseCourse(job);
  Findings findings;
  CheckRanges(job, "", findings.found());
  CheckModels(job, findings);
  CheckPlaceholders(job, findings);
  if (!job.block().has_size_mm()) {
    findings.Missing("block.size_mm", "give the block's size, 1..1000 mm in each axis");
  }
  if (job.glass().empty()) {
    findings.Missing("glass",
                     "name a glass of the material base (intaglio materials list)");
  }
  if (!job.discretization().has_min_spacing_mm()) {
    findings.Missing("discretization.min_spacing_mm",
                     "give the minimum distance of any two points, 0.02..10 mm (0.09 "
                     "with f = 43 mm, 0.13 with f = 70 mm)");
  }
  if (job.machine_file().empty()) {
    findings.Missing("machine_file", "name a machine profile (see deploy/machines)");
  }
  return std::move(findings.found());
}

std::vector<Finding> CheckJobOnMachine(const JobSpec& job, const MachineSpec& given,
                                       std::optional<double> stage_per_glass_ratio) {
  if (job.has_marks()) return CheckMarksOnMachine(job, given);
  const MachineSpec machine = ForWavelengthOf(job.laser(), given);
  const JobSpec whole = WithDefaults(job, machine);
  Findings findings;
  if (job.block().has_size_mm()) {
    CheckRoom(whole, findings);
    CheckReach(whole, machine, stage_per_glass_ratio, findings);
    CheckStation(whole, machine, findings);
  }
  CheckBlockPlace(whole, machine, findings);
  CheckLens(whole, machine, stage_per_glass_ratio, findings);
  CheckDividedBlock(whole, machine, findings);
  CheckLayers(whole, findings);
  CheckOwnSpacing(whole, findings);
  CheckModules(whole, findings);
  CheckMethods(whole, findings);
  CheckOrdering(job.ordering(), findings);
  CheckMotion(whole.motion(), whole.discretization().min_spacing_mm(), machine, findings);
  CheckDepthTolerance(whole, machine, findings);
  CheckLaserOn(whole.laser(), machine, findings);
  CheckEnergiesOn(whole, machine, findings);
  CheckChannels(whole, findings);
  CheckZeros(whole, machine, findings);
  return std::move(findings.found());
}

std::vector<Finding> CheckAll(const JobSpec& job, const MachineSpec& machine,
                              std::optional<double> stage_per_glass_ratio) {
  std::vector<Finding> all;
  for (Error& error : CheckMachine(machine)) {
    error.message = "machine: " + error.message;
    all.push_back({std::move(error), "machine"});
  }
  std::set<std::string> fields;
  std::vector<std::vector<Finding>> parts;
  if (ConcernsMarks(job, machine)) {
    parts = {CheckMarkJob(job, machine)};
  } else {
    parts = {CheckJob(job), CheckJobOnMachine(job, machine, stage_per_glass_ratio)};
  }
  for (const auto& part : parts) {
    for (const Finding& finding : part) {
      if (fields.insert(finding.field).second) all.push_back(finding);
    }
  }
  return all;
}

Error JoinErrors(const std::vector<Error>& errors) {
  Require(!errors.empty(), "JoinErrors without an error");
  Error joined = errors.front();
  for (std::size_t i = 1; i < errors.size(); ++i)
    joined.message += "\n" + errors[i].message;
  return joined;
}

Error JoinErrors(const std::vector<Finding>& findings) {
  return JoinErrors(std::vector<Error>(findings.begin(), findings.end()));
}

}  // namespace intaglio
