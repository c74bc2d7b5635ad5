#include "engrave/drive/drive_kinds.h"

#include <fmt/format.h>

#include <string>

#include "engrave/core/try.h"
#include "engrave/drive/first_order.h"
#include "engrave/drive/linear_drive.h"
#include "engrave/drive/loop_kinds.h"
#include "engrave/drive/second_order.h"

namespace intaglio::drive {
namespace {

constexpr DriveParameter kFirstOrder[] = {{"lag_s", 0, kMaxLagS}};
constexpr DriveParameter kSecondOrder[] = {
    {"natural_frequency_hz", kMinNaturalFrequencyHz, kMaxNaturalFrequencyHz},
    {"damping_ratio", kMinDampingRatio, kMaxDampingRatio}};
constexpr DriveParameter kServo[] = {{"position_gain_per_s", 1, 200000},
                                     {"velocity_time_s", 0.0001, 0.1},
                                     {"derivative_ratio", 0, 100},
                                     {"feed_forward_ratio", 0, 1.5}};
constexpr DriveParameter kCascade[] = {{"position_gain_per_s", 1, 10000},
                                       {"natural_frequency_hz", 1, 10000},
                                       {"damping_ratio", 0.05, 5}};
constexpr DriveParameter kStepperScrew[] = {{"rotor_frequency_hz", 1, 10000},
                                            {"rotor_damping_ratio", 0.05, 5},
                                            {"carriage_frequency_hz", 1, 10000},
                                            {"carriage_damping_ratio", 0.01, 1},
                                            {"inertia_ratio", 0, 20}};
constexpr DriveParameter kPlanar[] = {{"natural_frequency_hz", 1, 10000},
                                      {"damping_ratio", 0.05, 5},
                                      {"integral_rate_per_s", 0.1, 10000}};

using Values = std::span<const double>;
const DriveKind kKinds[] = {
    {"first_order", kFirstOrder,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<FirstOrder>(v[0]);
     }},
    {"second_order", kSecondOrder,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<SecondOrder>(v[0], v[1]);
     }},
    {"servo", kServo,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<LinearDrive>(
           "servo", TransferOf(ServoLoop{v[0], v[1], v[2], v[3]}));
     }},
    {"cascade", kCascade,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<LinearDrive>("cascade",
                                            TransferOf(CascadeLoop{v[0], v[1], v[2]}));
     }},
    {"stepper_screw", kStepperScrew,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<LinearDrive>(
           "stepper_screw", TransferOf(StepperScrewLoop{v[0], v[1], v[2], v[3], v[4]}));
     }},
    {"planar_drive", kPlanar,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<LinearDrive>("planar_drive",
                                            TransferOf(PlanarLoop{v[0], v[1], v[2]}));
     }},
};

Status CheckValues(const DriveKind& kind, Values values) {
  if (values.size() != kind.parameters.size()) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("drive {}: {} values are given, it has {} parameters",
                            kind.name, values.size(), kind.parameters.size()));
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    const DriveParameter& parameter = kind.parameters[i];
    if (values[i] >= parameter.min && values[i] <= parameter.max) continue;
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("drive {}: {} {} is outside {}..{}", kind.name,
                            parameter.name, values[i], parameter.min, parameter.max),
                fmt::format("{}", values[i]));
  }
  return {};
}

}  // namespace

std::span<const DriveKind> DriveKinds() { return kKinds; }

Result<std::shared_ptr<const Drive>> MakeDrive(std::string_view name, Values values) {
  std::string known;
  for (const DriveKind& kind : kKinds) {
    known += (known.empty() ? "" : ", ") + std::string(kind.name);
    if (kind.name != name) continue;
    INTAGLIO_TRY(CheckValues(kind, values));
    return kind.make(values);
  }
  return Fail(ErrorCode::kNotFound,
              fmt::format("drive {}: no such drive; known: {}", name, known),
              std::string(name));
}

}  // namespace intaglio::drive
