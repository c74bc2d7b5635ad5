#include "engrave/course/tracking.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>

#include "engrave/core/check.h"
#include "engrave/course/axis_filter.h"

namespace intaglio::course {
namespace {

/// How often the slowest lag passes until a transient is below a thousandth of its begin.
constexpr double kSettleLags = 8;

/// What is left of a difference of the axes' states when it has no effect any more.
constexpr double kForgottenRatio = 1e-9;
constexpr double kMaxMemory = 1e9;

using Axis = std::vector<double>;

std::array<Axis, 2> Split(std::span<const Vec2> points) {
  std::array<Axis, 2> axes{Axis(points.size()), Axis(points.size())};
  for (std::size_t i = 0; i < points.size(); ++i) {
    axes[0][i] = points[i].x();
    axes[1][i] = points[i].y();
  }
  return axes;
}

std::vector<Vec2> Join(const Axis& x, const Axis& y) {
  std::vector<Vec2> points(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) points[i] = {x[i], y[i]};
  return points;
}

/// The first derivative by central differences, of second order next to the ends.
void Differentiate(const Axis& f, double period_s, Axis& out) {
  const std::size_t n = f.size();
  out.resize(n);
  if (n < 2) {
    std::fill(out.begin(), out.end(), 0.0);
    return;
  }
  out[0] = (f[1] - f[0]) / period_s;
  out[n - 1] = (f[n - 1] - f[n - 2]) / period_s;
  if (n < 3) return;
  out[1] = (f[2] - f[0]) / (2 * period_s);
  out[n - 2] = (f[n - 1] - f[n - 3]) / (2 * period_s);
  const double k = 1 / (12 * period_s);
  for (std::size_t i = 2; i + 2 < n; ++i)
    out[i] = k * (8 * (f[i + 1] - f[i - 1]) - (f[i + 2] - f[i - 2]));
}

/// Adds the greater size of the two axes' n-th derivative to what is there.
void TakeGreater(const Axis& values, double period_s, int derivative, Axis& greatest) {
  Axis d = values, next;
  for (int i = 0; i < derivative; ++i) {
    Differentiate(d, period_s, next);
    d.swap(next);
  }
  greatest.resize(values.size(), 0);
  for (std::size_t i = 0; i < d.size(); ++i)
    greatest[i] = std::max(greatest[i], std::abs(d[i]));
}

/// A derivative of n-th order is off 2 n instants beside the ends: 16 are enough for the
/// setpoints, and for motor and jerk.
constexpr std::size_t kEdgeInstants = 2 * (AxisFilter::kMaxOrder + 2);

Part Widened(const Part& part, std::size_t before, std::size_t behind,
             const Instants& instants) {
  return {part.begin - std::min(part.begin, before),
          std::min(part.end + behind, instants.count)};
}

/// Keeps `count` instants from `first` on.
void Trim(Tracked& tracked, std::size_t first, std::size_t count) {
  const auto keep = [&](auto& values) {
    if (values.empty()) return;
    values.resize(first + count);
    values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(first));
  };
  tracked.first_s += tracked.period_s * static_cast<double>(first);
  keep(tracked.commanded_s_mm);
  keep(tracked.setpoints_mm);
  keep(tracked.actual_mm);
  keep(tracked.motor_mm_s2);
  keep(tracked.jerk_mm_s3);
}

double GreaterLag(const AxisPair& axes) {
  return std::max(axes[0].lag_s(), axes[1].lag_s());
}

}  // namespace

SplineKernel SplineKernel::Of(double length_s, int boxes, double period_s) {
  const int periods = static_cast<int>(std::floor(length_s / boxes / period_s));
  return {boxes, std::max(1, periods - 1 + periods % 2), period_s};
}

std::vector<double> SplineKernel::Weights() const {
  std::vector<double> weights{1};
  for (int i = 0; i < boxes; ++i) {
    std::vector<double> wider(weights.size() + static_cast<std::size_t>(box - 1), 0);
    for (std::size_t k = 0; k < weights.size(); ++k)
      for (std::size_t j = 0; j < static_cast<std::size_t>(box); ++j)
        wider[k + j] += weights[k] / box;
    weights = std::move(wider);
  }
  return weights;
}

std::vector<double> Smoothed(const SplineKernel& kernel,
                             std::span<const double> reference) {
  std::vector<double> f(reference.begin(), reference.end());
  const auto box = static_cast<std::size_t>(kernel.box);
  const double share = 1 / static_cast<double>(box);
  for (int pass = 0; pass < kernel.boxes && box > 1; ++pass) {
    double sum = 0;
    for (std::size_t i = 0; i < box - 1; ++i) sum += f[i];
    const std::size_t count = f.size() - (box - 1);
    for (std::size_t i = 0; i < count; ++i) {
      sum += f[i + box - 1];
      const double oldest = f[i];
      f[i] = sum * share;
      sum -= oldest;
    }
    f.resize(count);
  }
  return f;
}

std::vector<double> ApplyPolynomial(std::span<const double> coefficients, double period_s,
                                    std::span<const double> values) {
  Axis d(values.begin(), values.end()), next;
  Axis sum = d;
  for (double& x : sum) x *= coefficients.front();
  for (std::size_t k = 1; k < coefficients.size(); ++k) {
    Differentiate(d, period_s, next);
    d.swap(next);
    if (coefficients[k] == 0) continue;
    for (std::size_t i = 0; i < d.size(); ++i) sum[i] += coefficients[k] * d[i];
  }
  return sum;
}

Tracking::Tracking(const AxisPair& axes, const TrackingOptions& options)
    : axes_(axes), options_(options) {
  Require(options.period_s >= 1e-5 && options.period_s <= 0.1,
          "period_s {} is outside 1e-5..0.1", options.period_s);
  Require(options.smooth_s >= 0, "smooth_s {} is negative", options.smooth_s);
  if (!options.kernel_s) return;
  Require(*options.kernel_s > 0, "kernel_s {} is not positive", *options.kernel_s);
  const auto order = std::max(axes[0].product().size(), axes[1].product().size()) - 1;
  kernel_ = SplineKernel::Of(*options.kernel_s, std::max(3, static_cast<int>(order)),
                             options.period_s);
}

double Tracking::memory_s() const {
  const double own_s = options_.smooth_s / 2;
  return own_s +
         (compensated() ? kernel_.length_s() / 2 : kSettleLags * GreaterLag(axes_));
}

SearchWindow Tracking::WindowFor(double speed_mm_s, double tolerance_mm) const {
  const double half_mm = speed_mm_s * (kernel_.length_s() + options_.smooth_s) / 2;
  if (compensated()) return {half_mm + 20 * tolerance_mm, half_mm + 20 * tolerance_mm};
  return {2.5 * speed_mm_s * GreaterLag(axes_) + 20 * tolerance_mm, 10 * tolerance_mm};
}

void Tracking::Compensate(Tracked& tracked, bool with_setpoints) const {
  const auto reference = Split(tracked.actual_mm);
  std::array<Axis, 2> load, setpoints;
  for (std::size_t i = 0; i < 2; ++i) {
    load[i] = Smoothed(kernel_, reference[i]);
    if (with_setpoints)
      setpoints[i] = ApplyPolynomial(axes_[i].product(), options_.period_s, load[i]);
  }
  tracked.actual_mm = Join(load[0], load[1]);
  if (with_setpoints) tracked.setpoints_mm = Join(setpoints[0], setpoints[1]);
}

Instants Tracking::InstantsOf(const SpeedLaw& law, const AxisPair& real,
                              Exactness exactness) const {
  const double h = options_.period_s;
  const bool exact = !compensated() || exactness == Exactness::kAxes;
  const double settle_s = exact ? kSettleLags * GreaterLag(real) : 0;
  const double margin_s =
      (compensated() ? kernel_.length_s() : 0) / 2 + options_.smooth_s / 2 + 3 * h;
  // Whole periods, so that the instants do not depend on the margin.
  const auto before = static_cast<std::size_t>(std::ceil(margin_s / h));
  const auto behind =
      static_cast<std::size_t>(std::ceil((law.duration_s + margin_s + settle_s) / h)) + 1;
  return {-h * static_cast<double>(before) - std::fmod(law.begin_s, h),
          before + behind + 1};
}

std::vector<Part> PartsOf(const Instants& instants) {
  std::vector<Part> parts;
  for (std::size_t begin = 0; begin < instants.count; begin += kPartInstants)
    parts.push_back({begin, std::min(begin + kPartInstants, instants.count)});
  return parts;
}

Tracked Tracking::Reference(const Path& path, const SpeedLaw& law,
                            const Instants& instants, const Part& part) const {
  const double h = options_.period_s;
  Tracked tracked;
  tracked.period_s = h;
  tracked.first_s = instants.first_s + h * static_cast<double>(part.begin);
  const std::size_t count = part.end - part.begin;
  const std::size_t half = compensated() ? kernel_.half_count() : 0;
  const auto s_mm = SampleLaw(law, h, tracked.first_s - h * static_cast<double>(half),
                              count + 2 * half, options_.smooth_s);
  PathCursor cursor(path);
  tracked.actual_mm.reserve(s_mm.size());
  for (const double s : s_mm) tracked.actual_mm.push_back(cursor.PointAt(s));
  AddSwings(path, law, tracked.first_s - h * static_cast<double>(half), h,
            tracked.actual_mm);
  tracked.commanded_s_mm.assign(s_mm.begin() + static_cast<std::ptrdiff_t>(half),
                                s_mm.end() - static_cast<std::ptrdiff_t>(half));
  return tracked;
}

Tracked Tracking::RoughSetpoints(const Path& path, const SpeedLaw& law,
                                 const Instants& instants, const Part& part,
                                 bool with_setpoints) const {
  Tracked tracked = Reference(path, law, instants, part);
  if (compensated()) {
    Compensate(tracked, with_setpoints);
  } else {
    tracked.setpoints_mm = tracked.actual_mm;
  }
  return tracked;
}

Tracked Tracking::SetpointsOf(const Path& path, const SpeedLaw& law,
                              const Instants& instants, const Part& part) const {
  const Part wider = Widened(part, kEdgeInstants, kEdgeInstants, instants);
  Tracked tracked = RoughSetpoints(path, law, instants, wider, true);
  Trim(tracked, part.begin - wider.begin, part.end - part.begin);
  return tracked;
}

void Tracking::AddMotor(Tracked& tracked, bool with_jerk) const {
  // Compensated, the load is the smoothed reference and the motor ahead of it.
  const auto from = Split(compensated() ? tracked.actual_mm : tracked.setpoints_mm);
  for (std::size_t i = 0; i < 2; ++i) {
    Axis motor(from[i].size());
    if (compensated()) {
      motor = ApplyPolynomial(axes_[i].mechanics(), options_.period_s, from[i]);
      if (with_jerk) TakeGreater(from[i], options_.period_s, 3, tracked.jerk_mm_s3);
    } else {
      AxisFilter(axes_[i].loop(), options_.period_s).Run(from[i], motor);
    }
    TakeGreater(motor, options_.period_s, 2, tracked.motor_mm_s2);
  }
}

Tracked Tracking::Follow(const Path& path, const SpeedLaw& law, const AxisPair& real,
                         Exactness exactness, bool with_motor, bool with_jerk) const {
  const Instants instants = InstantsOf(law, real, exactness);
  return FollowPart(path, law, real, exactness, with_motor, with_jerk, instants,
                    {0, instants.count});
}

Tracked Tracking::FollowPart(const Path& path, const SpeedLaw& law, const AxisPair& real,
                             Exactness exactness, bool with_motor, bool with_jerk,
                             const Instants& instants, const Part& part) const {
  const bool exact = !compensated() || exactness == Exactness::kAxes;
  std::size_t memory = exact ? MemoryInstants(real, options_.period_s) : 0;
  if (!compensated()) memory = std::max(memory, MemoryInstants(axes_, options_.period_s));
  const Part wider =
      Widened(part, memory + 2 * kEdgeInstants, 2 * kEdgeInstants, instants);
  Tracked tracked = RoughSetpoints(path, law, instants, wider, exact);
  // The setpoints at the ends are rough: no axis begins there.
  const Part inner = Widened(part, memory + kEdgeInstants, kEdgeInstants, instants);
  Trim(tracked, inner.begin - wider.begin, inner.end - inner.begin);
  if (with_motor) AddMotor(tracked, with_jerk);
  if (exact) {
    tracked.actual_mm = RunAxes(real, options_.period_s, tracked.setpoints_mm);
    if (with_motor && with_jerk && !compensated()) {
      for (const Axis& axis : Split(tracked.actual_mm))
        TakeGreater(axis, options_.period_s, 3, tracked.jerk_mm_s3);
    }
  }
  Trim(tracked, part.begin - inner.begin, part.end - part.begin);
  return tracked;
}

std::size_t MemoryInstants(const AxisPair& real, double period_s) {
  double slowest_rad_s = std::numeric_limits<double>::infinity();
  for (const AxisDynamics& axis : real)
    for (const std::complex<double>& pole : axis.poles())
      slowest_rad_s = std::min(slowest_rad_s, -pole.real());
  const double forgotten_s = -std::log(kForgottenRatio) / slowest_rad_s;
  return static_cast<std::size_t>(
      std::ceil(std::min(forgotten_s / period_s, kMaxMemory)));
}

std::vector<Vec2> RunAxes(const AxisPair& real, double period_s,
                          std::span<const Vec2> setpoints_mm) {
  const auto setpoints = Split(setpoints_mm);
  std::array<Axis, 2> actual;
  for (std::size_t i = 0; i < 2; ++i) {
    actual[i].resize(setpoints[i].size());
    AxisFilter(real[i].product(), period_s).Run(setpoints[i], actual[i]);
  }
  return Join(actual[0], actual[1]);
}

}  // namespace intaglio::course
