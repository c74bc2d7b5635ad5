// With v^2 / 2a of the way left the course has to brake. From speed v at s it accelerates
// until the speed is reached, or until v'^2 / 2a are left: s + (v'^2 - v^2) / 2a + v'^2 /
// 2a is the length, so v'^2 = a (length - s) + v^2 / 2.

#include "services/virtual_engraver/jog_course.h"

#include <algorithm>
#include <cmath>

namespace intaglio::virtual_engraver {
namespace {

// Rounding leaves this much of a length.
constexpr double kSameMm = 1e-9;

}  // namespace

JogCourse::JogCourse(const Vec3& from, const Vec3& to, double length_mm,
                     double speed_mm_s, double acceleration_mm_s2)
    : from_(from),
      per_mm_((to - from) / length_mm),
      length_mm_(length_mm),
      speed_mm_s_(speed_mm_s),
      acceleration_mm_s2_(acceleration_mm_s2) {}

JogCourse::Stretch JogCourse::Next(double left_s) {
  const double a = acceleration_mm_s2_, v = now_mm_s_;
  const double left_mm = length_mm_ - at_mm_, brake_mm = v * v / (2 * a);
  double bound_s = 0, rate = 0;
  bool ends = false;
  if (braking_ || brake_mm >= left_mm - kSameMm) {
    rate = -a;
    bound_s = v / a;
    ends = true;
  } else if (v < speed_mm_s_) {
    const double peak = std::min(speed_mm_s_, std::sqrt(a * left_mm + v * v / 2));
    rate = a;
    bound_s = (peak - v) / a;
  } else {
    bound_s = (left_mm - brake_mm) / v;
  }
  const double seconds = std::min(left_s, bound_s);
  Stretch stretch{{from_ + at_mm_ * per_mm_, v * per_mm_, 0.5 * rate * per_mm_}, seconds};
  at_mm_ += seconds * (v + 0.5 * rate * seconds);
  now_mm_s_ = std::max(0.0, v + rate * seconds);
  if (seconds == bound_s && rate > 0) now_mm_s_ = std::min(now_mm_s_, speed_mm_s_);
  done_ = ends && seconds == bound_s;
  return stretch;
}

}  // namespace intaglio::virtual_engraver
