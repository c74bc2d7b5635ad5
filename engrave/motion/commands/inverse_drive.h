#pragma once

// The command that keeps an axis on its course, over knots at which the acceleration of
// the course jumps: the inverse of a drive with its transients, for all three axes alike.
//
// CommandFor of a drive is the whole inverse of one whose transfer function has no zeros.
// Zeros have transients of their own: with b(s) c = a(s) p the command is CommandFor(p)
// and a rest e with b(s) e = 0. A drive with one zero less than poles hands them on over
// a knot like this (n: order of a, D: jump of p''): c goes on, and with two zeros c'
// jumps by D a_n / b_(n-1), as c'' has the pulse of p'''. With fewer zeros c itself
// jumps; then the rest is left out, and the caller takes the mean of both sides of a
// knot.

#include <array>

#include "engrave/core/geometry.h"
#include "engrave/drive/drive.h"

namespace intaglio::motion {

/// A course or a command from its begin, three axes.
struct CubicCourse {
  Vec3 position_mm = Vec3::Zero(), velocity_mm_s = Vec3::Zero();
  Vec3 acceleration_mm_s2 = Vec3::Zero(), jerk_mm_s3 = Vec3::Zero();
};

class InverseDrive {
 public:
  /// `drive` null: a command is the course. The course begins at rest at `start_mm`.
  InverseDrive(const drive::Drive* drive, const Vec3& start_mm);

  /// Whether the command goes on over the knots.
  bool continuous() const { return zeros_ > 0; }

  struct Command {
    Vec3 position_mm = Vec3::Zero(), velocity_mm_s = Vec3::Zero();
  };
  /// Where a course without transients is commanded at its begin.
  Command WithoutTransients(const CubicCourse& course) const;

  // Of a continuous inverse; the state is that at the end of the last segment.
  /// `course` begins here.
  Command AtBegin(const CubicCourse& course) const;
  /// The course goes on for `duration_s` > 0; returns the command at its end.
  Command Follow(const CubicCourse& course, double duration_s);

 private:
  std::array<double, 4> series_ = {1, 0, 0, 0};  // of the inverse
  int zeros_ = 0;                                // that are followed, 0..2
  double b1_s_ = 0, b2_s2_ = 0;
  double kick_s_ = 0;  // a_n / b_(n-1), of two zeros
  Vec3 command_mm_, command_mm_s_ = Vec3::Zero();
  Vec3 last_acceleration_mm_s2_ = Vec3::Zero();
};

}  // namespace intaglio::motion
