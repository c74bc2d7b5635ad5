#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "engrave/optics/pulse_focus.h"
#include "services/job/checks/accessory_check.h"
#include "services/job/checks/axis_check.h"
#include "services/job/checks/block_place_check.h"
#include "services/job/checks/head_check.h"
#include "services/job/checks/job_check.h"
#include "services/job/checks/laser_head_check.h"
#include "services/job/checks/taught_check.h"
#include "services/job/fields/field_ranges.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/head_over_block.h"
#include "services/job/machine/machine_drives.h"
#include "services/job/machine/position_tolerance.h"
#include "services/job/machine/profile_errors.h"
#include "services/job/machine/stations.h"
#include "services/platform/fields/field_rules.h"
#include "services/platform/link/endpoint.h"

namespace intaglio {
namespace {

bool IsCellName(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           c == '-' || c == '_';
  });
}

// Numbers pass the readers of files.
void CheckLinearAxis(const LinearAxis& axis, const std::string& path,
                     std::vector<Error>& errors) {
  if (AxisMoves_IsValid(axis.moves())) return;
  Wrong(errors, path + ".moves",
        fmt::format("{} is neither AXIS_MOVES_HEAD nor AXIS_MOVES_TABLE",
                    static_cast<int>(axis.moves())));
}

void CheckCartesian(const MachineSpec& machine, std::vector<Error>& errors) {
  CheckAxis(machine.has_x(), machine.x(), "x", errors);
  CheckAxis(machine.has_y(), machine.y(), "y", errors);
  CheckLinearAxis(machine.cartesian().x(), "cartesian.x", errors);
  CheckLinearAxis(machine.cartesian().y(), "cartesian.y", errors);
  CheckLinearAxis(machine.cartesian().z(), "cartesian.z", errors);
}

void CheckPolar(const MachineSpec& machine, std::vector<Error>& errors) {
  const PolarKinematics& polar = machine.polar();
  CheckAxis(polar.has_arm(), polar.arm(), "polar.arm", errors);
  CheckAxis(polar.has_table(), polar.table(), "polar.table", errors);
  CheckLinearAxis(polar.z(), "polar.z", errors);
  if (!ArmSide_IsValid(polar.side())) {
    Wrong(errors, "polar.side",
          fmt::format("{} is neither ARM_SIDE_LEFT nor ARM_SIDE_RIGHT",
                      static_cast<int>(polar.side())));
  }
  for (const char* field :
       {"x", "y", "max_speed_norm_mm_s", "max_acceleration_norm_mm_s2"}) {
    const auto* descriptor = MachineSpec::descriptor()->FindFieldByName(field);
    if (!machine.GetReflection()->HasField(machine, descriptor)) continue;
    Wrong(errors, field,
          "is of linear axes, a polar machine has polar.arm and polar.table; remove it");
  }
}

// A beam that is wider than the lens can focus is a mistake of one of the three.
void CheckAperture(const MachineSpec& machine, int i, std::vector<Error>& errors) {
  const MachineLens& lens = machine.lenses(i);
  if (lens.has_numerical_aperture()) return;
  const std::string path = fmt::format("lenses[{}].numerical_aperture", i);
  const double beam_mm = machine.laser().beam_diameter_mm();
  if (beam_mm <= 0 || lens.focal_length_mm() <= 0) {
    return Missing(errors, path, "give it, or laser.beam_diameter_mm");
  }
  const double aperture = optics::ApertureOfBeam(beam_mm, lens.focal_length_mm());
  const NumberRange range =
      RangeOf<MachineLens>(MachineLens::kNumericalApertureFieldNumber);
  if (aperture >= range.min && aperture <= range.max) return;
  Wrong(
      errors, path,
      fmt::format("{} by laser.beam_diameter_mm, {}, and focal_length_mm, {}, is outside "
                  "{}..{}; correct these",
                  aperture, beam_mm, lens.focal_length_mm(), range.min, range.max));
}

void CheckLenses(const MachineSpec& machine, std::vector<Error>& errors) {
  if (machine.lenses().empty()) Missing(errors, "lenses", "give at least one lens");
  std::set<std::string> names;
  for (int i = 0; i < machine.lenses_size(); ++i) {
    const std::string& name = machine.lenses(i).name();
    const std::string path = fmt::format("lenses[{}].name", i);
    if (name.empty()) {
      Missing(errors, path, "give the lens a name");
    } else if (!names.insert(name).second) {
      errors.push_back(
          {ErrorCode::kInvalidValue,
           fmt::format("{}: \"{}\" is already the name of an earlier lens", path, name),
           name});
    }
    CheckAperture(machine, i, errors);
  }
}

void CheckLensName(const MachineSpec& machine, const std::string& path,
                   const std::string& name, std::vector<Error>& errors) {
  if (name.empty() || FindLensNamed(machine, name) != nullptr) return;
  std::vector<std::string> names;
  for (const MachineLens& lens : machine.lenses()) names.push_back(lens.name());
  Wrong(errors, path,
        fmt::format("{:?} is no lens of this machine; give one of {}", name,
                    fmt::join(names, ", ")));
}

void CheckChannelPositions(const MachineSpec& machine, std::vector<Error>& errors) {
  std::set<std::uint32_t> seen;
  for (int i = 0; i < machine.channel_positions_size(); ++i) {
    const ChannelPosition& position = machine.channel_positions(i);
    const std::string path = fmt::format("channel_positions[{}]", i);
    if (!position.has_offset_mm()) {
      Missing(errors, path + ".offset_mm", "give where its beam meets");
    }
    if (position.channel() > machine.laser().channels()) {
      Wrong(errors, path + ".channel",
            fmt::format("{} is above laser.channels, {}", position.channel(),
                        machine.laser().channels()));
    } else if (!seen.insert(position.channel()).second) {
      Wrong(errors, path + ".channel",
            fmt::format("{} occurs twice; remove one", position.channel()));
    }
  }
}

// What a controller's identity can report (services/platform/link/laser_protocol.h).
bool IsSerialNumber(const std::string& text) {
  return !text.empty() && text.size() <= 64 &&
         std::all_of(text.begin(), text.end(),
                     [](char c) { return c >= ' ' && c <= '~'; });
}

void CheckLine(bool present, const SerialLine& line, const std::string& path,
               std::vector<Error>& errors) {
  if (!present || line.protocol().empty()) {
    Missing(errors, path + ".protocol", "name the driver, e.g. \"virtual-laser\"");
  }
  // None yet: --device of the program at the machine gives it.
  if (!line.device().empty()) {
    if (const auto good = link::CheckDevice(line.device()); !good) {
      errors.push_back({ErrorCode::kInvalidValue,
                        fmt::format("{}.device: {}", path, good.error().message),
                        line.device()});
    }
  }
  if (line.has_serial_number() && !IsSerialNumber(line.serial_number())) {
    errors.push_back(
        {ErrorCode::kInvalidValue,
         fmt::format("{}.serial_number: {:?} is not 1 to 64 printable ASCII characters; "
                     "give what the controller reports, or remove the line to accept any "
                     "controller",
                     path, line.serial_number()),
         line.serial_number()});
  }
}

void AddKinematics(const MachineSpec& machine, std::vector<Error>& errors) {
  if (machine.has_polar()) {
    CheckPolar(machine, errors);
  } else {
    CheckCartesian(machine, errors);
  }
  if (machine.has_head_over_block()) {
    CheckLinearAxis(machine.head_over_block().z(), "head_over_block.z", errors);
    CheckHeadOverBlock(machine, errors);
    CheckBlockStage(machine, errors);
  }
  CheckAxis(machine.has_z(), machine.z(), "z", errors);
}

void CheckNameOf(const MachineSpec& machine, std::vector<Error>& errors) {
  if (machine.name().empty()) {
    Missing(errors, "name", "give the machine a name of letters, digits, - and _");
  } else if (!IsCellName(machine.name())) {
    errors.push_back(
        {ErrorCode::kInvalidValue,
         fmt::format("name: \"{}\" has characters other than letters, digits, - and _",
                     machine.name()),
         machine.name()});
  }
}

// What its driver needs, the driver checks when it is made.
std::vector<Error> CheckMarkingMachine(const MachineSpec& machine) {
  std::vector<Error> errors;
  CheckNameOf(machine, errors);
  // They are required of a machine that engraves points.
  MachineSpec of_marks = machine;
  if (of_marks.repeatability_um() == 0) of_marks.set_repeatability_um(1);
  if (of_marks.position_tolerance_um() == 0) of_marks.set_position_tolerance_um(1);
  CheckRanges(of_marks, "", errors);
  CheckLine(true, machine.mark_line(), "mark_line", errors);
  CheckAccessories(machine, errors);
  for (const char* field : {"laser_line", "motion_line"}) {
    const auto* descriptor = MachineSpec::descriptor()->FindFieldByName(field);
    if (!machine.GetReflection()->HasField(machine, descriptor)) continue;
    Wrong(errors, field,
          "is of a machine that engraves points, and mark_line is given: the one "
          "controller of a machine that marks is on mark_line; remove one of them");
  }
  return errors;
}

}  // namespace

std::vector<Error> CheckKinematics(const MachineSpec& machine) {
  std::vector<Error> errors;
  if (machine.has_polar()) CheckRanges(machine.polar(), "polar", errors);
  if (machine.has_head_over_block())
    CheckRanges(machine.head_over_block(), "head_over_block", errors);
  AddKinematics(machine, errors);
  return errors;
}

std::vector<Error> CheckMachine(const MachineSpec& machine) {
  if (machine.has_mark_line()) return CheckMarkingMachine(machine);
  std::vector<Error> errors;
  CheckNameOf(machine, errors);
  CheckRanges(machine, "", errors);
  AddKinematics(machine, errors);
  if (!machine.has_block_origin_mm()) {
    Missing(errors, "block_origin_mm", "give the position of the block's corner");
  }
  if (machine.has_laser()) {
    CheckLaserHead(machine.laser(), errors);
  } else {
    Missing(errors, "laser", "give its rates, energy, wavelength and channels");
  }
  if (!PulseTriggerKind_IsValid(machine.pulse_trigger())) {
    errors.push_back(
        {ErrorCode::kInvalidValue,
         fmt::format("pulse_trigger: {} is no trigger; give PULSE_TRIGGER_AT_TICK or "
                     "PULSE_TRIGGER_AT_PLACE",
                     static_cast<int>(machine.pulse_trigger())),
         fmt::format("{}", static_cast<int>(machine.pulse_trigger()))});
  }
  CheckLenses(machine, errors);
  CheckLensName(machine, "mounted_lens", machine.mounted_lens(), errors);
  CheckLensName(machine, "zero_lens", machine.zero_lens(), errors);
  CheckChannelPositions(machine, errors);
  CheckLine(machine.has_laser_line(), machine.laser_line(), "laser_line", errors);
  CheckLine(machine.has_motion_line(), machine.motion_line(), "motion_line", errors);
  CheckAccessories(machine, errors);
  if (errors.empty()) CheckDrives(machine, errors);
  if (errors.empty()) CheckSteps(machine, errors);
  if (errors.empty()) CheckLoading(machine, errors);
  if (errors.empty()) CheckTaught(machine, errors);
  if (errors.empty()) CheckHead(machine, errors);
  return errors;
}

}  // namespace intaglio
