#include "services/client/machine/measurement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engrave/calibrate/approach.h"
#include "engrave/calibrate/mark_matching.h"
#include "engrave/core/try.h"
#include "services/client/proof/evidence/proof_evidence.h"
#include "services/job/convert/options.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio::client {
namespace {

constexpr double kUmPerMm = 1000, kUsPerS = 1e6;

/// The marks of the plan, each as it was passed, not measured yet.
Result<std::vector<calibrate::PassedMark>> PlannedMarksOf(const Evidence& evidence) {
  const PointList axes =
      INTAGLIO_TRY(machine::AxesAlong(AxesFromGlassOf(evidence.job), evidence.plan_mm,
                                      AxisLimitsOf(evidence.job.machine()).travel_mm));
  const auto approaches = calibrate::ApproachesOf(MotionOptionsOf(evidence.job), axes);
  const Mat3 focus_per_axis = AxesFromGlassOf(evidence.job).kinematics().ScaleAt(axes[0]);
  std::vector<calibrate::PassedMark> marks(axes.size());
  for (std::size_t i = 0; i < marks.size(); ++i) {
    marks[i].place_mm = evidence.plan_mm[i].head<2>();
    marks[i].speed_mm_s = (focus_per_axis * approaches[i].speed_mm_s).head<2>();
    for (int axis = 0; axis < 2; ++axis) {
      marks[i].direction[axis] =
          approaches[i].direction[axis] * (focus_per_axis(axis, axis) < 0 ? -1 : 1);
    }
  }
  return marks;
}

Result<std::vector<int>> MarkNumbersOf(const MeasuredMarks& measured,
                                       const std::vector<calibrate::PassedMark>& marks) {
  if (measured.numbers.empty()) {
    std::vector<Vec2> places_mm;
    for (const auto& mark : marks) places_mm.push_back(mark.place_mm);
    return calibrate::MatchMarks(places_mm, measured.places_mm);
  }
  for (const int number : measured.numbers) {
    if (number < static_cast<int>(marks.size())) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("mark {} is none of the pattern, which has {}", number + 1,
                            marks.size()));
  }
  return measured.numbers;
}

void SetFigure(MeasuredFigure& to, const calibrate::Figure& from, double unit) {
  to.set_value(unit * from.value);
  to.set_interval95(unit * from.interval95);
}

MeasuredAxis AxisReportOf(const char* name, const calibrate::AxisFigures& figures) {
  MeasuredAxis axis;
  axis.set_axis(name);
  SetFigure(*axis.mutable_scale_ratio(), figures.scale_ratio, 1);
  SetFigure(*axis.mutable_backlash_um(), figures.backlash_mm, kUmPerMm);
  SetFigure(*axis.mutable_lag_us(), figures.lag_s, kUsPerS);
  SetFigure(*axis.mutable_repeatability_um(), figures.repeatability_mm, kUmPerMm);
  axis.set_used_count(static_cast<std::uint32_t>(figures.used_count));
  axis.set_rejected_count(static_cast<std::uint32_t>(figures.rejected_count));
  return axis;
}

void FillDeviations(const Measurement& measurement, MachineMeasurement& report) {
  double square = 0, largest = 0;
  for (std::size_t i = 0; i < measurement.marks.size(); ++i) {
    const double deviation_um = kUmPerMm * measurement.fit.deviations_mm[i].norm();
    square += deviation_um * deviation_um;
    largest = std::max(largest, deviation_um);
  }
  const auto count = static_cast<double>(measurement.marks.size());
  report.set_rms_deviation_um(std::sqrt(square / count));
  report.set_max_deviation_um(largest);
  const auto& [x, y] = measurement.fit.axes;
  report.set_rms_residual_um(
      kUmPerMm * std::hypot(x.repeatability_mm.value, y.repeatability_mm.value));
}

void FillReport(const Measurement& measurement, MachineMeasurement& report) {
  const calibrate::MachineFit& fit = measurement.fit;
  *report.add_axes() = AxisReportOf("x", fit.axes[0]);
  *report.add_axes() = AxisReportOf("y", fit.axes[1]);
  SetFigure(*report.mutable_squareness_xy_rad(), fit.squareness_rad, 1);
  report.set_rotation_rad(fit.rotation_rad);
  report.set_matched_count(static_cast<std::uint32_t>(measurement.marks.size()));
  FillDeviations(measurement, report);
  for (const std::string& text : measurement.corrected.corrections) {
    report.add_corrections(text);
  }
  for (const std::string& text : measurement.corrected.remarks) report.add_remarks(text);
}

}  // namespace

Result<Measurement> MeasureMachine(const Evidence& evidence, const MarksFile& asked) {
  const MachineSpec& machine = evidence.job.machine();
  if (machine.has_head_over_block()) {
    return Fail(
        ErrorCode::kUnsupported,
        machine.name() +
            ": its mirrors tilt the beam, and only three linear axes are measured "
            "by the pattern; measure its test cube, and give the table cube.csv");
  }
  if (machine.has_polar()) {
    return Fail(ErrorCode::kUnsupported,
                machine.name() +
                    ": its axes turn, and only three linear axes are measured by the "
                    "pattern; measure axis_distance_mm and arm_length_mm by hand "
                    "(docs/machines/profile.md)");
  }
  const auto marks = INTAGLIO_TRY(PlannedMarksOf(evidence));
  MarksFile file = asked;
  if (const MachineLens* lens =
          FindLens(machine, evidence.job.job().lens().focal_length_mm());
      file.mark_um <= 0 && lens != nullptr) {
    file.mark_um = kUmPerMm * lens->crack_diameter_mm();
  }
  const MeasuredMarks measured = INTAGLIO_TRY(ReadMarks(file));
  const auto numbers = INTAGLIO_TRY(MarkNumbersOf(measured, marks));
  Measurement measurement;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (numbers[i] < 0) continue;
    measurement.marks.push_back(marks[static_cast<std::size_t>(numbers[i])]);
    measurement.marks.back().measured_mm = measured.places_mm[i];
  }
  auto fit =
      INTAGLIO_TRY(calibrate::FitMachine(measurement.marks, KnownGeometryOf(machine)));
  measurement.fit = std::move(fit);
  measurement.corrected = Correct(machine, measurement.fit);
  measurement.report.set_machine(machine.name());
  measurement.report.set_pattern_count(static_cast<std::uint32_t>(marks.size()));
  measurement.report.set_measured_count(
      static_cast<std::uint32_t>(measured.places_mm.size()));
  FillReport(measurement, measurement.report);
  return measurement;
}

}  // namespace intaglio::client
