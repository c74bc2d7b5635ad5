#include "services/client/machine/corrected_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "services/job/fields/shapes.h"
#include "services/job/machine/machine_axes.h"

namespace intaglio::client {
namespace {

// Decimals of what is written: 1e-7 of a scale is 0.1 um in a metre.
constexpr double kScaleStep = 1e-7, kAngleStep = 1e-7, kLagStep = 1e-7, kPlaceStep = 1e-6;
constexpr double kMaxLagS = 0.1;

double RoundedTo(double value, double step) { return std::round(value / step) * step; }

bool IsFound(double known, const calibrate::Figure& figure) {
  return std::abs(figure.value - known) > figure.interval95;
}

class Corrector {
 public:
  explicit Corrector(const MachineSpec& machine) : before_(machine) {
    corrected_.machine = machine;
  }

  void Scales(const calibrate::Figure& x, const calibrate::Figure& y) {
    const calibrate::KnownGeometry known = KnownGeometryOf(before_);
    if (IsFound(known.x_scale_ratio, x)) {
      LinearAxis& axis = *corrected_.machine.mutable_cartesian()->mutable_x();
      axis.set_scale_ratio(RoundedTo(x.value, kScaleStep));
      Add("cartesian.x.scale_ratio", known.x_scale_ratio, axis.scale_ratio());
    }
    if (IsFound(known.y_scale_ratio, y)) {
      LinearAxis& axis = *corrected_.machine.mutable_cartesian()->mutable_y();
      axis.set_scale_ratio(RoundedTo(y.value, kScaleStep));
      Add("cartesian.y.scale_ratio", known.y_scale_ratio, axis.scale_ratio());
    }
  }

  void Squareness(const calibrate::Figure& found) {
    const double known = before_.cartesian().squareness_xy_rad();
    if (!IsFound(known, found)) return;
    auto& cartesian = *corrected_.machine.mutable_cartesian();
    cartesian.set_squareness_xy_rad(RoundedTo(found.value, kAngleStep));
    Add("cartesian.squareness_xy_rad", known, cartesian.squareness_xy_rad());
  }

  /// One lag for all axes, the mean by their uncertainties; each its own where they
  /// differ or have drives of their own.
  void Lag(const calibrate::Figure& x, const calibrate::Figure& y) {
    const bool differ =
        std::abs(x.value - y.value) > std::hypot(x.interval95, y.interval95);
    if (differ || DriveOfAxis("x") != nullptr || DriveOfAxis("y") != nullptr) {
      OwnLag("x", x);
      OwnLag("y", y);
      return;
    }
    const double wx = 1 / std::max(1e-24, x.interval95 * x.interval95),
                 wy = 1 / std::max(1e-24, y.interval95 * y.interval95);
    const calibrate::Figure mean{(wx * x.value + wy * y.value) / (wx + wy),
                                 1 / std::sqrt(wx + wy)};
    const bool is_lag = before_.drive_case() == MachineSpec::kStageLagS;
    const auto lag_s = CorrectedLag("the axes are", is_lag, before_.stage_lag_s(), mean);
    if (!lag_s) return;
    corrected_.machine.set_stage_lag_s(*lag_s);
    Add("stage_lag_s", before_.stage_lag_s(), *lag_s);
  }

  void Backlash(const char* name, const calibrate::Figure& found) {
    if (!IsFound(0, found)) return;
    if (found.value < 0) {
      corrected_.remarks.push_back(fmt::format(
          "{} comes {:.1f} um too far in both directions: its controller compensates "
          "more backlash than there is; reduce its setting",
          name, -1000 * found.value));
      return;
    }
    corrected_.remarks.push_back(fmt::format(
        "{} has a backlash of {:.1f} um, which no profile corrects: set it in "
        "the motion controller, or tighten the nut",
        name, 1000 * found.value));
  }

  /// The axes at a taught place stay; what they count is another place now.
  void KeepPlaces() {
    MachineSpec& machine = corrected_.machine;
    const auto was = KinematicsOf(before_), is = KinematicsOf(machine);
    const auto keep = [&](Vector3& place) {
      const auto axes = was->ToAxes(Vec3Of(place), Vec3::Zero());
      if (!axes) return;
      const Vec3 kept_mm = is->ToPlace(*axes);
      place.set_x(RoundedTo(kept_mm.x(), kPlaceStep));
      place.set_y(RoundedTo(kept_mm.y(), kPlaceStep));
      place.set_z(RoundedTo(kept_mm.z(), kPlaceStep));
    };
    keep(*machine.mutable_block_origin_mm());
    if (!machine.has_taught()) return;
    for (TaughtZero& zero : *machine.mutable_taught()->mutable_zeros()) {
      keep(*zero.mutable_block_origin_mm());
    }
  }

  CorrectedProfile Take() { return std::move(corrected_); }

 private:
  void Add(const std::string& field, double from, double to) {
    corrected_.corrections.push_back(
        fmt::format("{}: {:.10g} -> {:.10g}", field, from, to));
  }

  /// nullptr: it has that of all axes.
  const AxisDrive* DriveOfAxis(const std::string& name) const {
    const auto& drives = before_.axis_drives();
    const auto found = std::ranges::find(drives, name, &AxisDrive::axis);
    return found == drives.end() ? nullptr : &*found;
  }

  void OwnLag(const std::string& name, const calibrate::Figure& found) {
    const AxisDrive* own = DriveOfAxis(name);
    const bool is_lag = own != nullptr ? own->drive_case() == AxisDrive::kStageLagS
                                       : before_.drive_case() == MachineSpec::kStageLagS;
    const double known_s = own != nullptr ? own->stage_lag_s() : before_.stage_lag_s();
    const auto lag_s = CorrectedLag(name + " is", is_lag, known_s, found);
    if (!lag_s) return;
    auto& drives = *corrected_.machine.mutable_axis_drives();
    const auto place = std::ranges::find(drives, name, &AxisDrive::axis);
    AxisDrive& drive = place == drives.end() ? *drives.Add() : *place;
    drive.set_axis(name);
    drive.set_stage_lag_s(*lag_s);
    Add("axis_drives: " + name + ": stage_lag_s", known_s, *lag_s);
  }

  /// `known_s` with what was found; nothing when it is as it should be, or with a remark
  /// when no lag of a profile corrects it.
  std::optional<double> CorrectedLag(const std::string& whose, bool is_lag,
                                     double known_s, const calibrate::Figure& found) {
    if (!IsFound(0, found)) return std::nullopt;
    if (!is_lag) {
      corrected_.remarks.push_back(fmt::format(
          "{} {:.0f} us later than the drive of the profile compensates: identify its "
          "parameters again, intaglio drive identify",
          whose, 1e6 * found.value));
      return std::nullopt;
    }
    const double lag_s = known_s + found.value;
    if (lag_s >= 0 && lag_s <= kMaxLagS) return RoundedTo(lag_s, kLagStep);
    corrected_.remarks.push_back(
        fmt::format("a lag of {:.0f} us is outside what a profile can have: check that "
                    "the marks were made by this profile",
                    1e6 * lag_s));
    return std::nullopt;
  }

  const MachineSpec& before_;
  CorrectedProfile corrected_;
};

}  // namespace

CorrectedProfile Correct(const MachineSpec& machine, const calibrate::MachineFit& fit) {
  Corrector corrector(machine);
  const auto& [x, y] = fit.axes;
  corrector.Scales(x.scale_ratio, y.scale_ratio);
  corrector.Squareness(fit.squareness_rad);
  corrector.Lag(x.lag_s, y.lag_s);
  corrector.Backlash("x", x.backlash_mm);
  corrector.Backlash("y", y.backlash_mm);
  corrector.KeepPlaces();
  return corrector.Take();
}

calibrate::KnownGeometry KnownGeometryOf(const MachineSpec& machine) {
  const CartesianKinematics& cartesian = machine.cartesian();
  const auto scale = [](const LinearAxis& axis) {
    return axis.has_scale_ratio() ? axis.scale_ratio() : 1;
  };
  return {scale(cartesian.x()), scale(cartesian.y()), cartesian.squareness_xy_rad()};
}

}  // namespace intaglio::client
