#include "engrave/drive/drive_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "engrave/core/counted.h"
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
                                      {"integral_rate_per_s", 0.1, 10000},
                                      {"period_s", 0.00001, 0.01}};

using Values = std::span<const double>;

PlanarLoop PlanarOf(Values v) { return {v[0], v[1], v[2], v[3]}; }

Status CheckPlanar(Values v) {
  const double longest_s = LongestPeriodS(PlanarOf(v)) / kStabilityReserveRatio;
  if (v[3] <= longest_s) return {};
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("drive planar_drive: period_s {} is too long for the loop to be "
                  "stable; at most {:.4g}, or lower natural_frequency_hz",
                  v[3], longest_s),
      fmt::format("{}", v[3]));
}

using Ratios = MechanicsRatios;
void VaryLag(std::span<double> v, const Ratios& by) { v[0] /= by.frequency; }
void VarySecondOrder(std::span<double> v, const Ratios& by) {
  v[0] *= by.frequency;
  v[1] *= by.damping;
}
// K / tau is the square of its frequency, K tau falls with that of its damping.
void VaryServo(std::span<double> v, const Ratios& by) {
  v[0] *= by.frequency / by.damping;
  v[1] /= by.frequency * by.damping;
}
void VaryCascade(std::span<double> v, const Ratios& by) {
  VarySecondOrder(v.subspan(1), by);
}
void VaryStepperScrew(std::span<double> v, const Ratios& by) {
  VarySecondOrder(v, by);
  VarySecondOrder(v.subspan(2), by);
}
const DriveKind kKinds[] = {
    {"first_order", kFirstOrder,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<FirstOrder>(v[0]);
     },
     VaryLag},
    {"second_order", kSecondOrder,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<SecondOrder>(v[0], v[1]);
     },
     VarySecondOrder},
    {"servo", kServo,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<LinearDrive>(
           "servo", TransferOf(ServoLoop{v[0], v[1], v[2], v[3]}));
     },
     VaryServo},
    {"cascade", kCascade,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<LinearDrive>("cascade",
                                            TransferOf(CascadeLoop{v[0], v[1], v[2]}));
     },
     VaryCascade},
    {"stepper_screw", kStepperScrew,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<LinearDrive>(
           "stepper_screw", TransferOf(StepperScrewLoop{v[0], v[1], v[2], v[3], v[4]}));
     },
     VaryStepperScrew},
    {"planar_drive", kPlanar,
     [](Values v) -> std::shared_ptr<const Drive> {
       return std::make_shared<LinearDrive>("planar_drive", TransferOf(PlanarOf(v)));
     },
     VarySecondOrder, CheckPlanar},
};

Status CheckValues(const DriveKind& kind, Values values) {
  if (values.size() != kind.parameters.size()) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("drive {}: {} {} given, it has {}", kind.name,
                            Counted(values.size(), "value"), IsOrAre(values.size()),
                            Counted(kind.parameters.size(), "parameter")));
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

namespace {

Result<const DriveKind*> KindOf(std::string_view name) {
  std::string known;
  for (const DriveKind& kind : kKinds) {
    known += (known.empty() ? "" : ", ") + std::string(kind.name);
    if (kind.name == name) return &kind;
  }
  return Fail(ErrorCode::kNotFound,
              fmt::format("drive {}: no such drive; known: {}", name, known),
              std::string(name));
}

}  // namespace

Result<std::shared_ptr<const Drive>> MakeDrive(std::string_view name, Values values) {
  const DriveKind* kind = INTAGLIO_TRY(KindOf(name));
  INTAGLIO_TRY(CheckValues(*kind, values));
  if (kind->check != nullptr) INTAGLIO_TRY(kind->check(values));
  return kind->make(values);
}

Result<std::shared_ptr<const Drive>> MakeDriveWith(const MechanicsRatios& ratios,
                                                   const DriveParameters& drive) {
  const DriveKind* kind = INTAGLIO_TRY(KindOf(drive.name));
  INTAGLIO_TRY(CheckValues(*kind, drive.values));
  std::vector<double> values = drive.values;
  kind->vary(values, ratios);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const DriveParameter& parameter = kind->parameters[i];
    values[i] = std::clamp(values[i], parameter.min, parameter.max);
  }
  return kind->make(values);
}

}  // namespace intaglio::drive
