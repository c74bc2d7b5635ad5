#include "services/client/machine/corrected_head.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "engrave/optics/focus.h"
#include "services/client/machine/head_figures.h"
#include "services/job/fields/field_ranges.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio::client {
namespace {

using calibrate::CubeFit;
using calibrate::FigureState;

constexpr double kHeadRatioStep = 1e-6, kHeadAngleStep = 1e-6, kCornerStep = 1e-4;
// 0.05 mm in 100 mm: less is not worth a shim.
constexpr double kUprightRad = 5e-4;
constexpr double kFarthestPupilMm = 100000;

double InSteps(double value, double step) { return std::round(value / step) * step; }

class HeadCorrector {
 public:
  HeadCorrector(const FrozenJob& job, const CubeFit& fit)
      : fit_(fit),
        known_(KnownHeadOf(job)),
        wavelength_nm_(job.machine().laser().wavelength_nm()) {
    corrected_.machine = job.machine();
  }

  void Field() {
    HeadOverBlockKinematics& head = *corrected_.machine.mutable_head_over_block();
    const auto set = [&](calibrate::HeadUnknown unknown, const char* field, double step,
                         auto setter) {
      if (!IsFound(unknown)) return;
      const double value = InSteps(Value(unknown), step);
      (head.mutable_field()->*setter)(value);
      Add(fmt::format("head_over_block.field.{}", field), known_[unknown], value);
    };
    set(calibrate::kXScale, "x_scale_ratio", kHeadRatioStep,
        &FieldShape::set_x_scale_ratio);
    set(calibrate::kYScale, "y_scale_ratio", kHeadRatioStep,
        &FieldShape::set_y_scale_ratio);
    set(calibrate::kSquareness, "squareness_xy_rad", kHeadAngleStep,
        &FieldShape::set_squareness_xy_rad);
    set(calibrate::kRotation, "rotation_rad", kHeadAngleStep,
        &FieldShape::set_rotation_rad);
  }

  void Pupils() {
    if (!IsFound(calibrate::kPupilX) && !IsFound(calibrate::kPupilY)) return;
    HeadOverBlockKinematics& head = *corrected_.machine.mutable_head_over_block();
    Pupil(calibrate::kPupilX, "x", [&](double mm) { head.set_pupil_x_mm(mm); });
    Pupil(calibrate::kPupilY, "y", [&](double mm) { head.set_pupil_y_mm(mm); });
  }

  void ZScale() {
    if (!IsFound(calibrate::kZRatio)) return;
    LinearAxis& z = *corrected_.machine.mutable_head_over_block()->mutable_z();
    const double value = InSteps(std::abs(Value(calibrate::kZRatio)), kHeadRatioStep);
    z.set_scale_ratio(value);
    Add("head_over_block.z.scale_ratio", std::abs(known_[calibrate::kZRatio]), value);
  }

  void Origin() {
    Vector3& origin = *corrected_.machine.mutable_block_origin_mm();
    const auto move = [&](calibrate::HeadUnknown unknown, const char* axis, double from,
                          auto set) {
      const double by = Value(unknown) - known_[unknown];
      if (!IsFound(unknown) || std::abs(by) <= fit_.figures[unknown].figure.interval95) {
        return;
      }
      const double to = InSteps(from + by, kCornerStep);
      set(to);
      Add(fmt::format("block_origin_mm.{}", axis), from, to);
    };
    move(calibrate::kOriginX, "x", origin.x(), [&](double v) { origin.set_x(v); });
    move(calibrate::kOriginY, "y", origin.y(), [&](double v) { origin.set_y(v); });
    move(calibrate::kTop, "z", origin.z(), [&](double v) { origin.set_z(v); });
    if (!corrected_.corrections.empty() && corrected_.machine.has_taught() &&
        !corrected_.machine.taught().zeros().empty()) {
      Remark("teach the zeros again: intaglio teach");
    }
  }

  void Tilt(calibrate::HeadUnknown unknown, const char* axis) {
    if (!IsFound(unknown) || std::abs(Value(unknown)) < kUprightRad) return;
    const double rise_mm = 100 * Value(unknown);
    Remark(
        fmt::format("the face of the block rises by {:.3f} mm in 100 mm of {}{}: "
                    "level the stage, or put a shim below its lower side",
                    std::abs(rise_mm), rise_mm > 0 ? "+" : "-", axis));
  }

  void Lean(calibrate::HeadUnknown unknown, const char* axis) {
    if (!IsFound(unknown) || std::abs(Value(unknown)) < kUprightRad) return;
    const double aside_mm = 100 * Value(unknown);
    Remark(
        fmt::format("the beam goes {:.3f} mm to {}{} while z rises by 100 mm: set the "
                    "axis z upright to the beam",
                    std::abs(aside_mm), aside_mm > 0 ? "+" : "-", axis));
  }

  void Index() {
    if (!IsFound(calibrate::kIndex)) return;
    Remark(
        fmt::format("the glass has the index {:.4f} at {:g} nm, and {:.4f} was reckoned "
                    "with: give the job its glass, or measure z with an indicator and "
                    "leave --known out",
                    Value(calibrate::kIndex), wavelength_nm_, known_[calibrate::kIndex]));
  }

  void Undetermined() {
    std::string names;
    for (const HeadFigureName& row : kHeadFigureNames) {
      if (fit_.figures[row.unknown].state != FigureState::kUndetermined) continue;
      names += (names.empty() ? "" : ", ") + std::string(row.name);
    }
    if (names.empty()) return;
    Remark("not determined: " + names +
           ": measure x, y and z of marks at every level and at the corners");
  }

  CorrectedProfile Take() {
    for (const Finding& finding :
         OutOfRange(corrected_.machine.head_over_block(), "head_over_block")) {
      Remark(finding.message + ": correct the machine first, field_mm or steps_per_mm");
    }
    return std::move(corrected_);
  }

 private:
  bool IsFound(calibrate::HeadUnknown unknown) const {
    return fit_.figures[unknown].state == FigureState::kFound;
  }
  double Value(calibrate::HeadUnknown unknown) const {
    return fit_.figures[unknown].figure.value;
  }
  void Add(const std::string& field, double from, double to) {
    corrected_.corrections.push_back(
        fmt::format("{}: {:.10g} -> {:.10g}", field, from, to));
  }
  void Remark(std::string text) { corrected_.remarks.push_back(std::move(text)); }

  /// Profiles have both distances or none.
  template <typename Set>
  void Pupil(calibrate::HeadUnknown unknown, const char* axis, const Set& set) {
    const double known_mm = PupilMm(known_[unknown]);
    const double found_mm = InSteps(PupilMm(Value(unknown)), 0.001);
    set(std::min(found_mm, kFarthestPupilMm));
    if (IsFound(unknown)) {
      Add(fmt::format("head_over_block.pupil_{}_mm", axis), known_mm,
          std::min(found_mm, kFarthestPupilMm));
    }
  }
  static double PupilMm(double per_mm) {
    return per_mm > 1 / kFarthestPupilMm ? 1 / per_mm : kFarthestPupilMm;
  }

  const CubeFit& fit_;
  calibrate::HeadState known_;
  double wavelength_nm_;
  CorrectedProfile corrected_;
};

}  // namespace

calibrate::HeadState KnownHeadOf(const FrozenJob& job) {
  const auto head =
      std::get<machine::ScanHeadOptions>(KinematicsOptionsOf(job.machine()));
  const FieldShape& field = job.machine().head_over_block().field();
  const optics::MachineFromGlass frame = AxesFromGlassOf(job).machine_from_glass();
  calibrate::HeadState known{};
  known[calibrate::kOriginX] = frame.block_origin_mm.x();
  known[calibrate::kOriginY] = frame.block_origin_mm.y();
  known[calibrate::kTop] = frame.top_z_mm();
  const Vec2 scale = FieldScaleOf(field);
  known[calibrate::kXScale] = scale.x();
  known[calibrate::kYScale] = scale.y();
  known[calibrate::kRotation] = field.rotation_rad();
  known[calibrate::kSquareness] = field.squareness_xy_rad();
  known[calibrate::kZRatio] = head.z.per_unit_mm();
  known[calibrate::kPupilX] = 1 / head.lens.pupil_mm.x();
  known[calibrate::kPupilY] = 1 / head.lens.pupil_mm.y();
  known[calibrate::kIndex] = optics::RefractiveIndexOf(
      frame.stage_per_glass_ratio, job.job().lens().numerical_aperture());
  return known;
}

CorrectedProfile CorrectHead(const FrozenJob& job, const CubeFit& fit) {
  HeadCorrector corrector(job, fit);
  corrector.Field();
  corrector.Pupils();
  corrector.ZScale();
  corrector.Origin();
  corrector.Tilt(calibrate::kTiltX, "x");
  corrector.Tilt(calibrate::kTiltY, "y");
  corrector.Lean(calibrate::kLeanX, "x");
  corrector.Lean(calibrate::kLeanY, "y");
  corrector.Index();
  corrector.Undetermined();
  return corrector.Take();
}

}  // namespace intaglio::client
