#include "services/job/field_ranges.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "proto/job.pb.h"
#include "services/job/methods/method_table.h"

namespace intaglio {
namespace {

namespace pb = google::protobuf;

/// Ranges of all fields but those of the methods.
constexpr std::array kRanges = {
    FieldRange{"Placement", "unit_mm", 0.000001, 1000000},
    FieldRange{"Placement", "scale_ratio", 0.000001, 1000000},
    FieldRange{"Placement", "rotate_deg", -180, 180},
    FieldRange{"Placement", "fit_height_mm", 0.1, 1000},
    FieldRange{"Placement", "fit_size_mm", 0.1, 1000},
    FieldRange{"Placement", "move_mm", -1000, 1000},
    FieldRange{"Model", "channels", 1, 4},
    FieldRange{"Model", "points_mm", -10000, 10000},
    FieldRange{"Block", "size_mm", 1, 1000},
    FieldRange{"Block", "margin_mm", 0, 100},
    FieldRange{"ChannelBlock", "channel", 1, 4},
    FieldRange{"ChannelBlock", "size_mm", 1, 1000},
    FieldRange{"Lens", "focal_length_mm", 1, 1000},
    FieldRange{"Lens", "numerical_aperture", 0.01, 0.9},
    FieldRange{"Copies", "count_x", 1, 1000},
    FieldRange{"Copies", "count_y", 1, 1000},
    FieldRange{"Copies", "count_z", 1, 1000},
    FieldRange{"Copies", "step_mm", 0, 1000},
    FieldRange{"Text", "height_mm", 0.1, 500},
    FieldRange{"Text", "line_ratio", 0.5, 5},
    FieldRange{"Text", "max_height_mm", 0.1, 1000},
    FieldRange{"Text", "max_width_mm", 0.1, 1000},
    FieldRange{"TonePoint", "from", 0, 1},
    FieldRange{"TonePoint", "to", 0, 1},
    FieldRange{"Discretization", "min_spacing_mm", 0.02, 10},
    FieldRange{"Discretization", "height_ratio", 1, 10},
    FieldRange{"KdzOrder", "up_ratio", 0, 100},
    FieldRange{"LayersOrder", "layer_thickness_mm", 0.01, 100},
    FieldRange{"AnnealOrder", "tries_per_point", 0, 1e6},
    FieldRange{"AnnealOrder", "time_s", 0.1, 86400},
    FieldRange{"AnnealOrder", "seed", 0, 1e6},
    FieldRange{"BoustrophedonOrder", "layer_thickness_mm", 0.01, 100},
    FieldRange{"BoustrophedonOrder", "row_width_mm", 0.01, 100},
    FieldRange{"PublishedKdzOrder", "up_ratio", 0, 100},
    FieldRange{"PublishedKdzOrder", "down_ratio", 0, 100},
    FieldRange{"PublishedKdzOrder", "angle_deg", 0, 89},
    FieldRange{"SweepOrder", "slab_mm", 0.01, 100},
    FieldRange{"MotionOptions", "max_speed_mm_s", 0.1, 100000},
    FieldRange{"MotionOptions", "max_acceleration_mm_s2", 1, 1e9},
    FieldRange{"MotionOptions", "tolerance_um", 0, 50},
    FieldRange{"MotionOptions", "depth_tolerance_um", 0, 500},
    FieldRange{"MotionOptions", "parabola_height_mm", 0, 10},
    FieldRange{"LqWeights", "moving_mass_kg", 0.01, 1000},
    FieldRange{"LqWeights", "friction_n_s_m", 0, 1000000},
    FieldRange{"LqWeights", "speed_weight", 0, 1000000},
    FieldRange{"LqWeights", "force_weight", 0.000001, 1000000},
    FieldRange{"LaserOptions", "rate_hz", 1, 4000},
    FieldRange{"LaserOptions", "wavelength_nm", 200, 2000},
    FieldRange{"LaserOptions", "pulse_energy_mj", 0.001, 10000},
    FieldRange{"Model", "pulse_energy_mj", 0.001, 10000},
    FieldRange{"Model", "min_spacing_mm", 0.02, 10},
    FieldRange{"Block", "quarter_turns", 0, 3},
    FieldRange{"LaserOptions", "channels", 1, 4},
    FieldRange{"JobSpec", "priority", -100, 100},
    FieldRange{"JobSpec", "station", 1, 64},
    FieldRange{"Course", "tool_diameter_mm", 0.001, 100},
    FieldRange{"Course", "pass_count", 1, 20},
    FieldRange{"Course", "overlap_ratio", 0.5, 0.95},
    FieldRange{"Course", "speed_mm_s", 0.01, 10000},
    FieldRange{"Course", "travel_mm_s", 0.01, 10000},
    FieldRange{"Course", "plunge_mm_s", 0.01, 10000},
    FieldRange{"Course", "depth_mm", 0, 100},
    FieldRange{"Course", "power_ratio", 0, 1},
    FieldRange{"Course", "repeat_count", 1, 100},
    FieldRange{"Course", "safe_height_mm", 0.01, 1000},
    FieldRange{"Course", "drill_depth_mm", 0.01, 100},
    FieldRange{"Course", "lead_mm", 0.01, 1000},
    FieldRange{"Course", "drill_diameter_mm", 0, 100},
    FieldRange{"CourseTool", "spindle_rpm", 1, 200000},
    FieldRange{"CourseTool", "spin_up_s", 0.1, 60},
    FieldRange{"CourseTool", "safe_height_mm", 0.01, 1000},
    FieldRange{"Marks", "first_number", 0, 1e9},
    FieldRange{"Marks", "number_digits", 1, 10},
    FieldRange{"MarkPen", "speed_mm_s", 0.01, 100000},
    FieldRange{"MarkPen", "power_ratio", 0, 1},
    FieldRange{"MarkPen", "frequency_hz", 0, 1e7},
    FieldRange{"MarkPen", "pass_count", 1, 100},
    FieldRange{"MarkPlacement", "scale_ratio", 0.000001, 1000000},
    FieldRange{"MarkPlacement", "rotate_deg", -360, 360},
    FieldRange{"MarkPlacement", "fit_width_mm", 0.01, 2000},
    FieldRange{"MarkPlacement", "fit_height_mm", 0.01, 2000},
    FieldRange{"MarkPlacement", "move_x_mm", -10000, 10000},
    FieldRange{"MarkPlacement", "move_y_mm", -10000, 10000},
    FieldRange{"MarkImage", "distance_mm", 0.001, 10},
    FieldRange{"MarkImage", "dot_mm", 0.001, 10},
    FieldRange{"MarkImage", "threshold_ratio", 0, 1},
    FieldRange{"MarkCode", "module_mm", 0.01, 50},
    FieldRange{"MarkCode", "correction_ratio", 0, 0.3},
    FieldRange{"MarkHatch", "distance_mm", 0.001, 10},
    FieldRange{"MarkHatch", "angle_deg", -360, 360},
    FieldRange{"MarkHatch", "inset_mm", 0, 10},
    FieldRange{"MarkRepeats", "count", 1, 1e6},
    FieldRange{"MarkRepeats", "pitch_mm", 0.001, 100000},
    FieldRange{"MarkWeb", "speed_mm_s", 0, 100000},
    FieldRange{"Course", "tab_count", 0, 1000},
    FieldRange{"Course", "tab_width_mm", 0.01, 1000},
    FieldRange{"Course", "tab_height_mm", 0.01, 100},
    FieldRange{"Course", "tab_distance_mm", 0.1, 10000},
    FieldRange{"AxisLimits", "travel_min_mm", -10000, 10000},
    FieldRange{"AxisLimits", "travel_max_mm", -10000, 10000},
    FieldRange{"AxisLimits", "max_speed_mm_s", 0.1, 100000},
    FieldRange{"AxisLimits", "max_acceleration_mm_s2", 1, 1e9},
    FieldRange{"AxisLimits", "max_jerk_mm_s3", 1, 1000000000},
    FieldRange{"AxisLimits", "steps_per_mm", 0.1, 100000},
    FieldRange{"AxisLimits", "stiffness_n_um", 0.001, 100000},
    FieldRange{"RotaryAxis", "travel_min_rad", -2000, 2000},
    FieldRange{"RotaryAxis", "travel_max_rad", -2000, 2000},
    FieldRange{"RotaryAxis", "max_speed_rad_s", 0.001, 1000},
    FieldRange{"RotaryAxis", "max_acceleration_rad_s2", 0.01, 100000},
    FieldRange{"RotaryAxis", "max_jerk_rad_s3", 0.1, 1000000000},
    FieldRange{"RotaryAxis", "stiffness_nm_rad", 0.001, 1000000000},
    FieldRange{"PolarKinematics", "axis_distance_mm", 1, 10000},
    FieldRange{"PolarKinematics", "arm_length_mm", 1, 10000},
    FieldRange{"PolarKinematics", "singular_margin_rad", 0.01, 1},
    FieldRange{"HeadOverBlockKinematics", "pupil_x_mm", 10, 100000},
    FieldRange{"HeadOverBlockKinematics", "pupil_y_mm", 10, 100000},
    FieldRange{"HeadOverBlockKinematics", "crack_energy_mj", 0.0001, 10000},
    FieldRange{"JumpAndDwell", "z_step_mm", 0.001, 10},
    FieldRange{"JumpAndDwell", "jump_mm_s", 10, 100000},
    FieldRange{"JumpAndDwell", "jump_delay_s", 0, 0.1},
    FieldRange{"JumpAndDwell", "dwell_s", 0.00001, 0.5},
    FieldRange{"JumpAndDwell", "z_settle_s", 0, 10},
    FieldRange{"HeadNumbers", "focal_mm", 1, 10000},
    FieldRange{"HeadNumbers", "rotation_rad", -3.2, 3.2},
    FieldRange{"HeadNumbers", "zero_x_rad", -0.5, 0.5},
    FieldRange{"HeadNumbers", "zero_y_rad", -0.5, 0.5},
    FieldRange{"HeadNumbers", "lens_1_ratio", 0.5, 2},
    FieldRange{"HeadNumbers", "lens_3_ratio", -2, 2},
    FieldRange{"HeadNumbers", "lens_4_ratio", -2, 2},
    FieldRange{"HeadNumbers", "offset_x_mm", -1000, 1000},
    FieldRange{"HeadNumbers", "offset_y_mm", -1000, 1000},
    FieldRange{"HeadNumbers", "shear_ratio", -0.5, 0.5},
    FieldRange{"HeadNumbers", "axes_ratio", 0.5, 2},
    FieldRange{"MachineLens", "focal_length_mm", 1, 1000},
    FieldRange{"MachineLens", "numerical_aperture", 0.01, 0.9},
    FieldRange{"MachineLens", "crack_diameter_mm", 0.01, 1},
    FieldRange{"MachineLens", "crack_length_mm", 0.01, 2},
    FieldRange{"MachineLens", "working_distance_mm", 0.1, 2000},
    FieldRange{"MachineLens", "max_block_height_mm", 1, 1000},
    FieldRange{"MachineLens", "free_distance_mm", 0.1, 2000},
    FieldRange{"MachineLens", "mount_diameter_mm", 1, 2000},
    FieldRange{"HeadBody", "diameter_mm", 1, 10000},
    FieldRange{"HeadBody", "above_reference_mm", -1000, 1000},
    FieldRange{"Fixture", "min_mm", -10000, 10000},
    FieldRange{"Fixture", "max_mm", -10000, 10000},
    FieldRange{"CourseTool", "free_length_mm", 0.1, 1000},
    FieldRange{"LinearAxis", "scale_ratio", 0.9, 1.1},
    FieldRange{"CartesianKinematics", "squareness_xy_rad", -0.1, 0.1},
    FieldRange{"EnergyPoint", "setting_ratio", 0, 1},
    FieldRange{"EnergyPoint", "energy_mj", 0, 10000},
    FieldRange{"Loading", "offsets_mm", -10000, 10000},
    FieldRange{"Loading", "station_count", 2, 64},
    FieldRange{"Loading", "pitch_mm", -10000, 10000},
    FieldRange{"Loading", "turn_rad", -3.2, 3.2},
    FieldRange{"Loading", "table_radius_mm", 1, 10000},
    FieldRange{"ChannelPosition", "channel", 2, 4},
    FieldRange{"ChannelPosition", "offset_mm", -1000, 1000},
    FieldRange{"LaserHead", "rates_hz", 1, 4000},
    FieldRange{"LaserHead", "warm_up_s", 0, 3600},
    FieldRange{"LaserHead", "pulse_energy_mj", 0.001, 10000},
    FieldRange{"LaserHead", "wavelength_nm", 200, 2000},
    FieldRange{"LaserHead", "channels", 1, 4},
    FieldRange{"LaserHead", "max_missed_in_a_row", 1, 1000},
    FieldRange{"LaserHead", "max_unsettled_points", 1, 1000},
    FieldRange{"PulseTiming", "qswitch_delay_us", 0, 10000},
    FieldRange{"PulseTiming", "qswitch_width_us", 1, 10000},
    FieldRange{"PulseTiming", "max_qswitch_delay_us", 0, 10000},
    FieldRange{"PulseTiming", "min_qswitch_width_us", 1, 10000},
    FieldRange{"PulseTiming", "min_sync_width_us", 0, 10000},
    FieldRange{"PulseTiming", "min_sensor_width_us", 0, 10000},
    FieldRange{"PulseTiming", "shutter_time_ms", 0, 1000},
    FieldRange{"PulseTiming", "min_flash_height_mm", -10000, 10000},
    FieldRange{"PulseTiming", "max_flash_height_mm", -10000, 10000},
    FieldRange{"LaserPump", "energy_j", 0.001, 1000},
    FieldRange{"LaserPump", "max_energy_j", 0.001, 1000},
    FieldRange{"LaserPump", "max_power_w", 0.001, 1000000},
    FieldRange{"LaserHead", "lamp_hold_s", 0, 3600},
    FieldRange{"LaserHead", "default_rate_hz", 1, 4000},
    FieldRange{"LaserHead", "pulse_duration_ns", 0.0001, 1000000},
    FieldRange{"LaserHead", "divergence_mrad", 0.001, 100},
    FieldRange{"LaserHead", "beam_diameter_mm", 0.1, 100},
    FieldRange{"LaserHead", "split_ratio", 0.001, 1},
    FieldRange{"BjjczBoard", "door_input", 0, 15},
    FieldRange{"BjjczBoard", "gate_output", 0, 15},
    FieldRange{"BjjczBoard", "lamp_output", 0, 15},
    FieldRange{"BjjczBoard", "guide_output", 0, 15},
    FieldRange{"BjjczBoard", "pulse_width_ns", 1, 500},
    FieldRange{"BjjczBoard", "point_frequency_hz", 153, 1e7},
    FieldRange{"ScanHead", "field_mm", 1, 2000},
    FieldRange{"ScanHead", "jump_mm_s", 1, 100000},
    FieldRange{"ScanHead", "servo_lag_s", 0, 0.01},
    FieldRange{"ScanHead", "run_in_s", 0, 0.1},
    FieldRange{"ScanHead", "laser_on_delay_s", 0, 0.01},
    FieldRange{"ScanHead", "laser_off_delay_s", 0, 0.01},
    FieldRange{"ScanHead", "jump_delay_s", 0, 0.01},
    FieldRange{"ScanHead", "mark_delay_s", 0, 0.01},
    FieldRange{"ScanHead", "polygon_delay_s", 0, 0.01},
    FieldRange{"ScanHead", "encoder_count_um", 0, 10000},
    FieldRange{"ScanHead", "edge_sensor_mm", 0, 10000},
    FieldRange{"ScanHead", "ahead_ms", 2, 1000},
    FieldRange{"ScanHead", "tolerance_um", 1, 10000},
    FieldRange{"SerialLine", "baud", 1200, 4000000},
    FieldRange{"MachineSpec", "block_origin_mm", -10000, 10000},
    FieldRange{"MachineSpec", "max_divided_block_mm", 1, 1000},
    FieldRange{"TaughtZero", "channel", 1, 4},
    FieldRange{"TaughtZero", "block_origin_mm", -10000, 10000},
    FieldRange{"SoftLimits", "min", -10000, 10000},
    FieldRange{"SoftLimits", "max", -10000, 10000},
    FieldRange{"TaughtPositions", "number", 0, 1000000},
    FieldRange{"TaughtPositions", "sample", -10000, 10000},
    FieldRange{"TaughtPositions", "park", -10000, 10000},
    FieldRange{"MachineSpec", "repeatability_um", 0.1, 1000},
    FieldRange{"MachineSpec", "position_tolerance_um", 1, 1000},
    FieldRange{"MachineSpec", "stage_lag_s", 0, 0.1},
    FieldRange{"SecondOrderDrive", "natural_frequency_hz", 1, 10000},
    FieldRange{"SecondOrderDrive", "damping_ratio", 0.05, 5},
    FieldRange{"ServoDrive", "position_gain_per_s", 1, 200000},
    FieldRange{"ServoDrive", "velocity_time_s", 0.0001, 0.1},
    FieldRange{"ServoDrive", "derivative_ratio", 0, 100},
    FieldRange{"ServoDrive", "feed_forward_ratio", 0, 1.5},
    FieldRange{"CascadeDrive", "position_gain_per_s", 1, 10000},
    FieldRange{"CascadeDrive", "natural_frequency_hz", 1, 10000},
    FieldRange{"CascadeDrive", "damping_ratio", 0.05, 5},
    FieldRange{"StepperScrewDrive", "rotor_frequency_hz", 1, 10000},
    FieldRange{"StepperScrewDrive", "rotor_damping_ratio", 0.05, 5},
    FieldRange{"StepperScrewDrive", "carriage_frequency_hz", 1, 10000},
    FieldRange{"StepperScrewDrive", "carriage_damping_ratio", 0.01, 1},
    FieldRange{"StepperScrewDrive", "inertia_ratio", 0, 20},
    FieldRange{"PlanarDrive", "natural_frequency_hz", 1, 10000},
    FieldRange{"PlanarDrive", "damping_ratio", 0.05, 5},
    FieldRange{"PlanarDrive", "integral_rate_per_s", 0.1, 10000},
    FieldRange{"PlanarDrive", "period_s", 0.00001, 0.01},
    FieldRange{"AxisDrive", "stage_lag_s", 0, 0.1},
    FieldRange{"MachineSpec", "max_speed_norm_mm_s", 0.1, 10000},
    FieldRange{"MachineSpec", "max_acceleration_norm_mm_s2", 1, 200000},
};

std::vector<FieldRange> WithMethods() {
  std::vector<FieldRange> all(kRanges.begin(), kRanges.end());
  for (const Method& method : Methods()) {
    for (const MethodField& field : method.fields) {
      if (!field.range) continue;
      all.push_back(
          {method.message().name(), field.name, field.range->min, field.range->max});
    }
  }
  return all;
}

void CheckNumber(double value, const FieldRange& range, const std::string& path,
                 std::vector<Finding>& found) {
  if (value >= range.min && value <= range.max) return;  // false for NaN
  found.push_back(
      {{ErrorCode::kInvalidValue,
        fmt::format("{}: {} is outside {}..{}", path, value, range.min, range.max),
        fmt::format("{}", value)},
       path});
}

void CheckVector(const Vector3& v, const FieldRange& range, const std::string& path,
                 std::vector<Finding>& found) {
  CheckNumber(v.x(), range, path + ".x", found);
  CheckNumber(v.y(), range, path + ".y", found);
  CheckNumber(v.z(), range, path + ".z", found);
}

double NumberOf(const pb::Message& message, const pb::FieldDescriptor& field, int index) {
  const pb::Reflection& reflection = *message.GetReflection();
  const bool repeated = field.is_repeated();
  if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_UINT32) {
    return repeated ? reflection.GetRepeatedUInt32(message, &field, index)
                    : reflection.GetUInt32(message, &field);
  }
  if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_INT32) {
    return repeated ? reflection.GetRepeatedInt32(message, &field, index)
                    : reflection.GetInt32(message, &field);
  }
  return repeated ? reflection.GetRepeatedDouble(message, &field, index)
                  : reflection.GetDouble(message, &field);
}

const pb::Message& MessageOf(const pb::Message& message, const pb::FieldDescriptor& field,
                             int index) {
  const pb::Reflection& reflection = *message.GetReflection();
  return field.is_repeated() ? reflection.GetRepeatedMessage(message, &field, index)
                             : reflection.GetMessage(message, &field);
}

void AddOutOfRange(const pb::Message& message, const std::string& path,
                   std::vector<Finding>& found);

void CheckElement(const pb::Message& message, const pb::FieldDescriptor& field, int index,
                  const FieldRange* range, const std::string& path,
                  std::vector<Finding>& found) {
  if (field.cpp_type() == pb::FieldDescriptor::CPPTYPE_MESSAGE) {
    const pb::Message& child = MessageOf(message, field, index);
    const auto* vector = dynamic_cast<const Vector3*>(&child);
    if (vector != nullptr && range != nullptr) {
      CheckVector(*vector, *range, path, found);
    } else {
      AddOutOfRange(child, path, found);
    }
  } else if (range != nullptr) {
    CheckNumber(NumberOf(message, field, index), *range, path, found);
  }
}

void AddOutOfRange(const pb::Message& message, const std::string& path,
                   std::vector<Finding>& found) {
  const pb::Descriptor& type = *message.GetDescriptor();
  const pb::Reflection& reflection = *message.GetReflection();
  for (int i = 0; i < type.field_count(); ++i) {
    const pb::FieldDescriptor& field = *type.field(i);
    const FieldRange* range = FindRange(type.name(), field.name());
    const std::string field_path = JoinPath(path, field.name());
    if (field.is_repeated()) {
      for (int k = 0; k < reflection.FieldSize(message, &field); ++k) {
        CheckElement(message, field, k, range, fmt::format("{}[{}]", field_path, k),
                     found);
      }
    } else if (!field.has_presence() || reflection.HasField(message, &field)) {
      CheckElement(message, field, 0, range, field_path, found);
    }
  }
}

}  // namespace

std::span<const FieldRange> FieldRanges() {
  static const std::vector<FieldRange> kAll = WithMethods();
  return kAll;
}

const FieldRange* FindRange(std::string_view message, std::string_view field) {
  const auto all = FieldRanges();
  const auto found = std::find_if(all.begin(), all.end(), [&](const FieldRange& r) {
    return r.message == message && r.field == field;
  });
  return found == all.end() ? nullptr : &*found;
}

std::string JoinPath(std::string_view path, std::string_view field) {
  return path.empty() ? std::string(field) : fmt::format("{}.{}", path, field);
}

std::vector<Finding> OutOfRange(const pb::Message& message, const std::string& path) {
  std::vector<Finding> found;
  AddOutOfRange(message, path, found);
  return found;
}

}  // namespace intaglio
