#pragma once

// From a speed law to the course of the axes: the reference along the path, the setpoints
// that the controller gets, and what the axes make of them.
//
// Direct: the setpoints are the reference. Compensated: the reference goes through a
// spline kernel (several equal boxes, their number the order of the axes, 3 or more), the
// same for all axes, and then through the inverse of each axis, setpoint = L M smoothed;
// so the axes are where the smoothed reference is, without lag, and all deviate alike.
// Source of the idea: inverse compensation of corner speed has no chapter in Zarudnev
// 2007; corner rounding by the kernel is 2 v sin(turn / 2) m with m the half mean |t| of
// the kernel.

#include <optional>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/course/axis_dynamics.h"
#include "engrave/course/contour_error.h"
#include "engrave/course/speed_law.h"

namespace intaglio::course {

/// Several boxes of `box` periods each, convolved; `box` is odd, so that it is symmetric.
struct SplineKernel {
  int boxes = 3;
  int box = 1;
  double period_s = 0;

  /// Of at most this length; one period or more a box.
  static SplineKernel Of(double length_s, int boxes, double period_s);
  std::size_t half_count() const {
    return static_cast<std::size_t>(boxes * (box - 1) / 2);
  }
  double length_s() const { return boxes * box * period_s; }
  /// Its weights, 2 half_count() + 1, whose sum is 1.
  std::vector<double> Weights() const;
};

struct TrackingOptions {
  double period_s = 0.0005;  ///< of the setpoints, 1e-5..0.1
  double smooth_s = 0;       ///< of the law, for a limit on jerk: SampleLaw
  /// Length of the compensating kernel; absent: the setpoints are the reference.
  std::optional<double> kernel_s;
};

/// At the instants first_s + i period_s of the law.
struct Tracked {
  double first_s = 0, period_s = 0;
  std::vector<double> commanded_s_mm;
  std::vector<Vec2> setpoints_mm;
  std::vector<Vec2> actual_mm;  ///< of the load
  /// Of the greater axis: motor's acceleration, and the load's jerk. Empty unless asked
  /// for.
  std::vector<double> motor_mm_s2, jerk_mm_s3;
};

/// The clock of a course: first_s + i period_s, i from 0 to count - 1. It is from rest to
/// rest, with what kernel and axes need.
struct Instants {
  double first_s = 0;
  std::size_t count = 0;
};

/// Instants begin .. end - 1 of a course. A long one is followed part by part, so that
/// memory does not grow with it; each part is what it is in the whole.
struct Part {
  std::size_t begin = 0, end = 0;
};
inline constexpr std::size_t kPartInstants = 8192;
std::vector<Part> PartsOf(const Instants& instants);

enum class Exactness {
  kModel,  ///< of a compensated course: the axes are where the smoothed reference is
  kAxes,   ///< the axes' equations are solved with the setpoints as commands
};

class Tracking {
 public:
  /// `axes` are those that the setpoints are made for.
  Tracking(const AxisPair& axes, const TrackingOptions& options);

  /// `real` are the axes that follow. `with_jerk`: of what `with_motor` asks for.
  Tracked Follow(const Path& path, const SpeedLaw& law, const AxisPair& real,
                 Exactness exactness, bool with_motor, bool with_jerk = true) const;
  Tracked FollowPart(const Path& path, const SpeedLaw& law, const AxisPair& real,
                     Exactness exactness, bool with_motor, bool with_jerk,
                     const Instants& instants, const Part& part) const;
  /// The setpoints, and in actual_mm what the model makes of a compensated course.
  Tracked SetpointsOf(const Path& path, const SpeedLaw& law, const Instants& instants,
                      const Part& part) const;
  Instants InstantsOf(const SpeedLaw& law, const AxisPair& real,
                      Exactness exactness) const;
  SearchWindow WindowFor(double speed_mm_s, double tolerance_mm) const;

  const AxisPair& axes() const { return axes_; }
  const TrackingOptions& options() const { return options_; }
  bool compensated() const { return options_.kernel_s.has_value(); }
  const SplineKernel& kernel() const { return kernel_; }
  /// How long before and behind an instant the reference acts on the actual course.
  double memory_s() const;

 private:
  /// The places of the reference in actual_mm, with what the kernel needs on both sides.
  Tracked Reference(const Path& path, const SpeedLaw& law, const Instants& instants,
                    const Part& part) const;
  /// SetpointsOf, whose derivatives are those of the whole only
  /// kEdgeInstants inside its ends.
  Tracked RoughSetpoints(const Path& path, const SpeedLaw& law, const Instants& instants,
                         const Part& part, bool with_setpoints) const;
  void AddMotor(Tracked& tracked, bool with_jerk) const;
  void Compensate(Tracked& tracked, bool with_setpoints) const;

  AxisPair axes_;
  TrackingOptions options_;
  SplineKernel kernel_;
};

/// How many instants before a part the setpoints act on axes `real`.
std::size_t MemoryInstants(const AxisPair& real, double period_s);

/// What axes `real` make of setpoints, which they were settled before.
std::vector<Vec2> RunAxes(const AxisPair& real, double period_s,
                          std::span<const Vec2> setpoints_mm);

/// One axis smoothed by the kernel: `reference` has 2 half_count() more values than the
/// result.
std::vector<double> Smoothed(const SplineKernel& kernel,
                             std::span<const double> reference);

/// The sum of coefficients[k] times the k-th derivative, by central differences of fourth
/// order; beyond the ends the values go on as a straight line.
std::vector<double> ApplyPolynomial(std::span<const double> coefficients, double period_s,
                                    std::span<const double> values);

}  // namespace intaglio::course
