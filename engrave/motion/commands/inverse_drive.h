#pragma once

// The command that keeps an axis on its course, over knots at which the acceleration of
// the course jumps: the inverse of a drive with its transients. Of one axis, in its unit,
// mm or rad.
//
// CommandFor of a drive is the whole inverse of one whose transfer function has no zeros.
// Zeros have transients of their own: with b(s) c = a(s) p the command is CommandFor(p)
// and a rest e with b(s) e = 0. A drive with one zero less than poles hands them on over
// a knot like this (n: order of a, D: jump of p''): c goes on, and with two zeros c'
// jumps by D a_n / b_(n-1), as c'' has the pulse of p'''. With fewer zeros c itself
// jumps; then the rest is left out, and the caller takes the mean of both sides of a
// knot. Of a drive with two zeros the poles beyond the third are the delays of its
// controller: they are left out of the inverse, as is their share of the series.

#include <array>

#include "engrave/drive/drive.h"

namespace intaglio::motion {

class InverseDrive {
 public:
  /// `drive` null: a command is the course. The course begins at rest at `start`.
  InverseDrive(const drive::Drive* drive, double start);

  /// Whether the command goes on over the knots.
  bool continuous() const { return zeros_ > 0; }

  struct Command {
    double position = 0, velocity = 0;
  };
  /// Where a course without transients is commanded at its begin.
  Command WithoutTransients(const drive::Cubic& course) const;

  // Of a continuous inverse; the state is that at the end of the last segment.
  /// `course` begins here.
  Command AtBegin(const drive::Cubic& course) const;
  /// The course goes on for `duration_s` > 0; returns the command at its end.
  Command Follow(const drive::Cubic& course, double duration_s);

 private:
  std::array<double, 4> series_ = {1, 0, 0, 0};  // of the inverse
  int zeros_ = 0;                                // that are followed, 0..2
  double b1_s_ = 0, b2_s2_ = 0;
  double kick_s_ = 0;  // a_3 / b_2, of two zeros
  double command_, command_per_s_ = 0;
  double last_acceleration_ = 0;
};

}  // namespace intaglio::motion
