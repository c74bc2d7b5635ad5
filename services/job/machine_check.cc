#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "services/job/field_ranges.h"
#include "services/job/job_check.h"

namespace intaglio {
namespace {

// What a laser controller's identity can list (services/platform/link/laser_protocol.h).
constexpr int kMaxRates = 32;

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

void CheckAxis(bool present, const AxisLimits& axis, const std::string& path,
               std::vector<Error>& errors) {
  if (!present)
    return Missing(errors, path, "give the travel and the limits of this axis");
  if (axis.travel_min_mm() >= axis.travel_max_mm()) {
    errors.push_back(
        {ErrorCode::kInvalidValue,
         fmt::format("{}.travel_min_mm: {} is not below {}.travel_max_mm, {}", path,
                     axis.travel_min_mm(), path, axis.travel_max_mm()),
         fmt::format("{}", axis.travel_min_mm())});
  }
}

void CheckLenses(const MachineSpec& machine, std::vector<Error>& errors) {
  if (machine.lenses().empty()) Missing(errors, "lenses", "give one lens or more");
  std::set<std::string> names;
  for (int i = 0; i < machine.lenses_size(); ++i) {
    const std::string& name = machine.lenses(i).name();
    const std::string path = fmt::format("lenses[{}].name", i);
    if (name.empty()) {
      Missing(errors, path, "give the lens a name");
    } else if (!names.insert(name).second) {
      errors.push_back(
          {ErrorCode::kInvalidValue,
           fmt::format("{}: \"{}\" is the name of an earlier lens too", path, name),
           name});
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

}  // namespace

std::vector<Error> CheckMachine(const MachineSpec& machine) {
  std::vector<Error> errors;
  if (machine.name().empty()) {
    Missing(errors, "name", "give the machine a name of letters, digits, - and _");
  } else if (!IsCellName(machine.name())) {
    errors.push_back(
        {ErrorCode::kInvalidValue,
         fmt::format("name: \"{}\" has other characters than letters, digits, - "
                     "and _",
                     machine.name()),
         machine.name()});
  }
  CheckRanges(machine, "", errors);
  CheckAxis(machine.has_x(), machine.x(), "x", errors);
  CheckAxis(machine.has_y(), machine.y(), "y", errors);
  CheckAxis(machine.has_z(), machine.z(), "z", errors);
  if (!machine.has_block_origin_mm()) {
    Missing(errors, "block_origin_mm", "say where the block's corner lies");
  }
  if (!machine.has_laser()) {
    Missing(errors, "laser", "give its rates, energy, wavelength and channels");
  } else if (machine.laser().rates_hz().empty()) {
    Missing(errors, "laser.rates_hz", "give one lamp sync rate or more");
  } else if (machine.laser().rates_hz_size() > kMaxRates) {
    errors.push_back({ErrorCode::kInvalidValue,
                      fmt::format("laser.rates_hz: {} rates are more than {}",
                                  machine.laser().rates_hz_size(), kMaxRates),
                      fmt::format("{}", machine.laser().rates_hz_size())});
  }
  CheckLenses(machine, errors);
  CheckLine(machine.has_laser_line(), machine.laser_line(), "laser_line", errors);
  CheckLine(machine.has_motion_line(), machine.motion_line(), "motion_line", errors);
  return errors;
}

}  // namespace intaglio
