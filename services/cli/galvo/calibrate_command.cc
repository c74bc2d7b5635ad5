// `intaglio galvo calibrate`: the correction of a scan head from a measured grid.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/galvo/files/ct5_tables.h"
#include "engrave/galvo/head_fit.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/whole_file.h"
#include "engrave/render/deviations.h"
#include "engrave/render/png_file.h"
#include "services/cli/galvo/calibration_figures.h"
#include "services/cli/galvo/correction_source.h"
#include "services/cli/galvo/galvo_command.h"
#include "services/cli/galvo/grid_marks.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/job/files/job_file.h"
#include "services/platform/command_line/supplied_files.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

// The written correction has these: the fit is smooth, so that 129 are exact to 1 nm.
constexpr int kFitNodes = 129;
// Commands of a correction reach beyond the field by their distortion.
constexpr double kMaxCommandWidth = 1.25;

// The field of a profile has so many steps of a .ctb file, and of half a .ct5 file.
constexpr double kCtbSteps = 1 << 16, kHalfCt5Steps = 1 << 19;

struct CalibrateOptions {
  std::string machine, table, out, picture;
  GridMarksOptions marks;
  double field_mm = 0, half_angle_deg = 20;  // 0: that of the profile
  int bits = 0;                              // 0: that of the table
  std::optional<double> table_bits;
};

/// What the control has to command for each target.
Result<galvo::CorrectionTable> CommandsBy(const galvo::HeadFit& fit, double width_mm) {
  const auto deviations = INTAGLIO_TRY(galvo::CorrectionTable::Make(
      galvo::DeviationsOf(fit, width_mm, kFitNodes), galvo::Interpolation::kSpline));
  return galvo::CorrectionTable::Make(
      INTAGLIO_TRY(galvo::CommandGrid(deviations, kFitNodes)),
      galvo::Interpolation::kSpline);
}

/// Marks by what the control commanded, where a correction was in use: the head is
/// fitted, not what the correction left of it. Returns the width that holds these
/// commands.
double ToHeadCommands(const galvo::CorrectionTable& before, double field_mm,
                      std::vector<galvo::GridMark>& marks) {
  double width_mm = field_mm;
  for (galvo::GridMark& mark : marks) {
    mark.command_mm += before.At(mark.command_mm);
    width_mm = std::max(width_mm, 2 * mark.command_mm.cwiseAbs().maxCoeff());
  }
  return std::min(width_mm, kMaxCommandWidth * field_mm);
}

/// What the options leave out, of the profile.
struct HeadInUse {
  double field_mm = 0;
  std::string table;
  std::optional<double> table_bits;
  int bits = 0;  ///< of the correction to be written; 0: that of the table
};

Result<HeadInUse> HeadOf(const CalibrateOptions& options) {
  HeadInUse head{options.field_mm, options.table, options.table_bits, options.bits};
  if (options.machine.empty()) {
    if (head.field_mm > 0) return head;
    return Fail(ErrorCode::kMissing,
                "--field: is missing; give the width of the field, mm, or the profile of "
                "the head with --machine");
  }
  const auto machine = INTAGLIO_TRY(ReadMachineFile(INTAGLIO_TRY(
      command_line::FindSupplied(options.machine, command_line::kSuppliedProfiles))));
  if (!machine.has_scan_head()) {
    return Fail(ErrorCode::kUnsupported,
                options.machine +
                    ": has no scan_head; name the profile of a machine "
                    "with a scan head",
                options.machine);
  }
  const double field_mm = machine.scan_head().field_mm();
  if (head.field_mm == 0) head.field_mm = field_mm;
  if (head.table.empty()) head.table = machine.scan_head().correction_file();
  if (!head.table_bits) head.table_bits = kCtbSteps / field_mm;
  if (head.bits == 0 && fs::path(head.table).extension() != ".ct5")
    head.bits = static_cast<int>(std::lround(kHalfCt5Steps / field_mm));
  return head;
}

Result<int> BitsOf(const HeadInUse& head, const CorrectionSource* before) {
  if (head.bits > 0) return head.bits;
  if (before != nullptr && before->ct5)
    return before->ct5->header[galvo::kCt5Calibration];
  return Fail(ErrorCode::kMissing,
              "--bits: the calibration of the control, bit/mm (of 20 bits), is needed to "
              "write a .ct5 file");
}

Status WriteTable(const std::string& out, const HeadInUse& head,
                  const galvo::HeadFit& fit, double width_mm,
                  const CorrectionSource* before) {
  const int bits = INTAGLIO_TRY(BitsOf(head, before));
  const auto commands = INTAGLIO_TRY(CommandsBy(fit, width_mm));
  const galvo::Ct5* like = before != nullptr && before->ct5 ? &*before->ct5 : nullptr;
  const auto file = INTAGLIO_TRY(galvo::Ct5Of(commands, bits, like));
  INTAGLIO_TRY(io::WriteFileAtomically(out, std::string_view(galvo::WriteCt5(file))));
  std::cout << fmt::format("written       {}, {} bit/mm\n", out, bits);
  std::error_code error;
  std::cerr << fmt::format(
      "Use it: scan_head {{ correction_file: \"{}\" }} in the machine profile, and open "
      "the shop again. Prove it: mark the grid again (intaglio galvo grid) and calibrate "
      "with that profile; \"field\" is what is wrong then.\n",
      fs::absolute(out, error).string());
  return {};
}

Status DrawResiduals(const std::string& picture,
                     const std::vector<galvo::GridMark>& as_marked,
                     const galvo::HeadFit& fit, const std::vector<std::string>& figures) {
  std::vector<render::Deviation> measured, left;
  for (std::size_t i = 0; i < as_marked.size(); ++i) {
    if (!fit.used[i]) continue;
    const Vec2& place_mm = as_marked[i].command_mm;
    measured.push_back({place_mm, as_marked[i].measured_mm - place_mm});
    left.push_back({place_mm, fit.residuals_mm[i]});
  }
  return render::WritePng(
      picture, render::DrawDeviations({{"Marks against their places", measured},
                                       {"What the new correction leaves", left}},
                                      figures));
}

/// Moves places in a frame of their own, which are given from one of its marks: the
/// middle of the field comes to 0 by all of them, and not by that mark with its noise.
Status CentreMarks(const galvo::HeadFitOptions& head, const CorrectionSource* before,
                   std::vector<galvo::GridMark>& marks,
                   std::vector<galvo::GridMark>& as_marked) {
  const auto fit = INTAGLIO_TRY(galvo::FitHead(marks, head));
  const Vec2 middle_mm = galvo::ArrivalOf(
      fit, before == nullptr ? Vec2(Vec2::Zero()) : before->commands.At(Vec2::Zero()));
  for (auto* list : {&marks, &as_marked})
    for (galvo::GridMark& mark : *list) mark.measured_mm -= middle_mm;
  return {};
}

Status Calibrate(const CalibrateOptions& options) {
  const HeadInUse head = INTAGLIO_TRY(HeadOf(options));
  auto marks = INTAGLIO_TRY(ReadGridMarks(options.marks));
  const std::string file = options.marks.measured.file.string();
  std::optional<CorrectionSource> before;
  if (!head.table.empty())
    before = INTAGLIO_TRY(ReadCorrection(head.table, head.table_bits));
  std::vector<galvo::GridMark> as_marked = marks;
  const double width_mm =
      before ? ToHeadCommands(before->commands, head.field_mm, marks) : head.field_mm;
  const double half_angle_rad = options.half_angle_deg * std::numbers::pi / 180;
  const galvo::HeadFitOptions fitted{width_mm, head.field_mm / 2 / half_angle_rad};
  if (options.marks.nodes > 0) {
    const auto centred =
        CentreMarks(fitted, before ? &*before : nullptr, marks, as_marked);
    if (!centred) return tl::unexpected(io::AboutFile(centred.error(), file));
  }
  const auto fit = galvo::FitHead(marks, fitted);
  if (!fit) return tl::unexpected(io::AboutFile(fit.error(), file));
  const std::vector<std::string> figures =
      FitLines(as_marked, *fit, before ? &before->commands : nullptr, width_mm);
  if (!head.table.empty()) std::cout << "in use        " << head.table << "\n";
  for (const std::string& line : ModelLines(*fit)) std::cout << line << "\n";
  for (const std::string& line : figures) std::cout << line << "\n";
  if (!options.out.empty())
    INTAGLIO_TRY(
        WriteTable(options.out, head, *fit, width_mm, before ? &*before : nullptr));
  if (options.picture.empty()) return {};
  return DrawResiduals(options.picture, as_marked, *fit, figures);
}

void AddMarksOptions(command_line::Command calibrate, CalibrateOptions& o,
                     std::string& file) {
  calibrate
      .AddOption("marks", file,
                 "CSV: command_x_mm, command_y_mm, measured_x_mm, measured_y_mm; with "
                 "--nodes a picture, or CSV: x_mm, y_mm")
      .Require();
  const auto nodes = calibrate
                         .AddOption("--nodes", o.marks.nodes,
                                    "of the grid a side, odd, when its commands are not "
                                    "in the file")
                         .Within(5, 65);
  calibrate.AddOption("--pitch", o.marks.pitch_mm, "of the grid, mm")
      .Positive()
      .Need(nodes);
  calibrate
      .AddOption("--pixel", o.marks.measured.pixel_um,
                 "of a picture: side of a pixel on the piece, um")
      .Positive()
      .Need(nodes);
  calibrate
      .AddOption("--mark-size", o.marks.measured.mark_um,
                 "of a picture: diameter of a mark, um")
      .Positive()
      .Need(nodes);
}

void AddHeadOptions(command_line::Command calibrate, CalibrateOptions& o) {
  calibrate.AddOption("--machine", o.machine,
                      "profile of the head: its field, the correction in use, and a "
                      "--bits for it");
  calibrate.AddOption("--field", o.field_mm, "width of the square field, mm")
      .Within(1.0, 2000.0);
  calibrate
      .AddOption("--angle", o.half_angle_deg,
                 "optical angle (twice the mirror's) at the border, degrees")
      .Within(0.1, 45.0)
      .ShowDefault();
  calibrate.AddOption("--table", o.table,
                      "correction in use when the marks were made: .ct5, .ctb, .cor");
  calibrate.AddOption("--table-bits", o.table_bits, "bit/mm of a .ctb file")
      .Within(0.1, 65536.0);
}

}  // namespace

void AddGalvoCalibrateCommand(command_line::Command galvo) {
  auto o = std::make_shared<CalibrateOptions>();
  auto file = std::make_shared<std::string>();
  command_line::Command calibrate =
      galvo.AddCommand("calibrate", "the correction of a head from a measured grid");
  AddMarksOptions(calibrate, *o, *file);
  AddHeadOptions(calibrate, *o);
  calibrate.AddOption("--out", o->out, "the new correction, .ct5");
  calibrate
      .AddOption("--bits", o->bits,
                 "bit/mm of --out, default that of a --table .ct5, else with --machine "
                 "2^19 over the field")
      .Within(1, 1 << 20);
  calibrate.AddOption("--picture", o->picture, "PNG: what the correction leaves");
  calibrate.SetFooter(
      "Example: intaglio galvo calibrate grid.csv --field 100 --bits 5184 --out new.ct5\n"
      "         intaglio galvo calibrate scan.png --machine galvo --nodes 9 --pitch 12 "
      "--pixel 21.167 --mark-size 300 --out new.ct5\n"
      "`intaglio galvo grid` makes the job of the grid.\n"
      "Exit code: 0 good, 2 wrong input.");
  calibrate.SetAction([o, file] {
    o->marks.measured.file = *file;
    if (const auto done = Calibrate(*o); !done)
      return Complain(done.error(), client::kExitWrongInput);
    return static_cast<int>(client::kExitGood);
  });
}

void AddGalvoCommand(command_line::Command app) {
  command_line::Command galvo =
      app.AddCommand("galvo", "scan heads: correction, marks on a web, outputs");
  galvo.RequireCommand();
  galvo.SetFooter(
      "Example: intaglio galvo grid --machine galvo --out grid\n"
      "docs/machines/galvo.md explains tables and figures.");
  AddGalvoGridCommand(galvo);
  AddGalvoCalibrateCommand(galvo);
  AddGalvoPlanCommand(galvo);
  AddGalvoTicksCommand(galvo);
}

}  // namespace intaglio::cli
