#include "services/virtual_engraver/block_stage.h"

#include <algorithm>

namespace intaglio::virtual_engraver {

bool BlockStage::Reaches(const Vec2& place_mm) const {
  return (place_mm.array() >= options_.travel_min_mm.array()).all() &&
         (place_mm.array() <= options_.travel_max_mm.array()).all();
}

void BlockStage::MoveTo(const Vec2& place_mm, double speed_mm_s) {
  const double length_mm = (place_mm - at_mm_).norm();
  if (length_mm <= 0) return;
  course_.emplace(Vec3(at_mm_.x(), at_mm_.y(), 0), Vec3(place_mm.x(), place_mm.y(), 0),
                  length_mm, std::min(speed_mm_s, options_.max_speed_mm_s),
                  options_.acceleration_mm_s2);
}

void BlockStage::Brake() {
  if (course_) course_->Brake();
}

void BlockStage::Advance(double seconds) {
  while (course_ && seconds > 0) {
    const JogCourse::Stretch stretch = course_->Next(seconds);
    at_mm_ = stretch.curve.At(stretch.seconds).head<2>();
    seconds -= stretch.seconds;
    if (course_->done()) course_.reset();
  }
}

void BlockStage::Push(const Vec2& by_mm) {
  course_.reset();
  at_mm_ += by_mm;
}

}  // namespace intaglio::virtual_engraver
