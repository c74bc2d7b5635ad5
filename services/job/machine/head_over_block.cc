#include "services/job/machine/head_over_block.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/galvo/head_fit.h"
#include "engrave/machine/scan_head.h"
#include "services/job/fields/field_ranges.h"
#include "services/job/machine/profile_errors.h"

namespace intaglio {
namespace {

// As of the tables that `intaglio galvo calibrate` writes; a spline through them follows
// the ten numbers within a nm.
constexpr int kCorrectionNodes = 65;
// Wider than any field: commands beyond the field are continued.
constexpr double kWidthPerFocal = 1.2;
constexpr double kDefaultCrackRatio = 0.8;

galvo::HeadModel ModelOf(const HeadNumbers& numbers) {
  return galvo::HeadModel::FromNumbers(
      numbers.focal_mm(),
      {numbers.rotation_rad(), numbers.zero_x_rad(), numbers.zero_y_rad(),
       numbers.has_lens_1_ratio() ? numbers.lens_1_ratio() : 1, numbers.lens_3_ratio(),
       numbers.lens_4_ratio(), numbers.offset_x_mm(), numbers.offset_y_mm(),
       numbers.shear_ratio(), numbers.has_axes_ratio() ? numbers.axes_ratio() : 1});
}

Result<galvo::CorrectionTable> CorrectionsOf(const HeadNumbers& numbers) {
  galvo::HeadFit fit;
  fit.model = ModelOf(numbers);
  const double width_mm = kWidthPerFocal * numbers.focal_mm();
  const auto deviations = INTAGLIO_TRY(
      galvo::CorrectionTable::Make(galvo::DeviationsOf(fit, width_mm, kCorrectionNodes),
                                   galvo::Interpolation::kSpline));
  return galvo::CorrectionTable::Make(
      INTAGLIO_TRY(galvo::CommandGrid(deviations, kCorrectionNodes)),
      galvo::Interpolation::kSpline);
}

void CheckJumps(const JumpAndDwell& jumps, std::vector<Error>& errors) {
  const std::string path = "head_over_block.jump_and_dwell.";
  if (jumps.z_step_mm() == 0)
    Missing(errors, path + "z_step_mm", "give 0.6 of the crack's length over the index");
  if (jumps.jump_mm_s() == 0) Missing(errors, path + "jump_mm_s", "give the jump speed");
  if (jumps.dwell_s() == 0) Missing(errors, path + "dwell_s", "give the time of a point");
}

}  // namespace

Vec2 FieldScaleOf(const FieldShape& field) {
  return {field.has_x_scale_ratio() ? field.x_scale_ratio() : 1,
          field.has_y_scale_ratio() ? field.y_scale_ratio() : 1};
}

machine::ScanHeadOptions HeadOptionsOf(const HeadOverBlockKinematics& head) {
  machine::ScanHeadOptions options;
  if (head.has_pupil_x_mm()) options.lens.pupil_mm.x() = head.pupil_x_mm();
  if (head.has_pupil_y_mm()) options.lens.pupil_mm.y() = head.pupil_y_mm();
  options.z_step_mm = head.jump_and_dwell().z_step_mm();
  const FieldShape& field = head.field();
  const Vec2 scale = FieldScaleOf(field);
  options.place_per_field = machine::FieldMatrix(
      scale.x(), scale.y(), field.squareness_xy_rad(), field.rotation_rad());
  if (!head.has_correction()) return options;
  auto corrections = CorrectionsOf(head.correction());
  Require(corrections.has_value(), "head_over_block.correction: {}",
          corrections ? "" : corrections.error().message);
  options.corrections =
      std::make_shared<const galvo::CorrectionTable>(std::move(*corrections));
  return options;
}

sort::JumpTimes JumpTimesOf(const MachineSpec& machine) {
  const JumpAndDwell& jumps = machine.head_over_block().jump_and_dwell();
  return {jumps.jump_mm_s(),
          jumps.jump_delay_s(),
          jumps.dwell_s(),
          machine.z().max_speed_mm_s(),
          machine.z().max_acceleration_mm_s2(),
          jumps.z_settle_s()};
}

double CrackEnergyMj(const MachineSpec& machine) {
  const HeadOverBlockKinematics& head = machine.head_over_block();
  return head.has_crack_energy_mj()
             ? head.crack_energy_mj()
             : kDefaultCrackRatio * machine.laser().pulse_energy_mj();
}

void CheckHeadOverBlock(const MachineSpec& machine, std::vector<Error>& errors) {
  const HeadOverBlockKinematics& head = machine.head_over_block();
  if (head.has_pupil_x_mm() != head.has_pupil_y_mm()) {
    Missing(errors,
            fmt::format("head_over_block.pupil_{}_mm", head.has_pupil_x_mm() ? 'y' : 'x'),
            "give both distances of the pupil, or neither for a telecentric lens");
  }
  if (head.has_crack_energy_mj() && machine.laser().pulse_energy_mj() > 0 &&
      head.crack_energy_mj() > machine.laser().pulse_energy_mj()) {
    Wrong(
        errors, "head_over_block.crack_energy_mj",
        fmt::format("{} is above laser.pulse_energy_mj, {}: no pulse would make a crack",
                    head.crack_energy_mj(), machine.laser().pulse_energy_mj()));
  }
  if (head.has_jump_and_dwell()) CheckJumps(head.jump_and_dwell(), errors);
  if (!head.has_correction() || !OutOfRange(head.correction(), "").empty()) return;
  if (const auto corrections = CorrectionsOf(head.correction()); !corrections) {
    Wrong(errors, "head_over_block.correction", corrections.error().message);
  }
}

}  // namespace intaglio
