#include "services/client/machine/device_comparison.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <poll.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "services/drivers/laser_drivers.h"
#include "services/drivers/profile_check.h"
#include "services/job/checks/stage_speed_check.h"
#include "services/job/machine/laser_setting.h"
#include "services/job/machine/machine_axes.h"
#include "services/job/machine/position_tolerance.h"
#include "services/platform/link/line_session.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;

// A device answers its host's first frame within 50 ms; a slow line takes a few of them.
constexpr auto kAnswerTime = 1s;
constexpr double kNmPerMm = 1e6;
// The devices report travel in nm; a profile is written to 0.1 um at best.
constexpr double kSameTravel = 1e-4;

void Differs(std::vector<Error>& found, const std::string& field,
             const std::string& what) {
  found.push_back({ErrorCode::kInvalidValue, field + ": " + what, ""});
}

void CompareSerial(const SerialLine& line, const std::string& name,
                   const std::string& reported, std::vector<Error>& found) {
  if (!line.has_serial_number() || line.serial_number() == reported) return;
  Differs(found, name + ".serial_number",
          fmt::format("{:?} is expected, the controller on {} reports {:?}; swap the "
                      "cables or correct the field",
                      line.serial_number(), line.device(), reported));
}

/// Reads frames of a line until `complete`, or until the time is up. Why it did not
/// succeed; empty: it did.
std::string ReadLine(const SerialLine& line, const link::SteadyClock& clock,
                     const link::ReliableLink::Handler& handler,
                     const std::function<bool()>& complete) {
  link::LineSession session(link::EndpointOpener(line.device(), line.baud()), clock);
  const auto give_up = clock() + std::chrono::nanoseconds(kAnswerTime);
  while (!complete() && clock() < give_up) {
    session.Poll(handler);
    pollfd wait{session.fd(), POLLIN, 0};
    poll(&wait, wait.fd < 0 ? 0 : 1, 10);
  }
  if (complete()) return {};
  return session.message().empty() ? "the device does not report what it is"
                                   : session.message();
}

void CompareLaserLine(const MachineSpec& machine, const link::SteadyClock& clock,
                      DeviceComparison& comparison) {
  std::optional<link::LaserIdentity> identity;
  link::AccessoryState accessories;
  bool reported = false;
  comparison.not_compared = ReadLine(
      machine.laser_line(), clock,
      [&](std::uint8_t type, std::span<const std::byte> payload) {
        using link::LaserFrame;
        const auto frame = static_cast<LaserFrame>(type);
        if (frame == LaserFrame::kLaserIdentity) {
          if (auto read = link::Decode<link::LaserIdentity>(payload)) identity = *read;
        } else if (frame == LaserFrame::kAccessoryState) {
          if (auto read = link::Decode<link::AccessoryState>(payload))
            accessories = *read;
        } else if (identity) {
          // Outputs and inputs follow the identity at once, when there are any.
          reported = true;
        }
      },
      [&] { return identity && reported; });
  if (!identity) return;
  comparison.not_compared.clear();
  comparison.differences = CompareLaser(machine, *identity, accessories);
}

void CompareMotionLine(const MachineSpec& machine, const link::SteadyClock& clock,
                       DeviceComparison& comparison) {
  std::optional<link::MotionIdentity> identity;
  std::optional<link::StageTolerance> tolerance;
  std::optional<link::StageSpeed> speed;
  bool reported = false;
  comparison.not_compared = ReadLine(
      machine.motion_line(), clock,
      [&](std::uint8_t type, std::span<const std::byte> payload) {
        using link::MotionFrame;
        const auto frame = static_cast<MotionFrame>(type);
        if (frame == MotionFrame::kMotionIdentity) {
          if (auto read = link::Decode<link::MotionIdentity>(payload)) identity = *read;
        } else if (frame == MotionFrame::kStageSpeed) {
          if (auto read = link::Decode<link::StageSpeed>(payload)) speed = *read;
        } else if (frame == MotionFrame::kStageTolerance) {
          if (auto read = link::Decode<link::StageTolerance>(payload)) tolerance = *read;
        } else if (identity) {
          // The tolerance follows the identity at once, when there is one.
          reported = true;
        }
      },
      [&] { return identity && (tolerance || reported); });
  if (!identity) return;
  comparison.not_compared.clear();
  comparison.differences = CompareStage(machine, *identity, tolerance, speed);
}

void CompareAccessories(const MachineSpec& machine, const link::AccessoryState& reported,
                        std::vector<Error>& found) {
  const auto compare = [&found](const std::string& field, std::uint32_t number,
                                std::uint32_t count) {
    if (number <= count) return;
    Differs(found, field,
            fmt::format("{} is above the {} that the laser controller has; connect it to "
                        "another one, or remove it",
                        number, count));
  };
  for (int i = 0; i < machine.outputs_size(); ++i)
    compare(fmt::format("outputs[{}].output", i), machine.outputs(i).output(),
            reported.output_count);
  for (int i = 0; i < machine.inputs_size(); ++i)
    compare(fmt::format("inputs[{}].input", i), machine.inputs(i).input(),
            reported.input_count);
}

void TakeByDriver(Result<std::vector<Error>> differences, DeviceComparison& comparison) {
  if (differences) {
    comparison.differences = std::move(*differences);
  } else {
    comparison.not_compared = differences.error().message;
  }
}

}  // namespace

std::vector<Error> CompareLaser(const MachineSpec& machine,
                                const link::LaserIdentity& reported,
                                const link::AccessoryState& accessories) {
  std::vector<Error> found;
  CompareSerial(machine.laser_line(), "laser_line", reported.serial_number, found);
  if (machine.laser().channels() > reported.channels) {
    Differs(
        found, "laser.channels",
        fmt::format("{} are more than the {} that the controller reports; correct the "
                    "field",
                    machine.laser().channels(), reported.channels));
  }
  for (int i = 0; i < machine.laser().rates_hz_size(); ++i) {
    const double rate_hz = machine.laser().rates_hz(i);
    if (std::ranges::find(reported.rates_hz, rate_hz) != reported.rates_hz.end())
      continue;
    Differs(found, fmt::format("laser.rates_hz[{}]", i),
            fmt::format("{} Hz is no rate of the controller, which reports {}; remove it",
                        rate_hz, fmt::join(reported.rates_hz, " ")));
  }
  if (machine.laser().pulse_energy_mj() > reported.max_energy_mj) {
    Differs(found, "laser.pulse_energy_mj",
            fmt::format("{} mJ are above the {} mJ that the controller can set; reduce "
                        "the field",
                        machine.laser().pulse_energy_mj(), reported.max_energy_mj));
  }
  if (const auto all = EnergiesOf(machine.laser());
      all && all->min_mj < reported.min_energy_mj) {
    Differs(found, "laser.energy_calibration[0].energy_mj",
            fmt::format("{} mJ are below the {} mJ that the controller can set; remove "
                        "the point",
                        all->min_mj, reported.min_energy_mj));
  }
  if (machine.pulse_trigger() == PULSE_TRIGGER_AT_PLACE && !reported.fires_at_place) {
    Differs(found, "pulse_trigger",
            "PULSE_TRIGGER_AT_PLACE is not offered by the laser controller; remove the "
            "field");
  }
  if (machine.laser().door_lock() && !reported.locks_door) {
    Differs(found, "laser.door_lock",
            "the laser controller reports no lock of the door; remove the field, or "
            "connect the lock to the controller");
  }
  CompareAccessories(machine, accessories, found);
  return found;
}

std::vector<Error> CompareStage(const MachineSpec& machine,
                                const link::MotionIdentity& reported,
                                const std::optional<link::StageTolerance>& tolerance,
                                const std::optional<link::StageSpeed>& speed) {
  std::vector<Error> found;
  CompareSerial(machine.motion_line(), "motion_line", reported.serial_number, found);
  const Box3 travel = AxisLimitsOf(machine).travel_mm;
  const auto axes = KinematicsOf(machine)->axes();
  for (int i = 0; i < 3; ++i) {
    const auto& axis = axes[static_cast<std::size_t>(i)];
    const double min = reported.travel_min_nm[i] / kNmPerMm,
                 max = reported.travel_max_nm[i] / kNmPerMm;
    const bool within =
        travel.min_mm[i] >= min - kSameTravel && travel.max_mm[i] <= max + kSameTravel;
    if (within) continue;
    Differs(found, fmt::format("{} travel", axis.name),
            fmt::format("{} to {} {} is beyond the {} to {} that the controller reports; "
                        "reduce travel_min and travel_max to these",
                        travel.min_mm[i], travel.max_mm[i], axis.unit_name(), min, max));
  }
  const std::string tolerances = ToleranceMismatch(
      tolerance ? tolerance->position_nm / 1000.0 : 0, machine.position_tolerance_um());
  if (!tolerances.empty()) Differs(found, "position_tolerance_um", tolerances);
  if (speed) {
    const double unit = reported.velocity_unit_nm_s / kNmPerMm;
    for (const Error& faster : CompareStageSpeed(
             machine, unit * Vec3(speed->x_counts, speed->y_counts, speed->z_counts)))
      found.push_back(faster);
  }
  if (machine.pulse_trigger() == PULSE_TRIGGER_AT_PLACE && !reported.compares_place) {
    Differs(found, "pulse_trigger",
            "PULSE_TRIGGER_AT_PLACE is not offered by the motion controller; remove the "
            "field");
  }
  if (machine.compressed_air() && !reported.watches_air) {
    Differs(found, "compressed_air",
            "the motion controller watches no compressed air; remove the field, or "
            "connect the pressure switch to the controller");
  }
  if (machine.head_over_block().has_block_stage() && !reported.moves_block) {
    Differs(
        found, "head_over_block.block_stage",
        "the motion controller has no stage that carries the block; remove the field, "
        "or connect the stage to the controller");
  }
  return found;
}

std::vector<Error> CheckDriversOf(const MachineSpec& machine) {
  return drivers::CheckDrivers(machine);
}

std::vector<DeviceComparison> CompareDevices(const MachineSpec& machine,
                                             const link::SteadyClock& clock) {
  struct Reader {
    const char* protocol;
    void (*compare)(const MachineSpec&, const link::SteadyClock&, DeviceComparison&);
  };
  constexpr Reader kReaders[] = {{"virtual-laser", CompareLaserLine},
                                 {"virtual-stage", CompareMotionLine}};
  if (machine.has_mark_line()) {
    DeviceComparison marks{"mark_line", {}, {}};
    TakeByDriver(drivers::CompareMarkController(machine, clock), marks);
    return {marks};
  }
  std::vector<DeviceComparison> all = {{"laser_line", {}, {}}, {"motion_line", {}, {}}};
  for (DeviceComparison& comparison : all) {
    const SerialLine& line =
        comparison.line == "laser_line" ? machine.laser_line() : machine.motion_line();
    const auto* reader = std::ranges::find_if(
        kReaders, [&](const Reader& r) { return line.protocol() == r.protocol; });
    const bool output = line.protocol() == drivers::kMotionOutput;
    if (line.device().empty() && !output) {
      comparison.not_compared = "the profile has no device for it";
    } else if (output) {
      comparison.not_compared = "it is an output of the motion controller";
    } else if (reader == std::end(kReaders)) {
      TakeByDriver(drivers::CompareMotionController(machine, clock), comparison);
    } else {
      reader->compare(machine, clock, comparison);
    }
  }
  return all;
}

}  // namespace intaglio::client
