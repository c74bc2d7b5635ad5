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
#include "services/job/head/field_table.h"
#include "services/job/head/head_correction.h"
#include "services/job/head/point_pulses.h"
#include "services/job/machine/profile_errors.h"

namespace intaglio {
namespace {

// As of the tables that `intaglio galvo calibrate` writes; a spline through them follows
// the ten numbers within a nm.
constexpr int kCorrectionNodes = 65;
// Wider than any field: commands beyond the field are continued.
constexpr double kWidthPerFocal = 1.2;
constexpr double kDefaultCrackRatio = 0.8;
/// motion_line.protocol of a board that adds corrections itself.
constexpr char kBjjczProtocol[] = "bjjcz";

galvo::HeadModel ModelOf(const HeadNumbers& numbers) {
  return galvo::HeadModel::FromNumbers(
      numbers.focal_mm(),
      {numbers.rotation_rad(), numbers.zero_x_rad(), numbers.zero_y_rad(),
       numbers.has_lens_1_ratio() ? numbers.lens_1_ratio() : 1, numbers.lens_3_ratio(),
       numbers.lens_4_ratio(), numbers.offset_x_mm(), numbers.offset_y_mm(),
       numbers.shear_ratio(), numbers.has_axes_ratio() ? numbers.axes_ratio() : 1});
}

Result<galvo::CorrectionTable> TableOf(const HeadNumbers& numbers) {
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

/// Of a file of others: often kinked along the axes.
Result<galvo::CorrectionTable> Bilinear(Result<galvo::FieldGrid> grid) {
  if (!grid) return tl::unexpected(grid.error());
  return galvo::CorrectionTable::Make(*std::move(grid), galvo::Interpolation::kBilinear);
}

Result<galvo::FieldGrid> ReadFileOf(const HeadOverBlockKinematics& head) {
  const bool is_ctb = head.correction_file().ends_with(".ctb");
  if (is_ctb && !head.has_correction_field_mm()) {
    return Fail(ErrorCode::kMissing,
                "a .ctb file does not have the width of its field; give "
                "correction_field_mm");
  }
  return ReadCorrectionFile(head.correction_file(), head.correction_field_mm());
}

Result<galvo::CorrectionTable> TableOf(const HeadOverBlockKinematics& head) {
  if (head.has_correction_table()) return Bilinear(GridOf(head.correction_table()));
  if (!head.correction_file().empty()) return Bilinear(ReadFileOf(head));
  return TableOf(head.correction());
}

const char* FieldOfCorrection(const HeadOverBlockKinematics& head) {
  if (!head.correction_file().empty()) return "correction_file";
  return head.has_correction_table() ? "correction_table" : "correction";
}

/// That one alone corrects the field, and with a table that has an inverse.
void CheckCorrection(const MachineSpec& machine, std::vector<Error>& errors) {
  const HeadOverBlockKinematics& head = machine.head_over_block();
  const bool has_table = !head.correction_file().empty() || head.has_correction_table();
  const std::string field = std::string("head_over_block.") + FieldOfCorrection(head);
  if (head.has_correction_field_mm() && !head.correction_file().ends_with(".ctb")) {
    Wrong(errors, "head_over_block.correction_field_mm",
          "is of a .ctb file, all others have their own scale; remove it");
  }
  if (head.has_correction() && has_table)
    Wrong(errors, field,
          "corrects the field, and so does correction; remove one of them");
  const std::string& of_board = machine.scan_head().correction_file();
  const bool board_corrects = machine.motion_line().protocol() == kBjjczProtocol;
  if (!of_board.empty() && !board_corrects) {
    Wrong(errors, "scan_head.correction_file",
          fmt::format("is loaded into a board of the protocol {}, and the motion line "
                      "has {:?}; give head_over_block.correction_file in its place",
                      kBjjczProtocol, machine.motion_line().protocol()));
  }
  if (!has_table && !head.has_correction()) return;
  if (!of_board.empty() && board_corrects) {
    Wrong(errors, field,
          "corrects the field, and so does the board with scan_head.correction_file; "
          "remove one of them");
  }
  if (!OutOfRange(head, "").empty()) return;
  const auto corrections = CorrectionsOf(head);
  if (!corrections) {
    errors.push_back(corrections.error());
  } else if (const auto inverse = galvo::CommandGrid(**corrections, kCorrectionNodes);
             !inverse) {
    Wrong(errors, field, inverse.error().message);
  }
}

void CheckJumps(const JumpAndDwell& jumps, std::vector<Error>& errors) {
  const std::string path = "head_over_block.jump_and_dwell.";
  if (jumps.z_step_mm() == 0)
    Missing(errors, path + "z_step_mm", "give 0.6 of the crack's length over the index");
  if (jumps.jump_mm_s() == 0) Missing(errors, path + "jump_mm_s", "give the jump speed");
  if (jumps.dwell_s() == 0) Missing(errors, path + "dwell_s", "give the time of a point");
  if (jumps.has_pause_after_points() != jumps.has_pause_s()) {
    Missing(errors, path + (jumps.has_pause_s() ? "pause_after_points" : "pause_s"),
            "give both, or neither for no pauses");
  }
}

}  // namespace

Result<std::shared_ptr<const galvo::CorrectionTable>> CorrectionsOf(
    const HeadOverBlockKinematics& head) {
  if (!head.has_correction() && !head.has_correction_table() &&
      head.correction_file().empty())
    return nullptr;
  auto table = TableOf(head);
  if (!table) {
    Error error = table.error();
    error.message =
        fmt::format("head_over_block.{}: {}", FieldOfCorrection(head), error.message);
    return tl::unexpected(std::move(error));
  }
  return std::make_shared<const galvo::CorrectionTable>(*std::move(table));
}

Status TakeCorrectionFile(MachineSpec& machine) {
  const HeadOverBlockKinematics& head = machine.head_over_block();
  if (head.correction_file().empty() || head.has_correction_table()) return {};
  const auto table = INTAGLIO_TRY(CorrectionsOf(head));
  *machine.mutable_head_over_block()->mutable_correction_table() =
      FieldTableOf(table->grid());
  return {};
}

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
  const auto corrections = CorrectionsOf(head);
  Require(corrections.has_value(), "{}", corrections ? "" : corrections.error().message);
  options.corrections = *corrections;
  return options;
}

sort::JumpTimes JumpTimesOf(const MachineSpec& machine, const LaserOptions& laser) {
  const JumpAndDwell& jumps = machine.head_over_block().jump_and_dwell();
  return {jumps.jump_mm_s(),
          jumps.jump_delay_s(),
          DwellSecondsOf(machine, laser.pulses_per_point()),
          machine.z().max_speed_mm_s(),
          machine.z().max_acceleration_mm_s2(),
          jumps.z_settle_s(),
          machine.laser().max_unsettled_points(),
          jumps.pause_after_points(),
          jumps.pause_s()};
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
  if (!machine.laser().further_wavelengths().empty()) {
    Wrong(errors, "laser.further_wavelengths",
          "the field and the crack energy of a scan head are those of one wavelength; "
          "give each wavelength a profile of its own");
  }
  if (head.has_jump_and_dwell()) CheckJumps(head.jump_and_dwell(), errors);
  CheckCorrection(machine, errors);
}

}  // namespace intaglio
