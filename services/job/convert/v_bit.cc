#include "services/job/convert/v_bit.h"

#include <cmath>
#include <numbers>

namespace intaglio {

bool IsVBit(const Course& course) {
  return course.has_tip_mm() && course.has_tool_angle_deg();
}

double WidthOfVBit(const Course& course, double depth_mm) {
  const double half_angle_rad = course.tool_angle_deg() / 2 * std::numbers::pi / 180;
  return course.tip_mm() + 2 * depth_mm * std::tan(half_angle_rad);
}

}  // namespace intaglio
