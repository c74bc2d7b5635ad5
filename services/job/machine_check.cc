#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "services/job/field_ranges.h"
#include "services/job/job_check.h"
#include "services/job/machine/focus_offset.h"
#include "services/job/machine/laser_setting.h"
#include "services/job/machine/machine_drives.h"
#include "services/job/machine/stations.h"
#include "services/job/teach/taught_check.h"
#include "services/platform/link/endpoint.h"

namespace intaglio {
namespace {

// What a laser controller's identity can list (services/platform/link/laser_protocol.h).
constexpr int kMaxRates = 32;

// Of proto/machine.proto.
constexpr double kQSwitchDelay_us = 5, kQSwitchWidth_us = 120;
constexpr double kMaxQSwitchDelay_us = 20, kMinQSwitchWidth_us = 100;

void Missing(std::vector<Error>& errors, const std::string& path,
             const std::string& remedy) {
  errors.push_back(
      {ErrorCode::kMissing, fmt::format("{}: is missing; {}", path, remedy), ""});
}

bool IsCellName(const std::string& name) {
  return !name.empty() && std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
           c == '-' || c == '_';
  });
}

void Wrong(std::vector<Error>& errors, const std::string& path, const std::string& what) {
  errors.push_back({ErrorCode::kInvalidValue, fmt::format("{}: {}", path, what), ""});
}

void CheckTravel(const std::string& path, const char* unit, double min, double max,
                 std::vector<Error>& errors) {
  if (min < max) return;
  errors.push_back(
      {ErrorCode::kInvalidValue,
       fmt::format("{0}.travel_min_{1}: {2} is not below {0}.travel_max_{1}, "
                   "{3}",
                   path, unit, min, max),
       fmt::format("{}", min)});
}

void CheckAxis(bool present, const AxisLimits& axis, const std::string& path,
               std::vector<Error>& errors) {
  if (!present)
    return Missing(errors, path, "give the travel and the limits of this axis");
  CheckTravel(path, "mm", axis.travel_min_mm(), axis.travel_max_mm(), errors);
}

void CheckAxis(bool present, const RotaryAxis& axis, const std::string& path,
               std::vector<Error>& errors) {
  if (!present)
    return Missing(errors, path, "give the travel and the limits of this axis");
  CheckTravel(path, "rad", axis.travel_min_rad(), axis.travel_max_rad(), errors);
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

void CheckEnergies(const LaserHead& laser, std::vector<Error>& errors) {
  const auto& points = laser.energy_calibration();
  if (points.empty()) return;
  const std::string path = "laser.energy_calibration";
  if (points.size() < 2) {
    return Missing(errors, path + "[1]", "measure the energy at two settings or more");
  }
  for (int i = 1; i < points.size(); ++i) {
    if (points[i].setting_ratio() > points[i - 1].setting_ratio() &&
        points[i].energy_mj() > points[i - 1].energy_mj()) {
      continue;
    }
    Wrong(errors, fmt::format("{}[{}]", path, i),
          fmt::format("setting {} with {} mJ does not exceed setting {} with {} mJ; "
                      "list the measurements by growing setting, and measure those "
                      "again whose energy does not grow",
                      points[i].setting_ratio(), points[i].energy_mj(),
                      points[i - 1].setting_ratio(), points[i - 1].energy_mj()));
  }
  const double min_mj = points.begin()->energy_mj(),
               max_mj = points.rbegin()->energy_mj();
  if (laser.pulse_energy_mj() < min_mj || laser.pulse_energy_mj() > max_mj) {
    Wrong(errors, "laser.pulse_energy_mj",
          fmt::format("{} is outside the calibrated energies, {}..{}",
                      laser.pulse_energy_mj(), min_mj, max_mj));
  }
}

// By the defaults of what is absent: proto/machine.proto.
void CheckTiming(const LaserHead& laser, std::vector<Error>& errors) {
  const PulseTiming& timing = laser.timing();
  const auto or_default = [](bool present, double us, double default_us) {
    return present ? us : default_us;
  };
  const double delay_us = or_default(timing.has_qswitch_delay_us(),
                                     timing.qswitch_delay_us(), kQSwitchDelay_us);
  const double width_us = or_default(timing.has_qswitch_width_us(),
                                     timing.qswitch_width_us(), kQSwitchWidth_us);
  const double max_us = or_default(timing.has_max_qswitch_delay_us(),
                                   timing.max_qswitch_delay_us(), kMaxQSwitchDelay_us);
  const double min_us = or_default(timing.has_min_qswitch_width_us(),
                                   timing.min_qswitch_width_us(), kMinQSwitchWidth_us);
  if (delay_us > max_us) {
    Wrong(errors, "laser.timing.qswitch_delay_us",
          fmt::format("{} is later than the laser takes a trigger, "
                      "max_qswitch_delay_us, {}; reduce it",
                      delay_us, max_us));
  }
  if (width_us < min_us) {
    Wrong(errors, "laser.timing.qswitch_width_us",
          fmt::format("{} is shorter than the laser needs, min_qswitch_width_us, {}; "
                      "increase it",
                      width_us, min_us));
  }
  const auto fastest = std::ranges::max_element(laser.rates_hz());
  if (fastest == laser.rates_hz().end() || delay_us + width_us < 1e6 / *fastest) return;
  Wrong(errors, "laser.timing.qswitch_width_us",
        fmt::format("a trigger of {} us that begins {} us after the lamp sync lasts "
                    "until the next one at {} Hz; reduce it",
                    width_us, delay_us, *fastest));
}

void CheckPumpEnergy(const LaserHead& laser, std::vector<Error>& errors) {
  if (!laser.has_pump() || laser.pump().energy_j() <= MaxPumpEnergy_j(laser.pump()))
    return;
  Wrong(errors, "laser.pump.energy_j",
        fmt::format("{} is above max_energy_j, {}; reduce it", laser.pump().energy_j(),
                    MaxPumpEnergy_j(laser.pump())));
}

void CheckFlashHeights(const PulseTiming& timing, std::vector<Error>& errors) {
  if (!timing.has_min_flash_height_mm() || !timing.has_max_flash_height_mm() ||
      timing.min_flash_height_mm() <= timing.max_flash_height_mm())
    return;
  Wrong(errors, "laser.timing.min_flash_height_mm",
        fmt::format("{} is above max_flash_height_mm, {}; exchange them",
                    timing.min_flash_height_mm(), timing.max_flash_height_mm()));
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
  // Of a machine that engraves points, where they are required.
  MachineSpec of_marks = machine;
  if (of_marks.repeatability_um() == 0) of_marks.set_repeatability_um(1);
  if (of_marks.position_tolerance_um() == 0) of_marks.set_position_tolerance_um(1);
  CheckRanges(of_marks, "", errors);
  CheckLine(true, machine.mark_line(), "mark_line", errors);
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
  if (!machine.has_laser()) {
    Missing(errors, "laser", "give its rates, energy, wavelength and channels");
  } else if (machine.laser().rates_hz().empty()) {
    Missing(errors, "laser.rates_hz", "give at least one lamp sync rate");
  } else if (machine.laser().rates_hz_size() > kMaxRates) {
    errors.push_back({ErrorCode::kInvalidValue,
                      fmt::format("laser.rates_hz: {} rates are more than {}",
                                  machine.laser().rates_hz_size(), kMaxRates),
                      fmt::format("{}", machine.laser().rates_hz_size())});
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
  CheckEnergies(machine.laser(), errors);
  CheckPumpEnergy(machine.laser(), errors);
  CheckFlashHeights(machine.laser().timing(), errors);
  CheckTiming(machine.laser(), errors);
  CheckChannelPositions(machine, errors);
  CheckLine(machine.has_laser_line(), machine.laser_line(), "laser_line", errors);
  CheckLine(machine.has_motion_line(), machine.motion_line(), "motion_line", errors);
  if (errors.empty()) CheckDrives(machine, errors);
  if (errors.empty()) CheckLoading(machine, errors);
  if (errors.empty()) CheckTaught(machine, errors);
  return errors;
}

}  // namespace intaglio
