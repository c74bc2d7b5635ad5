#include "services/job/files/lightburn_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace intaglio {
namespace {

constexpr double kMaxDifferenceRatio = 0.02, kUmPerMm = 1000, kSmallestNamedUm = 0.5;

// A command of half the workspace, w / 2, goes to w / 2 (field / field_mm) of an axis
// whose own field is `field`: field_mm is the mean, so both axes are wrong by as much.
std::string FieldSentence(const LightBurnDevice& device, double x_field_mm,
                          double y_field_mm, double field_mm) {
  std::string sentence = fmt::format(
      "scan_head.field_mm = {:.6g}: {:g} x {:g} mm over the scales {:.6g} (x) and {:.6g} "
      "(y)",
      field_mm, device.width_mm, device.height_mm, device.x_scale_ratio,
      device.y_scale_ratio);
  const double beside_um =
      std::abs(x_field_mm / field_mm - 1) * device.width_mm / 2 * kUmPerMm;
  if (beside_um < kSmallestNamedUm) return sentence;
  return sentence +
         fmt::format(
             "; it is the mean, so at the border x is {:.0f} um too {} and y as "
             "much too {}: a correction file corrects it",
             beside_um, x_field_mm < y_field_mm ? "near" : "far",
             x_field_mm < y_field_mm ? "far" : "near");
}

void SetTravel(double workspace_mm, double field_mm, const char* axis, AxisLimits& limits,
               std::vector<std::string>& sentences) {
  const double half_mm = std::min(workspace_mm, field_mm) / 2;
  limits.set_travel_min_mm(-half_mm);
  limits.set_travel_max_mm(half_mm);
  sentences.push_back(
      fmt::format("{0}.travel_min_mm = {1:.6g}, {0}.travel_max_mm = {2:.6g}"
                  ": the workspace",
                  axis, -half_mm, half_mm));
}

void SetJumps(double jump_mm_s, MachineSpec& machine,
              std::vector<std::string>& sentences) {
  machine.mutable_scan_head()->set_jump_mm_s(jump_mm_s);
  sentences.push_back(
      fmt::format("scan_head.jump_mm_s = {:g}: Default_JumpSpeed", jump_mm_s));
  if (!machine.head_over_block().has_jump_and_dwell()) return;
  machine.mutable_head_over_block()->mutable_jump_and_dwell()->set_jump_mm_s(jump_mm_s);
  sentences.push_back(fmt::format(
      "head_over_block.jump_and_dwell.jump_mm_s = {:g}: Default_JumpSpeed", jump_mm_s));
}

void SetFrequency(const LightBurnDevice& device, BjjczBoard& board,
                  std::vector<std::string>& sentences) {
  if (!board.has_point_frequency_hz() || (!device.min_pulse_hz && !device.max_pulse_hz))
    return;
  double frequency_hz = board.point_frequency_hz();
  if (device.max_pulse_hz) frequency_hz = std::min(frequency_hz, *device.max_pulse_hz);
  if (device.min_pulse_hz) frequency_hz = std::max(frequency_hz, *device.min_pulse_hz);
  board.set_point_frequency_hz(frequency_hz);
  const auto shown = [](const std::optional<double>& hz) {
    return hz ? fmt::format("{:g}", *hz) : std::string("?");
  };
  sentences.push_back(fmt::format(
      "bjjcz_board.point_frequency_hz = {:g}: within Laser_MinFreq and Laser_MaxFreq, {} "
      "and {} Hz",
      frequency_hz, shown(device.min_pulse_hz), shown(device.max_pulse_hz)));
}

}  // namespace

Result<std::vector<std::string>> ApplyDevice(const LightBurnDevice& device,
                                             MachineSpec& machine) {
  if (!machine.has_bjjcz_board() || !machine.has_scan_head()) {
    return Fail(ErrorCode::kInvalidValue,
                "the family has no bjjcz_board, and the device is one of a BJJCZ board; "
                "choose bjjcz (marks) or bjjcz-glass (points in glass)");
  }
  const double x_field_mm = device.width_mm / device.x_scale_ratio;
  const double y_field_mm = device.height_mm / device.y_scale_ratio;
  const double field_mm = (x_field_mm + y_field_mm) / 2;
  if (std::abs(x_field_mm - y_field_mm) > kMaxDifferenceRatio * field_mm) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("Width over its scale is {:.6g} mm, Height over its scale "
                            "{:.6g} mm; a profile has one scan_head.field_mm: make Width "
                            "and Height equal in LightBurn, or use a correction file",
                            x_field_mm, y_field_mm));
  }
  std::vector<std::string> sentences;
  machine.mutable_scan_head()->set_field_mm(field_mm);
  sentences.push_back(FieldSentence(device, x_field_mm, y_field_mm, field_mm));
  if (machine.has_head_over_block()) {
    SetTravel(device.width_mm, field_mm, "x", *machine.mutable_x(), sentences);
    SetTravel(device.height_mm, field_mm, "y", *machine.mutable_y(), sentences);
  }
  if (device.jump_mm_s) SetJumps(*device.jump_mm_s, machine, sentences);
  SetFrequency(device, *machine.mutable_bjjcz_board(), sentences);
  return sentences;
}

}  // namespace intaglio
