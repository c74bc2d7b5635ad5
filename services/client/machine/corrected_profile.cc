#include "services/client/machine/corrected_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "services/job/machine/machine_axes.h"
#include "services/job/options.h"

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

  /// One lag for all axes: the mean, by their uncertainties.
  void Lag(const calibrate::Figure& x, const calibrate::Figure& y) {
    const double wx = 1 / std::max(1e-24, x.interval95 * x.interval95),
                 wy = 1 / std::max(1e-24, y.interval95 * y.interval95);
    const calibrate::Figure mean{(wx * x.value + wy * y.value) / (wx + wy),
                                 1 / std::sqrt(wx + wy)};
    if (std::abs(x.value - y.value) > std::hypot(x.interval95, y.interval95)) {
      corrected_.remarks.push_back(fmt::format(
          "x and y are late by different times, {:.0f} and {:.0f} us, and a profile has "
          "one lag: tune the drives alike",
          1e6 * x.value, 1e6 * y.value));
    }
    if (!IsFound(0, mean)) return;
    if (before_.drive_case() != MachineSpec::kStageLagS) {
      corrected_.remarks.push_back(fmt::format(
          "the axes are {:.0f} us later than the drive of the profile compensates: "
          "identify its parameters again",
          1e6 * mean.value));
      return;
    }
    const double lag_s = before_.stage_lag_s() + mean.value;
    if (lag_s < 0 || lag_s > kMaxLagS) {
      corrected_.remarks.push_back(
          fmt::format("a lag of {:.0f} us is outside what a profile can have: check that "
                      "the marks were made by this profile",
                      1e6 * lag_s));
      return;
    }
    corrected_.machine.set_stage_lag_s(RoundedTo(lag_s, kLagStep));
    Add("stage_lag_s", before_.stage_lag_s(), corrected_.machine.stage_lag_s());
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
