#include "services/drivers/grbl/grbl_settings.h"

#include <fmt/format.h>
#include <poll.h>

#include <array>
#include <chrono>
#include <optional>
#include <span>

#include "engrave/core/try.h"
#include "services/drivers/grbl/grbl_text.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

constexpr auto kAnswerTime = 4s;
constexpr auto kSettingsPeriod = 200ms;
constexpr int kMinPower = 31, kMaxPower = 30, kLaserMode = 32, kStepsPerMm = 100,
              kMaxRate = 110, kAcceleration = 120, kTravel = 130;
// $110 to $132 have three decimals.
constexpr double kSameSetting = 0.001;

void AddGrblError(std::vector<Error>& errors, ErrorCode code, const std::string& field,
                  const std::string& what) {
  errors.push_back({code, field + ": " + what, ""});
}

void DiffersFromGrbl(std::vector<Error>& errors, const std::string& field,
                     const std::string& what) {
  AddGrblError(errors, ErrorCode::kInvalidValue, field, what);
}

std::optional<double> ValueOf(const GrblSettings& settings, int number) {
  const auto found = settings.values.find(number);
  return found == settings.values.end() ? std::nullopt : std::optional(found->second);
}

/// One axis; `name`: x, y, z, of number 0, 1, 2.
void CompareGrblAxis(const std::string& name, int number, const AxisLimits& axis,
                     double tolerance_um, const GrblSettings& settings,
                     std::vector<Error>& errors) {
  const auto value = [&](int first) { return ValueOf(settings, first + number); };
  if (const auto steps = value(kStepsPerMm); steps && *steps > 0) {
    const double step_um = 1000 / *steps;
    if (step_um > tolerance_um) {
      DiffersFromGrbl(
          errors, "position_tolerance_um",
          fmt::format("{} is less than a step of {}, {:.4g} um by ${}={:g}; raise "
                      "the microsteps of the drive and the setting, or the field",
                      tolerance_um, name, step_um, kStepsPerMm + number, *steps));
    }
  }
  const auto rate = value(kMaxRate);
  if (rate && axis.max_speed_mm_s() > *rate / 60 + kSameSetting) {
    DiffersFromGrbl(
        errors, name + ".max_speed_mm_s",
        fmt::format("{} mm/s is more than ${}={:g} mm/min, {:.4g} mm/s; set it to "
                    "{:g}, or reduce the field",
                    axis.max_speed_mm_s(), kMaxRate + number, *rate, *rate / 60,
                    axis.max_speed_mm_s() * 60));
  }
  const auto acceleration = value(kAcceleration);
  if (acceleration && axis.max_acceleration_mm_s2() > *acceleration + kSameSetting) {
    DiffersFromGrbl(
        errors, name + ".max_acceleration_mm_s2",
        fmt::format("{} is more than ${}={:g} mm/s^2; set it to {:g}, or reduce the "
                    "field",
                    axis.max_acceleration_mm_s2(), kAcceleration + number, *acceleration,
                    axis.max_acceleration_mm_s2()));
  }
  const double travel_mm = axis.travel_max_mm() - axis.travel_min_mm();
  const auto travel = value(kTravel);
  if (travel && travel_mm > *travel + kSameSetting) {
    DiffersFromGrbl(
        errors, name + ".travel_max_mm",
        fmt::format("{} to {} are {:g} mm, more than ${}={:g} mm; set it to the way "
                    "between the axis's ends, or reduce the travel",
                    axis.travel_min_mm(), axis.travel_max_mm(), travel_mm,
                    kTravel + number, *travel));
  }
}

void ComparePower(const GrblSettings& settings, std::vector<Error>& errors) {
  if (const auto mode = ValueOf(settings, kLaserMode); mode != 1.0) {
    DiffersFromGrbl(
        errors, "motion_line",
        fmt::format("the controller has ${}={}, so the laser could stay lit at rest; "
                    "set ${}=1",
                    kLaserMode, mode ? fmt::format("{:g}", *mode) : "(none)",
                    kLaserMode));
  }
  if (const auto full = ValueOf(settings, kMaxPower); !full || !(*full > 0)) {
    DiffersFromGrbl(
        errors, "motion_line",
        fmt::format("the controller has ${0}={1}, S of full power; set ${0}=1000",
                    kMaxPower, full ? fmt::format("{:g}", *full) : "(none)"));
  }
  if (const auto dark = ValueOf(settings, kMinPower); dark && *dark != 0) {
    DiffersFromGrbl(
        errors, "motion_line",
        fmt::format("the controller has ${0}={1:g}, so a pulse that is off may still "
                    "light; set ${0}=0",
                    kMinPower, *dark));
  }
}

/// Reads lines of a controller until it has answered, or `give_up`.
class SettingsReader {
 public:
  SettingsReader(link::ByteStream& stream, const link::SteadyClock& clock)
      : stream_(stream), clock_(clock), give_up_(clock() + kAnswerTime) {}

  Result<GrblSettings> Read() {
    while (clock_() < give_up_ && acknowledged_ < 2) {
      if (phase_ == Phase::kAsking && clock_() >= next_question_) {
        next_question_ = clock_() + kSettingsPeriod;
        out_ += '?';
      }
      INTAGLIO_TRY(Move());
      pollfd wait{stream_.fd(), POLLIN, 0};
      poll(&wait, wait.fd < 0 ? 0 : 1, 10);
    }
    if (acknowledged_ == 2) return settings_;
    return Fail(ErrorCode::kLinkLost,
                "the controller does not answer: check its power, the cable and the baud "
                "rate");
  }

 private:
  enum class Phase { kAsking, kGrblResetting, kReading };

  Status Move() {
    if (!out_.empty() && stream_.connected()) {
      const auto taken = INTAGLIO_TRY(stream_.Write(std::as_bytes(std::span(out_))));
      out_.erase(0, taken);
    }
    std::array<std::byte, 1024> buffer;
    std::vector<std::string> lines;
    while (const auto count = INTAGLIO_TRY(stream_.Read(buffer)))
      reader_.Feed(std::span(buffer).first(count), lines);
    for (const std::string& line : lines) INTAGLIO_TRY(Receive(ParseGrblAnswer(line)));
    return {};
  }

  Status Receive(const GrblAnswer& answer) {
    if (const auto* status = std::get_if<GrblStatus>(&answer)) return TakeStatus(*status);
    if (std::holds_alternative<GrblBanner>(answer) && phase_ == Phase::kGrblResetting) {
      phase_ = Phase::kReading;
      out_ += "$I\n$$\n";
    }
    if (phase_ != Phase::kReading) return {};
    if (const auto* version = std::get_if<GrblVersion>(&answer)) {
      settings_.version = version->version;
      settings_.serial_number = version->serial_number;
    } else if (const auto* setting = std::get_if<GrblSetting>(&answer)) {
      settings_.values[setting->number] = setting->value;
    } else if (const auto* error = std::get_if<GrblError>(&answer)) {
      return Fail(
          ErrorCode::kUnsupported,
          "the controller does not report its settings: " + TextOfGrblError(error->code));
    }
    acknowledged_ += std::holds_alternative<GrblOk>(answer) ? 1 : 0;
    return {};
  }

  Status TakeStatus(const GrblStatus& status) {
    if (phase_ != Phase::kAsking) return {};
    if (status.state != GrblState::kIdle && status.state != GrblState::kAlarm) {
      return Fail(ErrorCode::kRefused,
                  "the controller moves, holds or has an open door: wait until it is "
                  "idle");
    }
    phase_ = Phase::kGrblResetting;
    out_ = kGrblReset;
    return {};
  }

  link::ByteStream& stream_;
  const link::SteadyClock& clock_;
  std::chrono::nanoseconds give_up_, next_question_{0};
  GrblAnswerReader reader_;
  std::string out_;
  Phase phase_ = Phase::kAsking;
  int acknowledged_ = 0;  // of $I and $$
  GrblSettings settings_;
};

}  // namespace

std::vector<Error> CheckGrblProfile(const MachineSpec& machine) {
  std::vector<Error> errors;
  const LaserHead& laser = machine.laser();
  if (!laser.has_max_unsettled_points()) {
    AddGrblError(
        errors, ErrorCode::kMissing, "laser.max_unsettled_points",
        "is missing; a controller of the grbl family remembers no pulse, so give how "
        "many points may become uncertain at a time, 16");
  }
  if (laser.has_timing()) {
    DiffersFromGrbl(
        errors, "laser.timing",
        "a controller of the grbl family has neither lamp sync nor Q-switch; remove "
        "it");
  }
  if (laser.channels() > 1) {
    DiffersFromGrbl(
        errors, "laser.channels",
        fmt::format("{} are more than the one laser output of the grbl family; give 1",
                    laser.channels()));
  }
  if (machine.pulse_trigger() == PULSE_TRIGGER_AT_PLACE) {
    DiffersFromGrbl(
        errors, "pulse_trigger",
        "PULSE_TRIGGER_AT_PLACE is not offered by the grbl family; remove the field");
  }
  return errors;
}

std::vector<Error> CompareGrbl(const MachineSpec& machine, const GrblSettings& settings) {
  std::vector<Error> errors;
  const SerialLine& line = machine.motion_line();
  if (line.has_serial_number() && line.serial_number() != settings.serial_number) {
    DiffersFromGrbl(
        errors, "motion_line.serial_number",
        fmt::format("{:?} is expected, the controller on {} reports {:?}; swap the "
                    "cables, correct the field, or store it with $I={}",
                    line.serial_number(), line.device(), settings.serial_number,
                    line.serial_number()));
  }
  ComparePower(settings, errors);
  const std::pair<const char*, const AxisLimits*> axes[] = {
      {"x", &machine.x()}, {"y", &machine.y()}, {"z", &machine.z()}};
  for (int i = 0; i < 3; ++i) {
    CompareGrblAxis(axes[i].first, i, *axes[i].second, machine.position_tolerance_um(),
                    settings, errors);
  }
  return errors;
}

Result<GrblSettings> ReadGrblSettings(const link::StreamOpener& open,
                                      const link::SteadyClock& clock) {
  const auto stream = INTAGLIO_TRY(open());
  return SettingsReader(*stream, clock).Read();
}

Result<std::vector<Error>> CompareGrblController(const MachineSpec& machine,
                                                 const link::StreamOpener& open,
                                                 const link::SteadyClock& clock) {
  return CompareGrbl(machine, INTAGLIO_TRY(ReadGrblSettings(open, clock)));
}

}  // namespace intaglio::drivers
