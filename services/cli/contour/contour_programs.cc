#include "services/cli/contour/contour_programs.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>
#include <numbers>
#include <utility>

#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/whole_file.h"
#include "services/cli/contour/planned_feeds.h"
#include "services/cli/progress/background_meter.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t kMaxTemplateFile = 1 << 20;

/// A template with the fragments of drilling. `option`: by which it was chosen.
Result<post::Template> ReadCycleTemplate(const std::string& name,
                                         const command_line::SuppliedKind& kind,
                                         const char* option,
                                         const post::Parameters& parameters) {
  auto file = command_line::FindSupplied(name, kind);
  if (!file) {
    Error error = file.error();
    error.message = fmt::format("{}: {}", option, error.message);
    return tl::unexpected(error);
  }
  const std::string text = INTAGLIO_TRY(io::ReadWholeFile(*file, kMaxTemplateFile));
  return post::ParseDrillTemplate(text, file->string(), parameters);
}

Result<post::Template> ReadDrillTemplate(const ContourProgramOptions& options) {
  const std::string& name =
      options.drill_template.empty() ? options.mill_template : options.drill_template;
  if (options.drill_template.empty() && fs::exists(name)) {
    return Fail(ErrorCode::kMissing,
                "--drill-template: is missing; the files have holes, and " + name +
                    " is a template for milling: give one for drilling, too",
                name);
  }
  return ReadCycleTemplate(name, kDrillTemplates, "--drill-template", options.parameters);
}

Result<post::Template> ReadProbeTemplate(const ContourProgramOptions& options) {
  return ReadCycleTemplate(fs::path(options.mill_template).stem().string(),
                           kProbeTemplates, "--probe-grid", options.parameters);
}

/// Beside `out`: its name and `ending`.
fs::path FileBeside(const fs::path& out, const char* ending,
                    const post::Template& program) {
  const std::string extension =
      program.extension.empty() ? out.extension().string() : "." + program.extension;
  return out.parent_path() / (out.stem().string() + ending + extension);
}

/// The places to probe: a grid over all that is made.
post::DrillRound ProbesOf(const ContourWork& work, double step_mm) {
  Box3 box;
  const auto extend = [&](const Vec2& at_mm) { box.Extend({at_mm.x(), at_mm.y(), 0}); };
  for (const post::ToolPath& path : work.paths) {
    extend(path.begin_mm);
    for (const contour::Edge& edge : post::EdgesOf(path)) {
      // An arc bulges beyond its ends, by no more than its quarters.
      for (int k = 1; k <= 8; ++k) extend(contour::PointAt(edge, edge.length_mm * k / 8));
    }
  }
  for (const post::DrillRound& round : work.rounds)
    for (const Vec2& place_mm : round.places_mm) extend(place_mm);
  return {0, post::ProbePlaces(box.min_mm.head<2>(), box.max_mm.head<2>(), step_mm)};
}

/// Its holes are as deep as its parameters and text say, whatever the course has.
void NoteOwnDepth(const post::Template& program, const Course& whole,
                  Warnings& warnings) {
  warnings.push_back(MakeWarning(
      WarningCode::kChosen,
      fmt::format("{}: has the depth of the holes itself, by its parameters or its text; "
                  "the time is that of holes of {:g} mm (drill_depth_mm)",
                  program.file, whole.drill_depth_mm())));
}

/// The contours, with planned feeds on a machine.
Result<std::vector<post::ToolPath>> PathsFor(const MachineSpec* machine,
                                             const post::Template& program,
                                             const ContourWork& work, const Course& whole,
                                             Warnings& warnings) {
  if (machine == nullptr) return work.paths;
  if (!post::HasSpeeds(program)) {
    warnings.push_back(MakeWarning(
        WarningCode::kChosen,
        fmt::format("{}: has no fragments 'speed' and 'rest', so the program has one "
                    "speed, and corners are passed as its controller does, not as "
                    "planned for {}",
                    program.file, machine->name())));
    return work.paths;
  }
  BackgroundMeter meter(std::cerr, isatty(STDERR_FILENO) != 0);
  meter.Begin("speeds");
  PlannedFeeds feeds = INTAGLIO_TRY(PlanFeeds(work.paths, whole.speed_mm_s(), *machine));
  // Grbl's limit is that of each axis; along a diagonal both have it.
  const double axis_mm_s2 = feeds.acceleration_mm_s2 / std::numbers::sqrt2;
  warnings.push_back(MakeWarning(
      WarningCode::kChosen,
      fmt::format(
          "the program has the speeds planned for {}: {:.1f} s at work, {:.1f} um off at "
          "most. The controller has to keep to {:.0f} mm/s^2 along the path (grbl: $120 "
          "and $121 at most {:.0f}), and needs a junction deviation of {:.3f} mm ($11), "
          "with which corners of programs without such speeds are passed too fast",
          machine->name(), feeds.work_s, 1e3 * feeds.worst_mm, feeds.acceleration_mm_s2,
          axis_mm_s2, feeds.junction_deviation_mm)));
  return std::move(feeds.paths);
}

Status WriteParts(const fs::path& first, const post::ProgramTexts& texts,
                  std::vector<fs::path>& files) {
  for (std::size_t part = 0; part < texts.size(); ++part) {
    const fs::path file =
        first.parent_path() /
        (post::PartName(first.stem().string(), part) + first.extension().string());
    INTAGLIO_TRY(io::WriteFileAtomically(file, texts[part]));
    files.push_back(file);
  }
  return {};
}

void GiveIf(bool given, const char* variable, post::Cutting& cutting) {
  if (given) cutting.given.emplace_back(variable);
}

post::Cutting CommonOf(const Course& whole, const Course& typed) {
  post::Cutting cutting = PassesOf(whole);
  cutting.speed_mm_s = whole.speed_mm_s();
  cutting.travel_mm_s = whole.travel_mm_s();
  cutting.plunge_mm_s = whole.plunge_mm_s();
  cutting.safe_mm = whole.safe_height_mm();
  cutting.tool_diameter_mm = whole.tool_diameter_mm();
  GiveIf(typed.has_plunge_mm_s(), "PLUNGE", cutting);
  GiveIf(typed.has_safe_height_mm(), "SAFE", cutting);
  return cutting;
}

}  // namespace

post::Cutting MillingOf(const Course& whole, const Course& typed) {
  post::Cutting cutting = CommonOf(whole, typed);
  GiveIf(typed.has_speed_mm_s(), "SPEED", cutting);
  GiveIf(typed.has_depth_mm(), "DEPTH", cutting);
  GiveIf(typed.has_power_ratio(), "POWER", cutting);
  return cutting;
}

post::Cutting DrillingOf(const Course& whole, const Course& typed) {
  post::Cutting cutting = CommonOf(whole, typed);
  GiveIf(typed.has_drill_depth_mm(), "DEPTH", cutting);
  cutting.depths_mm = {-whole.drill_depth_mm()};
  cutting.tab_top_mm.reset();
  cutting.power_ratio.reset();
  return cutting;
}

Result<post::Template> ReadMillTemplate(const std::string& name_or_file,
                                        const post::Parameters& given) {
  const fs::path file =
      INTAGLIO_TRY(command_line::FindSupplied(name_or_file, kMillTemplates));
  const std::string text = INTAGLIO_TRY(io::ReadWholeFile(file, kMaxTemplateFile));
  return post::ParseMillTemplate(text, file.string(), given);
}

Result<std::vector<fs::path>> WriteContourPrograms(const ContourWork& work,
                                                   const Course& whole,
                                                   const Course& typed,
                                                   const ContourProgramOptions& options,
                                                   Warnings& warnings) {
  const fs::path out = options.out;
  // All texts first: a fault in the second program leaves no first one behind.
  post::ProgramTexts mill_texts, drill_texts;
  fs::path drill_file = out;
  std::vector<post::Template> used;
  if (!work.paths.empty()) {
    const auto program =
        INTAGLIO_TRY(ReadMillTemplate(options.mill_template, options.parameters));
    used.push_back(program);
    post::Cutting cutting = MillingOf(whole, typed);
    cutting.name = out.stem().string();
    const auto paths =
        INTAGLIO_TRY(PathsFor(options.machine, program, work, whole, warnings));
    auto texts = INTAGLIO_TRY(post::MillPrograms(program, paths, cutting, options.mill));
    mill_texts = std::move(texts);
  }
  if (!work.rounds.empty()) {
    const auto program = INTAGLIO_TRY(ReadDrillTemplate(options));
    used.push_back(program);
    if (post::HasOwnDepth(program)) NoteOwnDepth(program, whole, warnings);
    if (!work.paths.empty()) {
      drill_file = FileBeside(out, "_drill", program);
    }
    post::Cutting cutting = DrillingOf(whole, typed);
    cutting.name = drill_file.stem().string();
    auto texts = INTAGLIO_TRY(
        post::DrillPrograms(program, work.rounds, cutting, options.mill.origin_mm,
                            options.mill.max_bytes, options.mill.heights));
    drill_texts = std::move(texts);
  }
  post::ProgramTexts probe_texts;
  fs::path probe_file;
  if (options.probe_step_mm) {
    const auto program = INTAGLIO_TRY(ReadProbeTemplate(options));
    used.push_back(program);
    probe_file = FileBeside(out, "_probe", program);
    post::Cutting cutting = CommonOf(whole, Course());
    cutting.name = probe_file.stem().string();
    const std::vector<post::DrillRound> probes = {ProbesOf(work, *options.probe_step_mm)};
    auto texts = INTAGLIO_TRY(
        post::DrillPrograms(program, probes, cutting, options.mill.origin_mm));
    probe_texts = std::move(texts);
  }
  INTAGLIO_TRY(post::RequireParameters(used, options.parameters));
  std::vector<fs::path> files;
  INTAGLIO_TRY(WriteParts(out, mill_texts, files));
  INTAGLIO_TRY(WriteParts(drill_file, drill_texts, files));
  INTAGLIO_TRY(WriteParts(probe_file, probe_texts, files));
  return files;
}

}  // namespace intaglio::cli
