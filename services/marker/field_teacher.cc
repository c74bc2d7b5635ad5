#include "services/marker/field_teacher.h"

namespace intaglio::marker {
namespace {

tl::unexpected<Error> NothingToTeach() {
  return Fail(
      ErrorCode::kUnsupported,
      "the field of a scan head has its zero in its middle, and nothing is taught "
      "in it: move the piece, or the marks in the job; `intaglio teach outline "
      "JOB` shows where they will be");
}

}  // namespace

cell::TaughtAxes FieldTeacher::axes() const {
  cell::TaughtAxes axes;
  const Vec3 end_mm(field_mm_ / 2, field_mm_ / 2, 0);
  axes.limits = {-end_mm, end_mm};
  axes.profile = profile_;
  return axes;
}

Result<Vec3> FieldTeacher::AxesAtZero(const intaglio_ManualCommand& /*command*/,
                                      const Vec3& /*position*/) const {
  return NothingToTeach();
}

Result<std::string> FieldTeacher::Save(const intaglio_ManualCommand& /*command*/,
                                       const Vec3& /*position*/) {
  return NothingToTeach();
}

}  // namespace intaglio::marker
