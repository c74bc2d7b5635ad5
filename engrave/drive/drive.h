#pragma once

// A drive: what an axis does when a position is commanded. Each axis by itself; positions
// in the axis' own unit (mm or rad), here called u.
//
// Guarantees of every implementation, checked by tests/engrave/drive/conformance_test.cc:
//  1. Follow is exact: over a command that is cubic in time it is the solution of the
//     drive's equation, to 1e-9 of the command's size, however long the step is; two
//     steps give what one of both their lengths gives.
//  2. An axis at rest on a constant command stays there.
//  3. The drive is stable: whatever the axis did before, it comes to Settled(command).
//  4. Settled(command) is a course on which Follow stays, from SettledState(command) on.
//  5. CommandFor is the inverse of Settled, and exact: an axis that is on a cubic course
//     and is commanded CommandFor(course) stays on the course, to 1e-9.
//  6. Error(command, t) is Settled(command) - command at t: what is predicted is what
//     Follow does once the axis has settled.
//  7. Parameters that are not finite numbers within the ranges of the drive's row in
//     DriveKinds are refused (drive_kinds.h), and only those and what the row checks
//     besides: a loop that is not stable.
//  8. CommandFor is linear and does not depend on the time: it adds to a course fixed
//     multiples of its first, second and third derivative, those of the series of 1 /
//     transfer().
//  9. All functions are const and without state: the same call gives the same bits, from
//     any thread.

#include <array>
#include <memory>
#include <string_view>

#include "engrave/drive/transfer.h"

namespace intaglio::drive {

/// p + v t + a t^2 / 2 + j t^3 / 6, t in seconds from its begin.
struct Cubic {
  double position_u = 0;
  double velocity_u_s = 0;
  double acceleration_u_s2 = 0;
  double jerk_u_s3 = 0;

  double At(double t_s) const {
    return position_u +
           t_s * (velocity_u_s + t_s * (acceleration_u_s2 / 2 + t_s * jerk_u_s3 / 6));
  }
  double VelocityAt(double t_s) const {
    return velocity_u_s + t_s * (acceleration_u_s2 + t_s * jerk_u_s3 / 2);
  }
};

struct AxisState {
  double position_u = 0;
  /// Of the actual motion. Free where the drive's order makes it a state, else it follows
  /// from position and command and is not read.
  double velocity_u_s = 0;
  /// Further states of drives of higher order, in their own terms: only those that
  /// SettledState and Follow return.
  std::array<double, kMaxOrder - 1> inner = {};
};

class Drive {
 public:
  virtual ~Drive() = default;

  /// The name of its row in DriveKinds, e.g. "first_order".
  virtual std::string_view name() const = 0;

  /// The state `duration_s` >= 0 later, while `command` is given from its begin.
  virtual AxisState Follow(const AxisState& state, const Cubic& command,
                           double duration_s) const = 0;

  /// The course of the axis after its transients have decayed.
  virtual Cubic Settled(const Cubic& command) const = 0;

  /// The state of an axis on Settled(command) at its begin.
  virtual AxisState SettledState(const Cubic& command) const = 0;

  /// From the command to the actual position.
  virtual Transfer transfer() const = 0;

  /// The command that keeps an axis on `course`.
  virtual Cubic CommandFor(const Cubic& course) const = 0;

  /// How far the commands for a course that brakes to rest with 1 u/s^2 may go beyond the
  /// place of rest, in u: the margin that a plan needs at the ends of the travel, per
  /// unit of its acceleration. s^2.
  virtual double lead_s2() const = 0;

  /// The actual position minus the commanded one at `t_s`, of a settled axis.
  double Error(const Cubic& command, double t_s) const {
    return Settled(command).At(t_s) - command.At(t_s);
  }
};

/// Of the three axes of a machine, in their order; null: an axis is where it is
/// commanded.
using AxisDrives = std::array<std::shared_ptr<const Drive>, 3>;

/// One drive for all axes.
inline AxisDrives AllAxes(const std::shared_ptr<const Drive>& drive) {
  return {drive, drive, drive};
}

}  // namespace intaglio::drive
