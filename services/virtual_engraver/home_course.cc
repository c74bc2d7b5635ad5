#include "services/virtual_engraver/home_course.h"

#include <cmath>

namespace intaglio::virtual_engraver {
namespace {

// A touch goes at most so many times the way that was backed off.
constexpr double kTouchRatio = 2;

}  // namespace

HomeCourse::HomeCourse(const HomingOptions& options, const Vec3& at_mm)
    : options_(options), at_mm_(at_mm) {}

void HomeCourse::Begin(Leg leg) {
  // It has braked beyond where the switch was met.
  const double overrun_mm = met_mm_ ? std::abs(at_mm_[axis()] - *met_mm_) : 0;
  leg_ = leg;
  met_mm_.reset();
  const bool plus = (leg == Leg::kBackOff) != At().at_plus_end;
  const double length_mm = leg == Leg::kSeek    ? At().search_mm
                           : leg == Leg::kTouch ? kTouchRatio * options_.back_off_mm
                                                : options_.back_off_mm + overrun_mm;
  Vec3 to_mm = at_mm_;
  to_mm[axis()] += plus ? length_mm : -length_mm;
  course_.emplace(at_mm_, to_mm, length_mm,
                  leg == Leg::kSeek ? options_.speed_mm_s : options_.touch_speed_mm_s,
                  options_.acceleration_mm_s2);
}

JogCourse::Stretch HomeCourse::Next(double left_s, bool pressed) {
  if (leg_ == Leg::kNone) Begin(pressed ? Leg::kBackOff : Leg::kSeek);
  if (!met_mm_ && pressed == (leg_ != Leg::kBackOff)) {
    met_mm_ = at_mm_[axis()];
    course_->Brake();
  }
  const JogCourse::Stretch stretch = course_->Next(left_s);
  at_mm_ = stretch.curve.At(stretch.seconds);
  if (course_->done()) End();
  return stretch;
}

void HomeCourse::End() {
  if (held_) {
    state_ = State::kHeld;
  } else if (!met_mm_) {
    state_ = leg_ == Leg::kBackOff ? State::kStuck : State::kNoSwitch;
  } else if (leg_ == Leg::kTouch) {
    state_ = State::kAxisFound;
  } else {
    Begin(leg_ == Leg::kSeek ? Leg::kBackOff : Leg::kTouch);
  }
}

double HomeCourse::shift_mm() const { return At().switch_mm - met_mm_.value_or(0); }

void HomeCourse::BeginNextAxis(const Vec3& at_mm) {
  at_mm_ = at_mm;
  leg_ = Leg::kNone;
  met_mm_.reset();
  state_ = State::kUnderWay;
  if (done_axes_ + 1 == options_.order.size()) {
    state_ = State::kDone;
  } else {
    ++done_axes_;
  }
}

void HomeCourse::Brake() {
  held_ = true;
  if (course_) {
    course_->Brake();
  } else {
    state_ = State::kHeld;
  }
}

}  // namespace intaglio::virtual_engraver
