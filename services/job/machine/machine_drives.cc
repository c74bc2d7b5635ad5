#include "services/job/machine/machine_drives.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "engrave/core/check.h"
#include "services/job/machine/machine_defaults.h"
#include "services/platform/fields/field_rules.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

/// Reads the oneof `drive`: its number is a lag, its messages have the names of their
/// kinds and the parameters of these in their order.
drive::DriveParameters ParametersOf(const pb::Message& of,
                                    const pb::FieldDescriptor& field) {
  const pb::Reflection& reflection = *of.GetReflection();
  if (field.message_type() == nullptr)
    return {"first_order", {reflection.GetDouble(of, &field)}};
  drive::DriveParameters parameters{field.name(), {}};
  const pb::Message& message = reflection.GetMessage(of, &field);
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    parameters.values.push_back(
        message.GetReflection()->GetDouble(message, message.GetDescriptor()->field(i)));
  }
  return parameters;
}

std::array<std::string, 3> AxisNamesOf(const MachineSpec& machine) {
  if (machine.has_polar()) return {"arm", "table", "z"};
  return {"x", "y", "z"};
}

template <typename Make>
drive::AxisDrives DrivesBy(const MachineSpec& machine, const Make& make) {
  const auto parameters = DriveParametersOf(machine);
  drive::AxisDrives drives;
  for (std::size_t i = 0; i < drives.size(); ++i) {
    // Axes that are driven alike share their drive.
    const bool as_before = i > 0 && parameters[i].name == parameters[i - 1].name &&
                           parameters[i].values == parameters[i - 1].values;
    if (as_before) {
      drives[i] = drives[i - 1];
      continue;
    }
    auto made = make(parameters[i]);
    Require(made.has_value(), "the machine was not checked: {}",
            made ? "" : made.error().message);
    drives[i] = *made;
  }
  return drives;
}

void CheckDrive(const pb::Message& of, const std::string& path,
                std::vector<Error>& errors) {
  const pb::FieldDescriptor* field = ChosenField(of, "drive");
  if (field == nullptr) return;
  const drive::DriveParameters drive = ParametersOf(of, *field);
  const auto made = drive::MakeDrive(drive.name, drive.values);
  if (made) return;
  errors.push_back(made.error());
  errors.back().message =
      fmt::format("{}{}: {}", path, field->name(), made.error().message);
}

}  // namespace

std::array<drive::DriveParameters, 3> DriveParametersOf(const MachineSpec& machine) {
  const pb::FieldDescriptor* of_all = ChosenField(machine, "drive");
  std::array<drive::DriveParameters, 3> parameters;
  parameters.fill(of_all == nullptr ? drive::DriveParameters{"first_order", {0}}
                                    : ParametersOf(machine, *of_all));
  const auto names = AxisNamesOf(machine);
  for (const AxisDrive& drive : machine.axis_drives()) {
    const auto* field = ChosenField(drive, "drive");
    const auto name = std::ranges::find(names, drive.axis());
    Require(field != nullptr && name != names.end(), "the machine was not checked: {}",
            drive.axis());
    parameters[static_cast<std::size_t>(name - names.begin())] =
        ParametersOf(drive, *field);
  }
  return parameters;
}

drive::AxisDrives DrivesOf(const MachineSpec& machine) {
  return DrivesBy(machine, [](const drive::DriveParameters& of) {
    return drive::MakeDrive(of.name, of.values);
  });
}

drive::AxisDrives DrivesWith(const drive::MechanicsRatios& ratios,
                             const MachineSpec& machine) {
  return DrivesBy(machine, [&](const drive::DriveParameters& of) {
    return drive::MakeDriveWith(ratios, of);
  });
}

std::array<drive::MechanicsRatios, 4> WrongMechanics() {
  return {{{0.95, 1}, {1.05, 1}, {1, 0.8}, {1, 1.2}}};
}

void CheckDrives(const MachineSpec& given, std::vector<Error>& errors) {
  const MachineSpec machine = WithMachineDefaults(given);
  CheckDrive(machine, "", errors);
  const auto names = AxisNamesOf(machine);
  std::set<std::string> seen;
  for (int i = 0; i < machine.axis_drives_size(); ++i) {
    const AxisDrive& drive = machine.axis_drives(i);
    const std::string path = fmt::format("axis_drives[{}].", i);
    if (std::ranges::find(names, drive.axis()) == names.end()) {
      errors.push_back(
          {ErrorCode::kInvalidValue,
           fmt::format("{}axis: {:?} is no axis of this machine; give one of "
                       "{}",
                       path, drive.axis(), fmt::join(names, ", ")),
           drive.axis()});
    } else if (!seen.insert(drive.axis()).second) {
      errors.push_back(
          {ErrorCode::kInvalidValue,
           fmt::format("{}axis: {} occurs twice; remove one", path, drive.axis()),
           drive.axis()});
    }
    if (ChosenField(drive, "drive") == nullptr) {
      errors.push_back(
          {ErrorCode::kMissing,
           fmt::format("{}drive: is missing; give stage_lag_s, second_order, "
                       "servo, cascade, stepper_screw or planar_drive",
                       path),
           ""});
    }
    CheckDrive(drive, path, errors);
  }
}

}  // namespace intaglio
