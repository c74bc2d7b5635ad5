#pragma once

// How the stage's axes follow their commands: each axis by itself, all three alike or
// each as it is driven.
// Machine frame, mm. Written for itself: it shares nothing with engrave/drive, so that a
// wrong compensation there shows as cracks in the wrong place.
//
// What an axis is set to is a whole number of its steps, where it has any: the command is
// rounded every 0.1 ms and goes on from there with its own speed, so that it is never
// more than half a step beside and not late.
//
// Control loops and steppers: loop_axis.h. First order: x' = (c - x) / lag. Second order:
// x'' + 2 d w x' + w^2 x = w^2 c with w = 2 pi times the natural frequency and d the
// damping ratio. Both are stepped exactly over commands that are cubic in time.

#include <array>
#include <optional>
#include <vector>

#include "engrave/core/geometry.h"
#include "services/virtual_engraver/mechanics/loop_axis.h"

namespace intaglio::virtual_engraver {

struct SecondOrderOptions {
  double natural_frequency_hz = 100;  ///< > 0
  double damping_ratio = 0.7;         ///< > 0
};

/// A command over a while: p + v s + c2 s^2 + c3 s^3, s in seconds.
struct CubicCommand {
  Vec3 p = Vec3::Zero(), v = Vec3::Zero(), c2 = Vec3::Zero(), c3 = Vec3::Zero();

  Vec3 At(double s) const { return p + s * (v + s * (c2 + s * c3)); }
  Vec3 SpeedAt(double s) const { return v + s * (2 * c2 + 3 * s * c3); }
};

/// At most one of second_order and loop.
struct MechanicsOptions {
  double lag_s = 0.0002;  ///< first order, without both others; 0: none
  std::optional<SecondOrderOptions> second_order = {};
  std::optional<LoopOptions> loop = {};
  /// In place of the above, of each axis; three, or none: all are alike.
  std::vector<MechanicsOptions> of_axis = {};
  /// Each axis is set to whole ones, >= 0; 0: it is not rounded. Not regarded in of_axis.
  Vec3 steps_per_mm = Vec3::Zero();

  /// Whether all axes are of first order.
  bool first_order() const;
};

/// Without steps and what disturbs its loops, as its controller knows them; absent where
/// all axes are alike of first order: such a controller knows no lag. One whose axes have
/// drives of their own does: mirrors at 8 m/s and a slow z lag by many times the
/// tolerance.
std::optional<MechanicsOptions> Undisturbed(const MechanicsOptions& options);

class Mechanics {
 public:
  /// At rest at `at_mm`.
  Mechanics(const MechanicsOptions& options, const Vec3& at_mm);

  /// From `from_s` to `to_s` >= from_s of the command.
  void Follow(const CubicCommand& command, double from_s, double to_s);
  const Vec3& actual_mm() const { return actual_mm_; }
  /// How much later than its command each axis of constant speed is, s.
  Vec3 velocity_lag_s() const;

  /// An axis that does not move any more (-1: all of them), until Unstick.
  void Stick(int axis);
  void Unstick();

 private:
  /// `command`, so that at `at_s` it is a whole number of steps of each axis.
  CubicCommand InSteps(const CubicCommand& command, double at_s) const;
  void FollowAsSet(const CubicCommand& command, double from_s, double to_s);
  Vec3 FirstOrder(const CubicCommand& command, double from_s, double to_s) const;
  Vec3 SecondOrder(const CubicCommand& command, double from_s, double to_s);
  Vec3 Loops(const CubicCommand& command, double from_s, double to_s);
  void Step(double angle_rad);

  double lag_s_;
  Vec3 steps_per_mm_;
  std::vector<Mechanics> of_axis_;  // three, or none; axis i of the i-th counts
  std::optional<SecondOrderOptions> second_order_;
  std::vector<LoopAxis> loops_;  // three, or none
  Vec3 actual_mm_;
  Vec3 actual_mm_per_rad_ = Vec3::Zero();  // of the second order: speed / w
  std::array<bool, 3> stuck_ = {false, false, false};
  // The last step of the second order: rows of x and x' / w over x, x' / w and the
  // command with its derivatives by w t.
  double step_rad_ = 0;
  Eigen::Matrix<double, 2, 6> step_ = Eigen::Matrix<double, 2, 6>::Zero();
};

}  // namespace intaglio::virtual_engraver
