#include "services/client/machine/cube_measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "engrave/core/try.h"
#include "engrave/galvo/correction_table.h"
#include "services/client/machine/corrected_head.h"
#include "services/client/machine/head_figures.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio::client {
namespace {

constexpr double kUmInMm = 1000;
// The table has four decimals.
constexpr double kSameMarkMm = 0.001;

const char* TextOf(calibrate::FigureState state) {
  switch (state) {
    case calibrate::FigureState::kFound:
      return "found";
    case calibrate::FigureState::kAsKnown:
      return "as in the profile";
    case calibrate::FigureState::kUndetermined:
      return "not determined";
    case calibrate::FigureState::kKnown:
      break;
  }
  return "taken as known";
}

/// The commands that made each mark.
Result<std::vector<calibrate::CubeMark>> CommandedMarksOf(
    const Evidence& evidence, const std::vector<MeasuredCubeMark>& measured,
    const std::filesystem::path& table) {
  const auto axes_from_glass = AxesFromGlassOf(evidence.job);
  const auto head =
      std::get<machine::ScanHeadOptions>(KinematicsOptionsOf(evidence.job.machine()));
  std::vector<calibrate::CubeMark> marks;
  for (const MeasuredCubeMark& mark : measured) {
    const bool made = std::ranges::any_of(evidence.plan_mm, [&](const Vec3& point_mm) {
      return (point_mm - mark.wanted_mm).norm() < kSameMarkMm;
    });
    if (!made) {
      return Fail(ErrorCode::kInvalidValue,
                  fmt::format("{}: line {}: {:g}, {:g}, {:g} mm is no point of the job; "
                              "fill in the table of this job's cube",
                              table.string(), mark.line_number, mark.wanted_mm.x(),
                              mark.wanted_mm.y(), mark.wanted_mm.z()));
    }
    const Vec3 axes = INTAGLIO_TRY(axes_from_glass.ToAxes(mark.wanted_mm, Vec3::Zero()));
    Vec2 field_mm = axes.head<2>();
    if (head.corrections) {
      field_mm = INTAGLIO_TRY(galvo::CommandFor(field_mm, *head.corrections));
    }
    marks.push_back({field_mm, axes.z(), mark.measured_mm});
  }
  return marks;
}

void FillDeviations(const std::vector<MeasuredCubeMark>& marks,
                    MachineMeasurement& report) {
  double squares = 0, largest_mm = 0;
  for (const MeasuredCubeMark& mark : marks) {
    double square = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const double by = mark.measured_mm[axis] - mark.wanted_mm[axis];
      if (std::isfinite(by)) square += by * by;
    }
    squares += square;
    largest_mm = std::max(largest_mm, std::sqrt(square));
  }
  report.set_rms_deviation_um(kUmInMm *
                              std::sqrt(squares / static_cast<double>(marks.size())));
  report.set_max_deviation_um(kUmInMm * largest_mm);
}

void FillFigures(const calibrate::CubeFit& fit, const calibrate::HeadState& known,
                 MachineMeasurement& report) {
  for (const HeadFigureName& row : kHeadFigureNames) {
    const calibrate::HeadFigure& figure = fit.figures[row.unknown];
    MeasuredHeadFigure& to = *report.add_head();
    to.set_name(std::string(row.name));
    to.set_unit(std::string(row.unit));
    to.mutable_figure()->set_value(figure.figure.value);
    to.mutable_figure()->set_interval95(figure.figure.interval95);
    to.set_profile(known[row.unknown]);
    to.set_state(TextOf(figure.state));
  }
}

std::string StrayText(const MeasuredCubeMark& mark, const Vec3& residual_mm) {
  return fmt::format(
      "mark {} was left out: it lies {:.3f}, {:.3f}, {:.3f} mm beside what "
      "the others say; measure it again",
      mark.number, residual_mm.x(), residual_mm.y(), residual_mm.z());
}

}  // namespace

Result<CubeMeasurement> MeasureCube(const Evidence& evidence,
                                    const std::filesystem::path& table,
                                    calibrate::KnownOfHead known) {
  CubeMeasurement measurement;
  measurement.marks = INTAGLIO_TRY(ReadMeasuredCube(table));
  const auto marks = INTAGLIO_TRY(CommandedMarksOf(evidence, measurement.marks, table));
  const FrozenJob& job = evidence.job;
  const calibrate::HeadState before = KnownHeadOf(job);
  const optics::MachineFromGlass frame = AxesFromGlassOf(job).machine_from_glass();
  const calibrate::CubeFrame cube{
      frame.block_size_mm.z(),
      1 / (before[calibrate::kIndex] * frame.stage_per_glass_ratio)};
  const auto fit = INTAGLIO_TRY(calibrate::FitCube(marks, before, cube, known));
  measurement.corrected = CorrectHead(job, fit);
  for (const std::size_t stray : fit.strays) {
    measurement.corrected.remarks.push_back(
        StrayText(measurement.marks[stray], fit.residuals_mm[stray]));
  }
  MachineMeasurement& report = measurement.report;
  report.set_machine(job.machine().name());
  report.set_pattern_count(static_cast<std::uint32_t>(evidence.plan_mm.size()));
  report.set_measured_count(static_cast<std::uint32_t>(marks.size()));
  report.set_matched_count(static_cast<std::uint32_t>(marks.size() - fit.strays.size()));
  FillDeviations(measurement.marks, report);
  report.set_rms_residual_um(kUmInMm * fit.deviation_mm);
  report.set_rotation_rad(fit.figures[calibrate::kRotation].figure.value);
  FillFigures(fit, before, report);
  for (const std::string& text : measurement.corrected.corrections) {
    report.add_corrections(text);
  }
  for (const std::string& text : measurement.corrected.remarks) report.add_remarks(text);
  return measurement;
}

}  // namespace intaglio::client
