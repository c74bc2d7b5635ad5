#include "services/marker/hand_teacher.h"

namespace intaglio::marker {

cell::TaughtAxes HandTeacher::axes() const {
  cell::TaughtAxes axes;
  axes.limits = {Vec3::Constant(-kReach_mm), Vec3::Constant(kReach_mm)};
  return axes;
}

Result<Vec3> HandTeacher::AxesAtZero(const intaglio_ManualCommand& /*command*/,
                                     const Vec3& /*position*/) const {
  return Fail(ErrorCode::kUnsupported,
              "the work zero of a machine that follows contours is where its axes are 0: "
              "use `intaglio teach move 0 0 H` with a height H above the work");
}

Result<std::string> HandTeacher::Save(const intaglio_ManualCommand& /*command*/,
                                      const Vec3& /*position*/) {
  return Fail(ErrorCode::kUnsupported,
              "a machine that follows contours has one thing to teach, its work zero, "
              "where the tool is: use `intaglio teach zero`");
}

}  // namespace intaglio::marker
