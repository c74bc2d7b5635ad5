#include "services/client/machine/grid_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/galvo/calibration_grid.h"
#include "engrave/io/atomic_file.h"
#include "services/job/files/job_file.h"
#include "services/job/head/head_correction.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

constexpr double kCoveredShare = 0.96;  // of the field, by default
// With this share of a disc's diameter lines overlap with any usual spot, a dozen a disc.
constexpr double kHatchShare = 0.1;
constexpr double kMaxDiscShare = 0.2;  // of the pitch, or discs are taken for each other

Status CheckGrid(const GridJob& asked, double pitch_mm, double field_mm) {
  INTAGLIO_TRY(galvo::CheckCalibrationGrid(asked.nodes, pitch_mm));
  const double disc_mm = asked.mark_um / 1000;
  if (!(disc_mm > 0 && disc_mm <= kMaxDiscShare * pitch_mm)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("discs of {:.6g} um at a pitch of {:.6g} mm; a disc may be a "
                            "fifth of the pitch, {:.6g} um",
                            asked.mark_um, pitch_mm, 1000 * kMaxDiscShare * pitch_mm),
                fmt::format("{:.6g}", asked.mark_um));
  }
  const double width_mm = (asked.nodes - 1) * pitch_mm + disc_mm;
  if (width_mm <= field_mm) return {};
  return Fail(
      ErrorCode::kOutsideBlock,
      fmt::format("a grid of {} nodes, {:.6g} mm apart, is {:.6g} mm wide, and the field "
                  "{:.6g} mm; give a smaller pitch",
                  asked.nodes, pitch_mm, width_mm, field_mm),
      fmt::format("{:.6g}", pitch_mm));
}

std::vector<Vec2> DiscsOf(int nodes, double pitch_mm) {
  std::vector<Vec2> discs_mm = galvo::CalibrationGrid(nodes, pitch_mm);
  discs_mm.push_back(galvo::DirectionDisc(pitch_mm));
  return discs_mm;
}

/// y of a drawing in SVG points down.
std::string DrawingOf(const std::vector<Vec2>& discs_mm, double field_mm,
                      double disc_mm) {
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{0}mm\" height=\"{0}mm\" "
      "viewBox=\"{1} {1} {0} {0}\">\n",
      field_mm, -field_mm / 2);
  for (const Vec2& disc : discs_mm) {
    text += fmt::format("<circle cx=\"{}\" cy=\"{}\" r=\"{}\"/>\n", disc.x(), -disc.y(),
                        disc_mm / 2);
  }
  return text + "</svg>\n";
}

std::string TableOf(const std::vector<Vec2>& nodes_mm) {
  std::string text = "command_x_mm,command_y_mm,measured_x_mm,measured_y_mm\n";
  for (const Vec2& node : nodes_mm) text += fmt::format("{},{},,\n", node.x(), node.y());
  return text;
}

JobSpec JobOf(const GridJob& asked) {
  JobSpec job;
  job.set_name("calibration grid");
  job.set_machine_file(asked.machine_file.string());
  MarkItem& item = *job.mutable_marks()->add_items();
  item.mutable_drawing()->set_file("grid.svg");
  item.mutable_hatch()->set_distance_mm(
      std::max(0.001, kHatchShare * asked.mark_um / 1000));
  return job;
}

}  // namespace

Result<WrittenGrid> WriteGridJob(const GridJob& asked, const fs::path& folder) {
  const MachineSpec machine = INTAGLIO_TRY(ReadMachineFile(asked.machine_file));
  if (!machine.has_scan_head()) {
    return Fail(ErrorCode::kUnsupported,
                machine.name() +
                    ": its profile has no scan_head, and the grid measures the field of "
                    "one; name the profile of a machine with a scan head",
                machine.name());
  }
  const double field_mm = INTAGLIO_TRY(WindowOf(machine.scan_head())).square_mm();
  WrittenGrid grid;
  grid.pitch_mm =
      asked.pitch_mm.value_or(kCoveredShare * field_mm / std::max(1, asked.nodes - 1));
  grid.correction_file = machine.scan_head().correction_file();
  INTAGLIO_TRY(CheckGrid(asked, grid.pitch_mm, field_mm));
  std::error_code error;
  fs::create_directories(folder, error);
  const std::string drawing =
      DrawingOf(DiscsOf(asked.nodes, grid.pitch_mm), field_mm, asked.mark_um / 1000);
  const std::string table = TableOf(galvo::CalibrationGrid(asked.nodes, grid.pitch_mm));
  INTAGLIO_TRY(io::WriteFileAtomically(folder / "grid.svg", std::string_view(drawing)));
  INTAGLIO_TRY(io::WriteFileAtomically(folder / "grid.csv", std::string_view(table)));
  grid.job_file = folder / "grid.textproto";
  INTAGLIO_TRY(WriteJobFile(grid.job_file, JobOf(asked)));
  return grid;
}

}  // namespace intaglio::client
