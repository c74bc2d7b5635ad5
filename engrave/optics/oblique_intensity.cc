#include "engrave/optics/oblique_intensity.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "engrave/core/check.h"
#include "engrave/optics/oblique_focus.h"

// The beam is a cone of plane waves around the chief ray, with the amplitude exp(-r^2),
// r = 1 at 1/e^2, cut at r = 1.6, all in phase at the focus that it would have in air, a
// height h below the face. A wave of the direction (p, s, w) in air, a unit vector, keeps
// k p and k s at the face. Its phase at (x, 0, z) of the glass is
//   k (p x + z sqrt(n^2 - p^2 - s^2) - h w),
// x from the axis of the lens through that focus. The intensity is |sum|^2. By symmetry
// the peak lies in the plane of incidence. Along z there may be two peaks, one at each
// line focus, so z is scanned first; x follows the centroid of the rays.

namespace intaglio::optics {
namespace {

using std::numbers::pi;
constexpr double kEdge = 1.6;  // of the cone, in its 1/e^2 radii
constexpr int kBeside = 8;

struct Wave {
  double weight = 0;
  double across = 0;    // k p, 1/mm
  double in_glass = 0;  // k sqrt(n^2 - p^2 - s^2)
  double at_focus = 0;  // k w h
  double slope = 0;     // dx/dz of its ray in the glass
  double start_mm = 0;  // x of its ray at the face
};

struct Cone {
  std::vector<Wave> waves;
  double z_from_mm = 0, z_to_mm = 0;  // where the peak can be
  double rayleigh_mm = 0;
  double spot_mm = 0;  // radius at 1/e^2

  double IntensityAt(double x_mm, double z_mm) const {
    return AlongX(x_mm, 0, z_mm, 1).front();
  }

  /// At `count` places from x_mm on, each `step_mm` from the one before.
  std::vector<double> AlongX(double x_mm, double step_mm, double z_mm,
                             std::size_t count) const {
    std::vector<std::complex<double>> sums(count);
    for (const Wave& wave : waves) {
      std::complex<double> field = std::polar(
          wave.weight, wave.across * x_mm + wave.in_glass * z_mm - wave.at_focus);
      const std::complex<double> turn = std::polar(1.0, wave.across * step_mm);
      for (auto& sum : sums) {
        sum += field;
        field *= turn;
      }
    }
    std::vector<double> intensities(count);
    std::ranges::transform(
        sums, intensities.begin(),
        [](const std::complex<double>& sum) { return std::norm(sum); });
    return intensities;
  }

  double CentroidMm(double z_mm) const {
    double sum_mm = 0, weights = 0;
    for (const Wave& wave : waves) {
      sum_mm += wave.weight * (wave.start_mm + wave.slope * z_mm);
      weights += wave.weight;
    }
    return sum_mm / weights;
  }
};

/// `head_mm`: h. Rings of equal area and spokes over half of the cone, whose other half
/// is its mirror image.
Cone ConeOf(const FocusedBeam& beam, double tangent, double head_mm, int rings) {
  const double k = 2 * pi / beam.wavelength_mm, n = beam.refractive_index;
  const double cosine = 1 / std::hypot(1, tangent), sine = tangent * cosine;
  const double spread = std::tan(std::asin(beam.numerical_aperture));
  Cone cone;
  cone.rayleigh_mm = RayleighRangeMm(beam);
  cone.spot_mm = beam.wavelength_mm / (pi * beam.numerical_aperture);
  cone.waves.reserve(static_cast<std::size_t>(rings * rings));
  for (int ring = 0; ring < rings; ++ring) {
    const double r = kEdge * std::sqrt((ring + 0.5) / rings);
    for (int spoke = 0; spoke < rings; ++spoke) {
      const double angle = pi * (spoke + 0.5) / rings;
      const double a = spread * r * std::cos(angle), b = spread * r * std::sin(angle);
      Vec3 way(sine + a * cosine, b, cosine - a * sine);
      way.normalize();
      const double along = std::sqrt(n * n - way.head<2>().squaredNorm());
      cone.waves.push_back({std::exp(-r * r), k * way.x(), k * along,
                            k * way.z() * head_mm, way.x() / along,
                            -way.x() / way.z() * head_mm});
    }
  }
  return cone;
}

/// The greatest of three equidistant values' parabola, and where, in steps.
double PeakStep(double before, double at, double after) {
  const double bend = before - 2 * at + after;
  return bend < 0 ? std::clamp(0.5 * (before - after) / bend, -1.0, 1.0) : 0;
}

/// Climbs from a place, by parabolas whose steps shrink.
double ClimbFrom(const Cone& cone, const Vec2& from_mm) {
  double x_mm = from_mm.x(), z_mm = from_mm.y();
  double dx_mm = 0.4 * cone.spot_mm, dz_mm = 0.3 * cone.rayleigh_mm;
  double best = cone.IntensityAt(x_mm, z_mm);
  const double slope = cone.CentroidMm(1) - cone.CentroidMm(0);
  for (int round = 0; round < 6; ++round) {
    const double x_step = PeakStep(cone.IntensityAt(x_mm - dx_mm, z_mm), best,
                                   cone.IntensityAt(x_mm + dx_mm, z_mm));
    x_mm += x_step * dx_mm;
    best = cone.IntensityAt(x_mm, z_mm);
    const auto along = [&](double by_mm) {
      return cone.IntensityAt(x_mm + slope * by_mm, z_mm + by_mm);
    };
    const double by_mm = dz_mm * PeakStep(along(-dz_mm), best, along(dz_mm));
    x_mm += slope * by_mm;
    z_mm += by_mm;
    best = cone.IntensityAt(x_mm, z_mm);
    dx_mm *= 0.6;
    dz_mm *= 0.6;
  }
  return best;
}

double PeakOf(const FocusedBeam& beam, double tangent, double depth_mm) {
  const LineFoci foci = FociAtDepth(depth_mm, tangent, beam.refractive_index);
  const double n = beam.refractive_index;
  const double q = tangent * tangent * (1 - 1 / (n * n));
  const double head_mm = foci.sagittal_mm / (n * std::sqrt(1 + q));
  const double split = foci.apart_mm() / RayleighRangeMm(beam);
  const int rings = std::clamp(static_cast<int>(18 + 1.6 * split), 20, 72);
  const Cone cone = ConeOf(beam, tangent, head_mm, rings);
  // Spherical aberration moves the peak down by less than the spread of the marginal ray.
  const double lower_mm =
      2 * depth_mm * beam.numerical_aperture * beam.numerical_aperture * kEdge * kEdge;
  const double from_mm = foci.sagittal_mm - cone.rayleigh_mm;
  const double to_mm = foci.tangential_mm + cone.rayleigh_mm + lower_mm;
  const int steps = std::max(
      8, static_cast<int>(std::ceil((to_mm - from_mm) / (0.4 * cone.rayleigh_mm))));
  // Coma puts the peak up to some spots beside the centroid.
  const double beside_mm = 0.5 * cone.spot_mm;
  double best = 0;
  Vec2 best_mm = Vec2::Zero();
  for (int i = 0; i <= steps; ++i) {
    const double z_mm = std::lerp(from_mm, to_mm, static_cast<double>(i) / steps);
    const double first_mm = cone.CentroidMm(z_mm) - kBeside * beside_mm;
    const auto found = cone.AlongX(first_mm, beside_mm, z_mm, 2 * kBeside + 1);
    const auto highest = std::ranges::max_element(found);
    if (*highest <= best) continue;
    best = *highest;
    best_mm = {first_mm + beside_mm * static_cast<double>(highest - found.begin()), z_mm};
  }
  double weights = 0;
  for (const Wave& wave : cone.waves) weights += wave.weight;
  return ClimbFrom(cone, best_mm) / (weights * weights);
}

constexpr int kDepths = 8, kTangents = 20;

}  // namespace

double RayleighRangeMm(const FocusedBeam& beam) {
  Require(beam.wavelength_mm > 0 && beam.numerical_aperture >= 0.001 &&
              beam.numerical_aperture <= 0.3 && beam.refractive_index >= 1,
          "a beam of wavelength {} mm, aperture {}, index {}", beam.wavelength_mm,
          beam.numerical_aperture, beam.refractive_index);
  return beam.refractive_index * beam.wavelength_mm /
         (pi * beam.numerical_aperture * beam.numerical_aperture);
}

// In the middle 1 / (1 + (D / 2 z)^2), at a line focus 1 / sqrt(1 + (D / z)^2), z the
// Rayleigh range: equal at D = 2 sqrt(2) z.
bool HasTwoStrongFoci(const FocusedBeam& beam, double apart_mm) {
  return apart_mm > 2 * std::numbers::sqrt2 * RayleighRangeMm(beam);
}

double ObliquePeakRatio(const FocusedBeam& beam, double tangent, double depth_mm) {
  Require(tangent >= 0 && tangent <= 1 && depth_mm >= 0, "tangent {} at depth {} mm",
          tangent, depth_mm);
  if (tangent == 0 || depth_mm == 0 || beam.refractive_index == 1) return 1;
  return std::min(1.0, PeakOf(beam, tangent, depth_mm) / PeakOf(beam, 0, depth_mm));
}

ObliqueLoss::ObliqueLoss(const FocusedBeam& beam, double max_depth_mm, double max_tangent)
    : max_depth_mm_(max_depth_mm), max_tangent_(max_tangent) {
  Require(max_depth_mm > 0 && max_tangent > 0 && max_tangent <= 1,
          "max_depth_mm {}, max_tangent {}", max_depth_mm, max_tangent);
  for (int d = 1; d <= kDepths; ++d) {
    const double depth_mm = max_depth_mm * d * d / (kDepths * kDepths);
    const double upright = PeakOf(beam, 0, depth_mm);
    for (int t = 1; t <= kTangents; ++t) {
      const double tangent = max_tangent * t / kTangents;
      const double ratio = std::min(1.0, PeakOf(beam, tangent, depth_mm) / upright);
      const double scale = tangent * depth_mm;
      excess_.push_back((1 / ratio - 1) / (scale * scale));
    }
  }
}

/// By their numbers in the table, from 1; below 1 the first one holds.
double ObliqueLoss::ExcessAt(int depth, int tangent) const {
  const int row = std::clamp(depth, 1, kDepths) - 1;
  const int column = std::clamp(tangent, 1, kTangents) - 1;
  return excess_[static_cast<std::size_t>(row * kTangents + column)];
}

double ObliqueLoss::RatioAt(double tangent, double depth_mm) const {
  tangent = std::clamp(tangent, 0.0, max_tangent_);
  depth_mm = std::clamp(depth_mm, 0.0, max_depth_mm_);
  const double d = std::sqrt(depth_mm / max_depth_mm_) * kDepths;
  const double t = tangent / max_tangent_ * kTangents;
  const int row = static_cast<int>(d), column = static_cast<int>(t);
  const auto along = [&](int at_row) {
    return std::lerp(ExcessAt(at_row, column), ExcessAt(at_row, column + 1), t - column);
  };
  const double excess = std::lerp(along(row), along(row + 1), d - row);
  const double scale = tangent * depth_mm;
  return 1 / (1 + excess * scale * scale);
}

double ObliqueLoss::MaxTangent(double depth_mm, double min_ratio) const {
  if (RatioAt(max_tangent_, depth_mm) >= min_ratio) return max_tangent_;
  double low = 0, high = max_tangent_;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (RatioAt(middle, depth_mm) >= min_ratio ? low : high) = middle;
  }
  return low;
}

}  // namespace intaglio::optics
