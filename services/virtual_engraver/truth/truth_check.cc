#include "services/virtual_engraver/truth/truth_check.h"

#include <fmt/format.h>
#include <google/protobuf/message.h>

#include <algorithm>
#include <string>

namespace intaglio {
namespace {

namespace pb = google::protobuf;

// What a laser controller's identity can list (services/platform/link/laser_protocol.h).
constexpr int kMaxRates = 32;
// What a controller's identity can report.
constexpr std::size_t kMaxSerialNumber = 64;
// What a glass record can number (engrave/formats/glass_record.h), less the first.
constexpr int kMaxFurtherStations = 63;
constexpr int kMaxObstacles = 64;

constexpr TruthRange kRanges[] = {
    {"TruthSecondOrder", "natural_frequency_hz", 1, 10000},
    {"TruthSecondOrder", "damping_ratio", 0.05, 5},
    {"TruthServo", "position_gain_per_s", 1, 200000},
    {"TruthServo", "velocity_time_s", 0.0001, 0.1},
    {"TruthServo", "derivative_ratio", 0, 100},
    {"TruthServo", "feed_forward_ratio", 0, 1.5},
    {"TruthServo", "load_acceleration_mm_s2", -100000, 100000},
    {"TruthServo", "friction_acceleration_mm_s2", 0, 100000},
    {"TruthServo", "max_acceleration_mm_s2", 1, 1000000},
    {"TruthCascade", "position_gain_per_s", 1, 10000},
    {"TruthCascade", "natural_frequency_hz", 1, 10000},
    {"TruthCascade", "damping_ratio", 0.05, 5},
    {"TruthStepperScrew", "rotor_frequency_hz", 1, 10000},
    {"TruthStepperScrew", "rotor_damping_ratio", 0.05, 5},
    {"TruthStepperScrew", "carriage_frequency_hz", 1, 10000},
    {"TruthStepperScrew", "carriage_damping_ratio", 0.01, 1},
    {"TruthStepperScrew", "inertia_ratio", 0, 20},
    {"TruthStepperScrew", "full_step_mm", 0.0001, 10},
    {"TruthPlanar", "natural_frequency_hz", 1, 10000},
    {"TruthPlanar", "damping_ratio", 0.05, 5},
    {"TruthPlanar", "integral_rate_per_s", 0.1, 10000},
    {"TruthPlanar", "period_s", 0.00001, 0.01},
    {"TruthPlanar", "tooth_period_mm", 0.01, 10},
    {"TruthPlanar", "cogging_acceleration_mm_s2", 0, 100000},
    {"TruthPlanar", "sensor_error_um", 0, 100},
    {"TruthVibration", "above_mm_s2", 0, 1000000},
    {"TruthVibration", "natural_frequency_hz", 1, 10000},
    {"TruthVibration", "damping_ratio", 0.001, 5},
    {"TruthArm", "pivot_distance_mm", 0.001, 100000},
    {"TruthArm", "arm_length_mm", 0.001, 100000},
    {"TruthMirrors", "pupil_x_mm", 1, 1000000},
    {"TruthMirrors", "pupil_y_mm", 1, 1000000},
    {"TruthMirrors", "distortion_ratio", -0.5, 0.5},
    {"TruthMirrors", "wavelength_nm", 200, 2000},
    {"TruthMirrors", "crack_energy_mj", 0, 10000},
    {"TruthGuide", "travel_ratio", 0.5, 2},
    {"TruthGuide", "turn_rad", -0.1, 0.1},
    {"TruthStage", "travel_min_mm", -10000, 10000},
    {"TruthStage", "travel_max_mm", -10000, 10000},
    {"TruthStage", "first_order_lag_s", 0, 0.1},
    {"TruthAxisDrive", "axis", 1, 3},
    {"TruthAxisDrive", "first_order_lag_s", 0, 0.1},
    {"TruthStage", "brake_acceleration_mm_s2", 1, 1000000},
    {"TruthStage", "position_tolerance_um", 0.001, 10000},
    {"TruthStage", "start_mm", -10000, 10000},
    {"TruthStage", "clock_drift_ppm", -200, 200},
    {"TruthStage", "repeatability_um", 0, 1000},
    {"TruthStage", "backlash_um", 0, 10000},
    {"TruthLaser", "rates_hz", 0.1, 100000},
    {"TruthLaser", "warm_up_s", 0, 3600},
    {"TruthLaser", "channels", 1, 4},
    {"TruthLaser", "pulse_energy_mj", 0.001, 10000},
    {"TruthLaser", "channel_offset_mm", -1000, 1000},
    {"TruthLaser", "trigger_shift_us", -10000, 10000},
    {"TruthLaser", "trigger_max_delay_us", 0, 10000},
    {"TruthLaser", "trigger_min_width_us", 0, 10000},
    {"TruthLaser", "sync_width_us", 0, 10000},
    {"TruthLaser", "sensor_width_us", 0, 10000},
    {"TruthLaser", "shutter_time_ms", 0, 1000},
    {"TruthLaser", "min_pulse_energy_mj", 0.001, 10000},
    {"TruthLaser", "energy_spread_ratio", 0, 0.5},
    {"TruthLaser", "energy_error_ratio", -0.5, 0.5},
    {"TruthLaser", "split_ratio", 0.001, 1},
    {"TruthStation", "offset_mm", -10000, 10000},
    {"TruthStation", "turn_rad", -6.3, 6.3},
    {"TruthBlock", "size_mm", 0.1, 10000},
    {"TruthBlock", "origin_mm", -10000, 10000},
    {"TruthBlock", "refractive_index", 1, 4},
    {"TruthBlock", "numerical_aperture", 0, 0.95},
    {"TruthBlock", "crack_length_mm", 0.001, 10},
    {"TruthBody", "above_focus_mm", -1000, 10000},
    {"TruthBody", "diameter_mm", 0.1, 10000},
    {"TruthObstacle", "min_mm", -10000, 10000},
    {"TruthObstacle", "max_mm", -10000, 10000},
    {"HeadTruth", "field_mm", 1, 2000},
    {"HeadTruth", "half_angle_deg", 0, 30},
    {"HeadTruth", "lens_ratio", -0.2, 0.2},
    {"HeadTruth", "servo_lag_s", 0, 0.01},
    {"HeadTruth", "encoder_count_um", 0.1, 10000},
    {"HeadTruth", "encoder_jitter_um", 0, 10000},
    {"HeadTruth", "web_mm_s", -10000, 10000},
    {"HeadTruth", "web_wave_ratio", 0, 0.5},
    {"HeadTruth", "web_wave_s", 0.01, 1000},
    {"HeadTruth", "edge_wave_mm", 0, 10},
    {"HeadTruth", "edge_wave_length_mm", 1, 100000},
    {"HeadTruth", "edge_sensor_mm", 0, 10000},
    {"HeadTruth", "laser_w", 0.001, 100000},
    {"HeadTruth", "queue_ticks", 10000, 10000000},
    {"MillTruth", "tool_diameter_mm", 0.001, 100},
    {"MillTruth", "sheet_thickness_mm", 0.01, 1000},
    {"MillTruth", "sheet_height_mm", -10, 10},
    {"MillTruth", "acceleration_mm_s2", 1, 100000},
    {"MillTruth", "max_speed_mm_s", 0.1, 10000},
    {"MachineTruth", "line_jitter_ms", 0, 2},
};

const TruthRange* FindRange(const pb::FieldDescriptor& field) {
  for (const TruthRange& range : kRanges) {
    if (field.containing_type()->name() == range.message && field.name() == range.field)
      return &range;
  }
  return nullptr;
}

class Checker {
 public:
  void CheckMessage(const pb::Message& message, const std::string& path) {
    const pb::Reflection& reflection = *message.GetReflection();
    // Without presence: always, so that a forgotten natural frequency shows as 0.
    for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
      const pb::FieldDescriptor& field = *message.GetDescriptor()->field(i);
      const std::string at = path.empty() ? field.name() : path + "." + field.name();
      if (field.is_repeated()) {
        for (int k = 0; k < reflection.FieldSize(message, &field); ++k) {
          CheckElement(message, field, k, fmt::format("{}[{}]", at, k));
        }
      } else if (!field.has_presence() || reflection.HasField(message, &field)) {
        CheckField(message, field, at);
      }
    }
  }

  void CheckSerialNumber(const std::string& text, const std::string& path) {
    const bool printable = std::all_of(text.begin(), text.end(),
                                       [](char c) { return c >= ' ' && c <= '~'; });
    if (printable && text.size() <= kMaxSerialNumber) return;
    Add(path, fmt::format("{:?}", text), "is not 0 to 64 printable ASCII characters");
  }

  void CheckTravel(const TruthStage& stage) {
    const auto axis = [this](const char* name, double min_mm, double max_mm) {
      if (!(min_mm >= max_mm)) return;
      Add(fmt::format("stage.travel_min_mm.{}", name), fmt::format("{}", min_mm),
          fmt::format("is not below stage.travel_max_mm.{}, {}", name, max_mm));
    };
    Vector3 max = stage.travel_max_mm();
    if (!stage.has_travel_max_mm()) max.set_x(170), max.set_y(170), max.set_z(170);
    axis("x", stage.travel_min_mm().x(), max.x());
    axis("y", stage.travel_min_mm().y(), max.y());
    axis("z", stage.travel_min_mm().z(), max.z());
  }

  void CheckOffsets(const TruthLaser& laser) {
    if (laser.channel_offset_mm_size() <= 3) return;
    Add("laser.channel_offset_mm",
        fmt::format("{} places", laser.channel_offset_mm_size()),
        "are more than 3, of channels 2 to 4");
  }

  void CheckStations(const TruthBlock& block) {
    if (block.stations_size() <= kMaxFurtherStations) return;
    Add("block.stations", fmt::format("{} stations", block.stations_size()),
        fmt::format("are more than {}", kMaxFurtherStations));
  }

  void CheckObstacles(const MachineTruth& truth) {
    if (truth.obstacles_size() > kMaxObstacles) {
      Add("obstacles", fmt::format("{} obstacles", truth.obstacles_size()),
          fmt::format("are more than {}", kMaxObstacles));
    }
    for (int i = 0; i < truth.obstacles_size(); ++i) {
      const Vector3 &min = truth.obstacles(i).min_mm(),
                    &max = truth.obstacles(i).max_mm();
      if (min.x() < max.x() && min.y() < max.y() && min.z() < max.z()) continue;
      Add(fmt::format("obstacles[{}].min_mm", i),
          fmt::format("{}, {}, {}", min.x(), min.y(), min.z()),
          "is not below max_mm in each axis");
    }
  }

  void CheckAxisDrives(const TruthStage& stage) {
    for (int i = 0; i < stage.axis_drives_size(); ++i) {
      const TruthAxisDrive& drive = stage.axis_drives(i);
      const std::string path = fmt::format("stage.axis_drives[{}]", i);
      if (drive.drive_case() == TruthAxisDrive::DRIVE_NOT_SET)
        Add(path, fmt::format("axis {}", drive.axis()), "has no drive");
      for (int k = 0; k < i; ++k) {
        if (stage.axis_drives(k).axis() != drive.axis()) continue;
        Add(path + ".axis", fmt::format("{}", drive.axis()), "occurs twice");
      }
    }
  }

  void CheckRates(const TruthLaser& laser) {
    if (laser.rates_hz_size() <= kMaxRates) return;
    Add("laser.rates_hz", fmt::format("{} rates", laser.rates_hz_size()),
        fmt::format("are more than {}", kMaxRates));
  }

  std::vector<Error> Take() { return std::move(errors_); }

 private:
  void CheckElement(const pb::Message& message, const pb::FieldDescriptor& field, int k,
                    const std::string& path) {
    const pb::Reflection& reflection = *message.GetReflection();
    if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE) {
      const pb::Message& child = reflection.GetRepeatedMessage(message, &field, k);
      const auto* vector = dynamic_cast<const Vector3*>(&child);
      if (vector == nullptr) return CheckMessage(child, path);
      return CheckVector(*vector, *FindRange(field), path);
    }
    CheckNumber(reflection.GetRepeatedDouble(message, &field, k), *FindRange(field),
                path);
  }

  void CheckVector(const Vector3& vector, const TruthRange& range,
                   const std::string& path) {
    CheckNumber(vector.x(), range, path + ".x");
    CheckNumber(vector.y(), range, path + ".y");
    CheckNumber(vector.z(), range, path + ".z");
  }

  void CheckField(const pb::Message& message, const pb::FieldDescriptor& field,
                  const std::string& path) {
    const pb::Reflection& reflection = *message.GetReflection();
    const TruthRange* range = FindRange(field);
    if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE) {
      const pb::Message& child = reflection.GetMessage(message, &field);
      const auto* vector = dynamic_cast<const Vector3*>(&child);
      if (vector == nullptr || range == nullptr) return CheckMessage(child, path);
      CheckVector(*vector, *range, path);
    } else if (range != nullptr) {
      CheckNumber(field.cpp_type() == pb::FieldDescriptor::CPPTYPE_UINT32
                      ? reflection.GetUInt32(message, &field)
                      : reflection.GetDouble(message, &field),
                  *range, path);
    }
  }

  void CheckNumber(double value, const TruthRange& range, const std::string& path) {
    if (value >= range.min && value <= range.max) return;  // false for NaN
    Add(path, fmt::format("{}", value),
        fmt::format("is outside {}..{}", range.min, range.max));
  }

  void Add(const std::string& path, const std::string& value, const std::string& what) {
    errors_.push_back(
        {ErrorCode::kInvalidValue, fmt::format("{}: {} {}", path, value, what), value});
  }

  std::vector<Error> errors_;
};

}  // namespace

std::span<const TruthRange> TruthRanges() { return kRanges; }

std::vector<Error> CheckTruth(const MachineTruth& truth) {
  Checker checker;
  checker.CheckMessage(truth, "");
  checker.CheckTravel(truth.stage());
  checker.CheckAxisDrives(truth.stage());
  checker.CheckSerialNumber(truth.stage().serial_number(), "stage.serial_number");
  checker.CheckRates(truth.laser());
  checker.CheckOffsets(truth.laser());
  checker.CheckStations(truth.block());
  checker.CheckObstacles(truth);
  checker.CheckSerialNumber(truth.laser().serial_number(), "laser.serial_number");
  checker.CheckSerialNumber(truth.head().serial_number(), "head.serial_number");
  checker.CheckSerialNumber(truth.mill().serial_number(), "mill.serial_number");
  return checker.Take();
}

}  // namespace intaglio
