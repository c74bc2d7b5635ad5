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
#include "engrave/galvo/grid_match.h"
#include "engrave/galvo/head_fit.h"
#include "engrave/io/atomic_file.h"
#include "engrave/io/csv.h"
#include "engrave/io/number_text.h"
#include "engrave/io/whole_file.h"
#include "engrave/render/deviations.h"
#include "engrave/render/png_file.h"
#include "services/cli/complain.h"
#include "services/cli/galvo/correction_source.h"
#include "services/cli/galvo/galvo_command.h"
#include "services/client/exit_codes.h"
#include "services/client/machine/measured_marks.h"

namespace intaglio::cli {
namespace {

// Of the correction that is written: the fit is smooth, so that 129 are exact to 1 nm.
constexpr int kFitNodes = 129;
// Of the field: commands of a correction reach beyond it by their distortion.
constexpr double kMaxCommandWidth = 1.25;

struct CalibrateOptions {
  std::string marks, table, out, picture;
  double field_mm = 0, half_angle_deg = 20;
  int bits = 0, nodes = 0;  // 0: that of the table
  std::optional<double> table_bits, pitch_mm;
  client::MarksFile measured;  // of a grid whose commands are not in the file
};

Result<double> CoordinateIn(const io::CsvTable& table, const io::CsvRow& row,
                            std::string_view column, const std::string& file) {
  const std::string* text = table.Find(row, column);
  if (text == nullptr) {
    return Fail(ErrorCode::kMissing,
                fmt::format("{}: has no column {}; give command_x_mm, command_y_mm, "
                            "measured_x_mm and measured_y_mm",
                            file, column));
  }
  const auto number = io::ParseFinite(*text);
  if (number) return *number;
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("{}:{}: {} {:?} is no number; leave the line out when the mark "
                          "was not found",
                          file, row.line_number, column, *text),
              *text);
}

Result<std::vector<galvo::GridMark>> ReadCommandedMarks(const std::string& file) {
  const auto table = INTAGLIO_TRY(io::ReadCsv(file));
  std::vector<galvo::GridMark> marks;
  for (const io::CsvRow& row : table.rows) {
    galvo::GridMark mark;
    mark.command_mm.x() = INTAGLIO_TRY(CoordinateIn(table, row, "command_x_mm", file));
    mark.command_mm.y() = INTAGLIO_TRY(CoordinateIn(table, row, "command_y_mm", file));
    mark.measured_mm.x() = INTAGLIO_TRY(CoordinateIn(table, row, "measured_x_mm", file));
    mark.measured_mm.y() = INTAGLIO_TRY(CoordinateIn(table, row, "measured_y_mm", file));
    marks.push_back(mark);
  }
  return marks;
}

/// Marks whose commands are not known: each is matched to a node of the grid.
Result<std::vector<galvo::GridMark>> ReadGrid(const CalibrateOptions& options) {
  if (!options.pitch_mm)
    return Fail(ErrorCode::kMissing, "--nodes: needs --pitch, of the grid, mm");
  const std::string kind = std::filesystem::path(options.marks).extension().string();
  if (kind != ".csv" &&
      (options.measured.pixel_um <= 0 || options.measured.mark_um <= 0)) {
    return Fail(ErrorCode::kMissing,
                "--pixel and --mark-size: are missing; give the side of a pixel on the "
                "piece (a scan of 1200 dpi has 21.167) and the diameter of a mark, um");
  }
  client::MarksFile asked = options.measured;
  asked.file = options.marks;
  const auto measured = INTAGLIO_TRY(client::ReadMarks(asked));
  auto match = galvo::MatchGrid(measured.places_mm, options.nodes, *options.pitch_mm);
  if (!match) return tl::unexpected(io::AboutFile(match.error(), options.marks));
  std::cout << fmt::format("grid          {} of {} nodes found, {} other spots\n",
                           match->marks.size(), options.nodes * options.nodes,
                           match->left_out_count);
  return std::move(match->marks);
}

struct Sizes {
  double rms_um = 0, largest_um = 0;
};

Sizes SizesOf(const std::vector<Vec2>& by_mm) {
  Sizes sizes;
  for (const Vec2& v : by_mm) {
    sizes.rms_um += 1e6 * v.squaredNorm();
    sizes.largest_um = std::max(sizes.largest_um, 1e3 * v.norm());
  }
  sizes.rms_um = std::sqrt(sizes.rms_um / static_cast<double>(by_mm.size()));
  return sizes;
}

std::vector<std::string> FitFigures(const std::vector<galvo::GridMark>& marks,
                                    const galvo::HeadFit& fit) {
  std::vector<Vec2> before, after;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (!fit.used[i]) continue;
    before.push_back(marks[i].measured_mm - marks[i].command_mm);
    after.push_back(fit.residuals_mm[i]);
  }
  const Sizes was = SizesOf(before), left = SizesOf(after);
  std::vector<std::string> lines = {
      fmt::format("marks         {}, {} left out as too far from all others",
                  before.size(), marks.size() - before.size()),
      fmt::format("measured      {:.1f} um rms, {:.1f} um largest beside the commands",
                  was.rms_um, was.largest_um),
      fmt::format("fitted        {:.2f} um rms, {:.2f} um largest left", left.rms_um,
                  left.largest_um),
      fmt::format("sigma         {:.2f} um of a coordinate of a mark",
                  1e3 * fit.sigma_mm),
      fmt::format("unseen marks  {:.2f} um rms by the nine numbers, {:.2f} um with a "
                  "surface of what they leave",
                  1e3 * fit.unseen_rms_mm, 1e3 * fit.unseen_rms_with_surface_mm)};
  lines.push_back(fit.surface_cells > 0
                      ? fmt::format("surface       {0} x {0} cells", fit.surface_cells)
                      : "surface       none: what is left is chance");
  return lines;
}

void PrintModel(const galvo::HeadModel& model, const galvo::HeadFit& fit) {
  const auto numbers = model.Numbers();
  for (std::size_t k = 0; k < numbers.size(); ++k) {
    std::cout << fmt::format("{:<13} {:.6g} +- {:.2g}, 95 %\n", galvo::kHeadModelNames[k],
                             numbers[k], fit.interval95[k]);
  }
}

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

Result<int> BitsOf(const CalibrateOptions& options, const CorrectionSource* before) {
  if (options.bits > 0) return options.bits;
  if (before != nullptr && before->ct5)
    return before->ct5->header[galvo::kCt5Calibration];
  return Fail(ErrorCode::kMissing,
              "--bits: the calibration of the control, bit/mm (of 20 bits), is needed to "
              "write a .ct5 file");
}

Status WriteTable(const CalibrateOptions& options, const galvo::HeadFit& fit,
                  double width_mm, const CorrectionSource* before) {
  const int bits = INTAGLIO_TRY(BitsOf(options, before));
  const auto commands = INTAGLIO_TRY(CommandsBy(fit, width_mm));
  const galvo::Ct5* like = before != nullptr && before->ct5 ? &*before->ct5 : nullptr;
  const auto file = INTAGLIO_TRY(galvo::Ct5Of(commands, bits, like));
  INTAGLIO_TRY(
      io::WriteFileAtomically(options.out, std::string_view(galvo::WriteCt5(file))));
  std::cout << fmt::format("written       {}, {} bit/mm\n", options.out, bits);
  return {};
}

Status Calibrate(const CalibrateOptions& options) {
  auto marks = INTAGLIO_TRY(options.nodes > 0 ? ReadGrid(options)
                                              : ReadCommandedMarks(options.marks));
  std::optional<CorrectionSource> before;
  if (!options.table.empty())
    before = INTAGLIO_TRY(ReadCorrection(options.table, options.table_bits));
  const std::vector<galvo::GridMark> as_marked = marks;
  const double width_mm = before
                              ? ToHeadCommands(before->commands, options.field_mm, marks)
                              : options.field_mm;
  const double half_angle_rad = options.half_angle_deg * std::numbers::pi / 180;
  const auto fit =
      galvo::FitHead(marks, {width_mm, options.field_mm / 2 / half_angle_rad});
  if (!fit) return tl::unexpected(io::AboutFile(fit.error(), options.marks));
  const std::vector<std::string> figures = FitFigures(as_marked, *fit);
  PrintModel(fit->model, *fit);
  for (const std::string& line : figures) std::cout << line << "\n";
  if (!options.out.empty())
    INTAGLIO_TRY(WriteTable(options, *fit, width_mm, before ? &*before : nullptr));
  if (options.picture.empty()) return {};
  std::vector<render::Deviation> left;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (fit->used[i]) left.push_back({as_marked[i].command_mm, fit->residuals_mm[i]});
  return render::WritePng(
      options.picture,
      render::DrawDeviations(left, {"What the correction leaves", figures}));
}

}  // namespace

void AddGalvoCalibrateCommand(command_line::Command galvo) {
  auto o = std::make_shared<CalibrateOptions>();
  command_line::Command calibrate =
      galvo.AddCommand("calibrate", "the correction of a head from a measured grid");
  calibrate
      .AddOption("marks", o->marks,
                 "CSV: command_x_mm, command_y_mm, measured_x_mm, measured_y_mm; with "
                 "--nodes a picture, or CSV: x_mm, y_mm")
      .Require();
  calibrate.AddOption("--field", o->field_mm, "width of the square field, mm")
      .Within(1.0, 2000.0)
      .Require();
  calibrate
      .AddOption("--angle", o->half_angle_deg,
                 "optical angle (twice the mirror's) at the border, degrees")
      .Within(0.1, 45.0)
      .ShowDefault();
  const auto nodes = calibrate
                         .AddOption("--nodes", o->nodes,
                                    "of the grid a side, odd, when its commands are not "
                                    "in the file")
                         .Within(5, 65);
  calibrate.AddOption("--pitch", o->pitch_mm, "of the grid, mm").Positive().Need(nodes);
  calibrate
      .AddOption("--pixel", o->measured.pixel_um,
                 "of a picture: side of a pixel on the piece, um")
      .Positive()
      .Need(nodes);
  calibrate
      .AddOption("--mark-size", o->measured.mark_um,
                 "of a picture: diameter of a mark, um")
      .Positive()
      .Need(nodes);
  calibrate.AddOption("--table", o->table,
                      "correction in use when the marks were made: .ct5, .ctb, .cor");
  calibrate.AddOption("--table-bits", o->table_bits, "bit/mm of a .ctb file")
      .Within(0.1, 65536.0);
  calibrate.AddOption("--out", o->out, "the new correction, .ct5");
  calibrate
      .AddOption("--bits", o->bits, "bit/mm of --out, default that of a --table .ct5")
      .Within(1, 1 << 20);
  calibrate.AddOption("--picture", o->picture, "PNG: what the correction leaves");
  calibrate.SetFooter(
      "Example: intaglio galvo calibrate grid.csv --field 100 --bits 5184 --out new.ct5\n"
      "         intaglio galvo calibrate scan.png --nodes 9 --pitch 12 --pixel 21.167 "
      "--mark-size 300 --field 100\n"
      "Exit code: 0 good, 2 wrong input.");
  calibrate.SetAction([o] {
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
      "Example: intaglio galvo calibrate grid.csv --field 100 --bits 5184 --out new.ct5\n"
      "docs/machines/galvo.md explains tables and figures.");
  AddGalvoCalibrateCommand(galvo);
  AddGalvoPlanCommand(galvo);
  AddGalvoTicksCommand(galvo);
}

}  // namespace intaglio::cli
