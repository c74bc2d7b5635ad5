// `intaglio machine measure`: the test pattern of a machine, or the test cube of a scan
// head over a block, and what its marks show.

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "engrave/calibrate/test_pattern.h"
#include "engrave/core/try.h"
#include "engrave/formats/point_file.h"
#include "engrave/io/atomic_file.h"
#include "engrave/render/deviations.h"
#include "engrave/render/png_file.h"
#include "services/cli/json/print_json.h"
#include "services/cli/machine/machine_command.h"
#include "services/cli/machine/measurement_text.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/machine/cube_job.h"
#include "services/client/machine/cube_measurement.h"
#include "services/client/machine/measurement.h"
#include "services/client/machine/pattern_job.h"
#include "services/job/convert/model_kind.h"
#include "services/job/files/job_file.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct MachineMeasureOptions {
  std::string folder, machine, glass = "N-BK7", out, profile;
  std::vector<double> block_mm;
  client::MarksFile marks;
  std::string marks_file, known = "index";
  client::CubeJob cube;
  bool json = false;
};

int PrintHowToMeasure(const fs::path& job, const char* what) {
  std::cout << job.string() << "\n";
  std::cerr << "Engrave it: intaglio submit " << job.string()
            << " --arm --watch (or intaglio run, in the virtual engraver). Then " << what
            << " and give them with the folder of the job: intaglio machine measure "
               "FOLDER --marks FILE\n";
  return client::kExitGood;
}

/// The job of the pattern or of the cube, in a folder of its own.
int MakePatternJob(const MachineMeasureOptions& options) {
  const auto file =
      command_line::FindSupplied(options.machine, command_line::kSuppliedProfiles);
  if (!file) return Complain(file.error());
  const auto machine = ReadMachineFile(*file);
  if (!machine) return Complain(machine.error());
  const auto block = [&](Vec3& size_mm) {
    if (!options.block_mm.empty())
      size_mm = Eigen::Map<const Vec3>(options.block_mm.data());
  };
  if (machine->has_head_over_block()) {
    client::CubeJob job = options.cube;
    job.machine_file = *file;
    block(job.block_mm);
    job.glass = options.glass;
    const auto made = client::WriteCubeJob(job, options.out);
    if (!made) return Complain(made.error());
    return PrintHowToMeasure(
        *made,
        "fill in cube.csv beside it: x, y and z of each mark from the faces of the "
        "block");
  }
  client::PatternJob job;
  job.machine_file = *file;
  block(job.block_mm);
  job.glass = options.glass;
  const auto made = client::WritePatternJob(job, options.out);
  if (!made) return Complain(made.error());
  return PrintHowToMeasure(*made, "measure the marks");
}

struct Measured {
  MachineMeasurement report;
  MachineSpec corrected;
  std::vector<render::Deviation> deviations;
};

Result<Measured> MeasureHead(const client::Evidence& evidence,
                             const MachineMeasureOptions& options) {
  const auto known = options.known == "z"       ? calibrate::KnownOfHead::kZ
                     : options.known == "pupil" ? calibrate::KnownOfHead::kPupil
                                                : calibrate::KnownOfHead::kIndex;
  auto cube = INTAGLIO_TRY(client::MeasureCube(evidence, options.marks_file, known));
  Measured measured{std::move(cube.report), std::move(cube.corrected.machine), {}};
  for (const client::MeasuredCubeMark& mark : cube.marks) {
    const Vec2 by_mm = (mark.measured_mm - mark.wanted_mm).head<2>();
    if (by_mm.allFinite())
      measured.deviations.push_back({mark.wanted_mm.head<2>(), by_mm});
  }
  return measured;
}

Result<Measured> Measure(const MachineMeasureOptions& options) {
  const client::Evidence evidence = INTAGLIO_TRY(client::ReadEvidence(options.folder));
  if (evidence.job.machine().has_head_over_block()) return MeasureHead(evidence, options);
  client::MarksFile marks = options.marks;
  marks.file = options.marks_file;
  auto machine = INTAGLIO_TRY(client::MeasureMachine(evidence, marks));
  Measured measured{std::move(machine.report), std::move(machine.corrected.machine), {}};
  for (std::size_t i = 0; i < machine.marks.size(); ++i) {
    measured.deviations.push_back(
        {machine.marks[i].place_mm, machine.fit.deviations_mm[i]});
  }
  return measured;
}

Status WriteDeviations(const Measured& measured, const fs::path& file) {
  return render::WritePng(
      file,
      render::DrawDeviations({{measured.report.machine() + ": marks against their places",
                               measured.deviations}},
                             FigureLinesOf(measured.report)));
}

int MeasurePattern(const MachineMeasureOptions& options) {
  auto measured = Measure(options);
  if (!measured) return Complain(measured.error());
  const fs::path out = options.out.empty() ? options.folder : options.out;
  std::error_code error;
  fs::create_directories(out, error);
  const fs::path profile =
      options.profile.empty() ? out / "corrected.textproto" : fs::path(options.profile);
  const fs::path picture = out / "deviations.png";
  measured->report.set_profile(profile.string());
  measured->report.set_picture(picture.string());
  for (const Status& written : {WriteMachineFile(profile, measured->corrected),
                                WriteDeviations(*measured, picture)}) {
    if (!written) return Complain(written.error());
  }
  if (options.json) return PrintJson(measured->report);
  for (const std::string& line : FigureLinesOf(measured->report)) {
    std::cout << line << "\n";
  }
  for (const std::string& line : OutcomeLinesOf(measured->report)) {
    std::cout << line << "\n";
  }
  return client::kExitGood;
}

int RunMachineMeasure(const MachineMeasureOptions& options) {
  const bool pattern = !options.machine.empty();
  if (pattern == (!options.folder.empty() || !options.marks_file.empty())) {
    return Complain({ErrorCode::kMissing,
                     "give either --machine, to make the test pattern, or the FOLDER of "
                     "its job with --marks, to measure it",
                     ""});
  }
  if (pattern) {
    if (!options.out.empty()) return MakePatternJob(options);
    return Complain({ErrorCode::kMissing,
                     "--out: is missing; name a folder for the pattern's job", ""});
  }
  if (options.folder.empty() || options.marks_file.empty()) {
    return Complain(
        {ErrorCode::kMissing,
         "FOLDER and --marks belong together: the folder of the pattern's job "
         "and where its marks lie",
         ""});
  }
  if (KindOfFile(options.marks_file) == ModelKind::kImage &&
      options.marks.pixel_um <= 0) {
    return Complain({ErrorCode::kMissing,
                     "--pixel: is missing; give the side of a pixel in the block, um (a "
                     "scan of 2400 dpi has 10.583)",
                     ""});
  }
  return MeasurePattern(options);
}

}  // namespace

void AddMachineMeasureCommand(command_line::Command machine) {
  auto options = std::make_shared<MachineMeasureOptions>();
  command_line::Command measure = machine.AddCommand(
      "measure",
      "what is wrong with the axes or the scan head, by a test pattern or cube");
  measure.AddOption("FOLDER", options->folder,
                    "of the job that made the pattern: of `run`, or of a shop's job");
  measure.AddOption("--marks", options->marks_file,
                    "where its marks lie: .csv with x_mm and y_mm, a picture from above, "
                    "or points; of a scan head over a block the filled cube.csv");
  measure
      .AddOption("--pixel", options->marks.pixel_um,
                 "of a picture: side of a pixel in the block, um")
      .Positive();
  measure
      .AddOption("--mark-size", options->marks.mark_um,
                 "of a picture: diameter of a mark, um; default that of the lens' cracks")
      .Positive();
  measure.AddOption("--machine", options->machine,
                    "makes the pattern instead: profile, a file or a supplied name");
  measure
      .AddOption("--nodes", options->cube.nodes,
                 "of a scan head's cube: marks of a side of a level")
      .Within(3, 41)
      .ShowDefault();
  measure.AddOption("--levels", options->cube.levels, "of a scan head's cube: depths")
      .Within(2, 10)
      .ShowDefault();
  measure
      .AddOption(
          "--known", options->known,
          "of a scan head, what is not fitted: the index of the glass, the scale of "
          "z, or the distances of the pupil")
      .OneOf({"index", "z", "pupil"})
      .ShowDefault();
  measure.AddOption("--block", options->block_mm, "block of the pattern, mm")
      .TakeValues(3)
      .Positive();
  measure.AddOption("--glass", options->glass, "its glass").ShowDefault();
  measure.AddOption("--out", options->out,
                    "folder of the pattern's job, or of profile and picture (default "
                    "FOLDER)");
  measure.AddOption("--profile", options->profile,
                    "file of the corrected profile, default corrected.textproto");
  measure.AddFlag("--json", options->json, "prints MachineMeasurement as JSON");
  measure.SetFooter(
      "Example: intaglio machine measure --machine els-03 --block 50 50 20 --out "
      "pattern; "
      "intaglio submit pattern/pattern.textproto --arm --watch; intaglio machine measure "
      "intaglio-shop/jobs/1 --marks scan.png --pixel 10.583\n"
      "Exit code: 0 measured, 2 wrong input, or marks that are not the pattern.");
  measure.SetAction([options] { return RunMachineMeasure(*options); });
}

}  // namespace intaglio::cli
