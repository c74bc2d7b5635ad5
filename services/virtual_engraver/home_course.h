#pragma once

// How axes without absolute encoders find where they are: each runs against a switch, one
// after the other.
//
//   switch free:    seek fast, until it is pressed ---.
//   switch pressed: ----------------------------------+-> back off slowly, until it is
//                                                          free -> touch it slowly
//
// The place is that of the first press of the slow touch, which always comes from the
// same side. A switch that is not met within the way that is searched, or is not left
// within the way to back off, ends the course, and nothing is known. In lengths of the
// axes, mm; times in s.

#include <array>
#include <cstddef>
#include <optional>

#include "services/virtual_engraver/jog_course.h"

namespace intaglio::virtual_engraver {

struct HomingOptions {
  struct Axis {
    bool at_plus_end = false;  ///< where the switch is; else at the minus end
    double switch_mm = 0;      ///< the place at which it is pressed, machine frame
    double search_mm = 1;      ///< > 0: so far it is sought, from anywhere
  };
  std::array<Axis, 3> axes;
  std::array<int, 3> order = {2, 0, 1};  ///< first the axis that could collide
  double speed_mm_s = 10;                ///< > 0, of the search
  double touch_speed_mm_s = 1;           ///< > 0, of back off and touch
  double back_off_mm = 5;                ///< > 0, from where it was met, at most
  double acceleration_mm_s2 = 100;       ///< > 0, also of braking
};

class HomeCourse {
 public:
  enum class State { kUnderWay, kAxisFound, kNoSwitch, kStuck, kHeld, kDone };

  /// From rest at `at_mm`, whatever that means.
  HomeCourse(const HomingOptions& options, const Vec3& at_mm);

  /// The one that is under way.
  int axis() const { return options_.order[done_axes_]; }
  /// A stretch of at most `left_s` > 0, with the switch of axis() as it is now. While
  /// state() is kUnderWay.
  JogCourse::Stretch Next(double left_s, bool pressed);
  State state() const { return state_; }
  /// With kAxisFound: what the coordinate of axis() has to be raised by.
  double shift_mm() const;
  /// Behind kAxisFound: the next axis, from rest at `at_mm`; without one, kDone.
  void BeginNextAxis(const Vec3& at_mm);
  /// It brakes from now on, and ends as kHeld.
  void Brake();

 private:
  enum class Leg { kNone, kSeek, kBackOff, kTouch };
  void Begin(Leg leg);
  void End();
  const HomingOptions::Axis& At() const {
    return options_.axes[static_cast<std::size_t>(axis())];
  }

  HomingOptions options_;
  Vec3 at_mm_;
  std::size_t done_axes_ = 0;
  State state_ = State::kUnderWay;
  Leg leg_ = Leg::kNone;
  std::optional<JogCourse> course_ = {};
  bool held_ = false;
  std::optional<double> met_mm_ = {};  // where the switch changed in this leg
};

}  // namespace intaglio::virtual_engraver
