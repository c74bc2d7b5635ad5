#include "services/drivers/linuxcnc/hal_limits.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <filesystem>
#include <optional>

#include "engrave/core/try.h"
#include "engrave/io/whole_file.h"
#include "services/drivers/linuxcnc/hal_folder.h"
#include "services/job/plan/course_motion.h"

namespace intaglio::drivers {
namespace {

constexpr std::size_t kMaxHalFile = 1 << 20;
// The shortest tick, in servo periods (linuxcnc_driver.h).
constexpr double kMinPeriods = 2;

using Pins = std::map<std::string, double>;

std::string_view NextToken(std::string_view& line) {
  const auto begin = line.find_first_not_of(" \t\r");
  if (begin == std::string_view::npos) return line = {};
  const auto end = std::min(line.find_first_of(" \t\r", begin), line.size());
  const std::string_view text = line.substr(begin, end - begin);
  line.remove_prefix(end);
  return text;
}

void DiffersFromHal(std::vector<Error>& errors, const std::string& field,
                    const std::string& what) {
  errors.push_back({ErrorCode::kInvalidValue, field + ": " + what, ""});
}

std::optional<double> ValueOfPin(const Pins& pins, const std::string& pin) {
  const auto found = pins.find(pin);
  return found == pins.end() ? std::nullopt : std::optional(found->second);
}

void CompareHalAxis(const std::string& name, const AxisLimits& axis, const Pins& pins,
                    std::vector<Error>& errors) {
  const auto limit = [&](const char* what) {
    return ValueOfPin(pins, name + "-limit." + what);
  };
  const auto min = limit("min"), max = limit("max"), speed = limit("maxv"),
             acceleration = limit("maxa");
  if (min && axis.travel_min_mm() < *min) {
    DiffersFromHal(
        errors, name + ".travel_min_mm",
        fmt::format("{} is beyond {}-limit.min, {:g}; raise it to that, or set the pin",
                    axis.travel_min_mm(), name, *min));
  }
  if (max && axis.travel_max_mm() > *max) {
    DiffersFromHal(
        errors, name + ".travel_max_mm",
        fmt::format("{} is beyond {}-limit.max, {:g}; reduce it to that, or set the pin",
                    axis.travel_max_mm(), name, *max));
  }
  if (speed && axis.max_speed_mm_s() >= *speed) {
    DiffersFromHal(
        errors, name + ".max_speed_mm_s",
        fmt::format("{} is not below {}-limit.maxv, {:g}, which would shape what is "
                    "planned; reduce it, or set the pin to twice the field",
                    axis.max_speed_mm_s(), name, *speed));
  }
  if (acceleration && axis.max_acceleration_mm_s2() >= *acceleration) {
    DiffersFromHal(
        errors, name + ".max_acceleration_mm_s2",
        fmt::format("{} is not below {}-limit.maxa, {:g}, which would shape what is "
                    "planned; reduce it, or set the pin to four times the field",
                    axis.max_acceleration_mm_s2(), name, *acceleration));
  }
}

void CompareNear(const std::string& name, double tolerance_um, const Pins& pins,
                 std::vector<Error>& errors) {
  const auto near_mm = ValueOfPin(pins, name + "-near.difference");
  if (near_mm && std::abs(*near_mm * 1000 - tolerance_um) > 0.01 * tolerance_um) {
    DiffersFromHal(
        errors, "position_tolerance_um",
        fmt::format("{} is not {}-near.difference, {:g} mm; make both the same",
                    tolerance_um, name, *near_mm));
  }
}

void CompareLag(const std::string& name, double lag_mm, const Pins& pins,
                std::vector<Error>& errors) {
  const auto near_mm = ValueOfPin(pins, name + "-near.difference");
  if (!near_mm || *near_mm > lag_mm) return;
  DiffersFromHal(
      errors, name + ".max_speed_mm_s",
      fmt::format("the axis is {:.3f} mm behind its row there by the drive of the "
                  "profile, and {}-near.difference, {:g} mm, ends the beam; set the pin "
                  "to twice that",
                  lag_mm, name, *near_mm));
}

void CompareHalSerial(const std::string& name, const SerialLine& line,
                      const HalIdentity& identity, std::vector<Error>& errors) {
  if (!line.has_serial_number() || line.serial_number() == identity.serial_number) return;
  DiffersFromHal(
      errors, name + ".serial_number",
      fmt::format("{:?} is expected, the HAL in {} reports {:?}; correct the device "
                  "or the field",
                  line.serial_number(), line.device(), identity.serial_number));
}

struct HalFiles {
  HalIdentity identity;
  Pins pins;
};

Result<HalFiles> ReadHalFiles(const std::string& name, const SerialLine& line) {
  const std::filesystem::path folder = line.device();
  const HalIdentity identity = INTAGLIO_TRY(ReadHalIdentity(folder, name));
  const auto hal = INTAGLIO_TRY(io::ReadWholeFile(folder / "machine.hal", kMaxHalFile));
  return HalFiles{identity, ParseHalPins(hal)};
}

void CompareRates(const LaserHead& laser, const HalIdentity& identity,
                  std::vector<Error>& errors) {
  const double servo_hz = 1e9 / identity.period_ns;
  for (int i = 0; i < laser.rates_hz_size(); ++i) {
    const double periods = servo_hz / laser.rates_hz(i), whole = std::round(periods);
    if (whole >= kMinPeriods && std::abs(periods - whole) <= 1e-6 * whole) continue;
    DiffersFromHal(
        errors, fmt::format("laser.rates_hz[{}]", i),
        fmt::format("{} Hz is not the servo rate, {:g} Hz, divided by a whole number "
                    "from 2 on; remove it",
                    laser.rates_hz(i), servo_hz));
  }
}

}  // namespace

Pins ParseHalPins(std::string_view text) {
  Pins pins;
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (NextToken(line) != "setp") continue;
    const std::string_view pin = NextToken(line), number = NextToken(line);
    double value = 0;
    const auto read =
        std::from_chars(number.data(), number.data() + number.size(), value);
    const bool whole = read.ec == std::errc() && !number.empty() &&
                       read.ptr == number.data() + number.size();
    if (whole && std::isfinite(value)) pins[std::string(pin)] = value;
  }
  return pins;
}

std::vector<Error> CheckLinuxcncProfile(const MachineSpec& machine) {
  std::vector<Error> errors;
  if (machine.laser().has_timing()) {
    DiffersFromHal(
        errors, "laser.timing",
        "under LinuxCNC a pulse is one servo period long, without a lamp sync; remove "
        "it");
  }
  if (machine.laser().channels() > 1) {
    DiffersFromHal(
        errors, "laser.channels",
        fmt::format("{} are more than the one laser output of the HAL files; give 1",
                    machine.laser().channels()));
  }
  if (machine.pulse_trigger() == PULSE_TRIGGER_AT_PLACE) {
    DiffersFromHal(
        errors, "pulse_trigger",
        "PULSE_TRIGGER_AT_PLACE is not offered by the driver; remove the field");
  }
  return errors;
}

std::vector<Error> CompareHal(const MachineSpec& machine, const HalIdentity& identity,
                              const Pins& pins) {
  std::vector<Error> errors;
  CompareHalSerial("motion_line", machine.motion_line(), identity, errors);
  CompareRates(machine.laser(), identity, errors);
  const std::pair<const char*, const AxisLimits*> axes[] = {
      {"x", &machine.x()}, {"y", &machine.y()}, {"z", &machine.z()}};
  for (const auto& [name, axis] : axes) {
    CompareHalAxis(name, *axis, pins, errors);
    CompareNear(name, machine.position_tolerance_um(), pins, errors);
  }
  const auto warm_up_s = ValueOfPin(pins, "lamp-delay.on-delay");
  if (warm_up_s && machine.laser().warm_up_s() < *warm_up_s) {
    DiffersFromHal(errors, "laser.warm_up_s",
                   fmt::format("{} s is less than lamp-delay.on-delay, {:g} s; raise it",
                               machine.laser().warm_up_s(), *warm_up_s));
  }
  return errors;
}

Result<std::vector<Error>> CompareLinuxcnc(const MachineSpec& machine,
                                           const link::StreamOpener&,
                                           const link::SteadyClock&) {
  const HalFiles hal = INTAGLIO_TRY(ReadHalFiles("motion_line", machine.motion_line()));
  return CompareHal(machine, hal.identity, hal.pins);
}

std::vector<Error> CompareBeamHal(const MachineSpec& machine, const HalIdentity& identity,
                                  const Pins& pins) {
  std::vector<Error> errors;
  CompareHalSerial("mark_line", machine.mark_line(), identity, errors);
  if (identity.laser != HalLaser::kBeam) {
    DiffersFromHal(
        errors, "mark_line.protocol",
        fmt::format("{} is of a beam, and the HAL in {} was started without "
                    "--beam; start it again with it",
                    machine.mark_line().protocol(), machine.mark_line().device()));
  }
  CompareHalAxis("x", machine.x(), pins, errors);
  CompareHalAxis("y", machine.y(), pins, errors);
  const auto axes = CourseAxesOf(machine);
  if (!axes) return errors;
  CompareLag("x", (*axes)[0].lag_s() * CourseFeedOf(machine), pins, errors);
  CompareLag("y", (*axes)[1].lag_s() * CourseFeedOf(machine), pins, errors);
  return errors;
}

Result<std::vector<Error>> CompareLinuxcncCourse(const MachineSpec& machine,
                                                 const link::StreamOpener&,
                                                 const link::SteadyClock&) {
  const HalFiles hal = INTAGLIO_TRY(ReadHalFiles("mark_line", machine.mark_line()));
  return CompareBeamHal(machine, hal.identity, hal.pins);
}

}  // namespace intaglio::drivers
