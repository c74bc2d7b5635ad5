#include "engrave/galvo/grid_sense.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "engrave/core/counted.h"

namespace intaglio::galvo {
namespace {

constexpr double kMaxTurnDeg = 15;
constexpr double kMinScale = 0.5, kMaxScale = 2;
constexpr double kMaxAxesRatio = 1.25;
constexpr double kMaxLeftOutShare = 0.2;
constexpr double kMaxLeftShare = 0.003;  // of the field; distortions are 1 to 4 %
constexpr double kDegPerRad = 180 / std::numbers::pi;

/// measured = linear command + offset; nothing of marks on a line.
std::optional<Eigen::Matrix2d> LinearPart(std::span<const GridMark> marks) {
  Vec2 command_mm = Vec2::Zero(), measured_mm = Vec2::Zero();
  const auto count = static_cast<double>(marks.size());
  for (const GridMark& mark : marks) {
    command_mm += mark.command_mm / count;
    measured_mm += mark.measured_mm / count;
  }
  Eigen::Matrix2d of_commands = Eigen::Matrix2d::Zero(), of_both = of_commands;
  for (const GridMark& mark : marks) {
    const Vec2 u = mark.command_mm - command_mm;
    of_commands += u * u.transpose();
    of_both += (mark.measured_mm - measured_mm) * u.transpose();
  }
  const double trace = of_commands.trace();
  if (!(of_commands.determinant() > 1e-9 * trace * trace)) return std::nullopt;
  return of_both * of_commands.inverse();
}

Status FailSense(const std::string& what) { return Fail(ErrorCode::kInvalidValue, what); }

}  // namespace

Status CheckGridSense(std::span<const GridMark> marks) {
  const auto linear = LinearPart(marks);
  if (!linear) return {};
  const Eigen::Matrix2d& a = *linear;
  if (a.determinant() < 0) {
    const bool swapped = std::abs(a(0, 1) * a(1, 0)) > std::abs(a(0, 0) * a(1, 1));
    if (swapped)
      return FailSense(
          "measured x follows the commanded y, and y the x: the two are swapped; "
          "exchange "
          "the columns of measured x and y");
    return FailSense(fmt::format(
        "measured {} runs against the commanded one: the picture is mirrored; "
        "measure from the side of the beam, or change the sign of the column",
        a(0, 0) < 0 ? "x" : "y"));
  }
  const double turn_deg = kDegPerRad * std::atan2(a(1, 0) - a(0, 1), a(0, 0) + a(1, 1));
  if (std::abs(turn_deg) > kMaxTurnDeg) {
    return FailSense(fmt::format(
        "the measured marks are turned by {:.0f} degrees against their commands; turn "
        "the "
        "piece, or give --nodes and --pitch, which find how it lies (limit: {:.0f})",
        turn_deg, kMaxTurnDeg));
  }
  const double x_scale = a.col(0).norm(), y_scale = a.col(1).norm();
  const auto [low, high] = std::minmax(x_scale, y_scale);
  if (low < kMinScale || high > kMaxScale) {
    return FailSense(fmt::format(
        "the measured marks are {:.4g} times as far apart in x and {:.4g} times in y as "
        "commanded; give both in mm, and the pixel and the field as they are",
        x_scale, y_scale));
  }
  if (high > kMaxAxesRatio * low) {
    return FailSense(fmt::format(
        "measured y is {:.4g} times as wide as x; a head is within {:.4g}..{:.4g}: check "
        "the scale of both measured axes",
        y_scale / x_scale, 1 / kMaxAxesRatio, kMaxAxesRatio));
  }
  return {};
}

Status CheckFitSense(const HeadFit& fit, double width_mm) {
  const auto left_out = std::ranges::count(fit.used, false);
  const auto count = static_cast<double>(fit.used.size());
  if (static_cast<double>(left_out) > kMaxLeftOutShare * count) {
    return FailSense(fmt::format(
        "{} of {} {} far from where the others put them; check which mark belongs "
        "to which command, and measure again",
        left_out, Counted(fit.used.size(), "mark"),
        IsOrAre(static_cast<std::uint64_t>(left_out))));
  }
  if (fit.sigma_mm > kMaxLeftShare * width_mm) {
    return FailSense(fmt::format(
        "the fit leaves {:.0f} um rms of a coordinate, {:.2g} % of the field: these "
        "marks "
        "are not those of their commands; check order, units and columns of the table",
        1000 * fit.sigma_mm, 100 * fit.sigma_mm / width_mm));
  }
  return {};
}

}  // namespace intaglio::galvo
