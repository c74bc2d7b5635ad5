#pragma once

// What a stage controller moves: axes that follow a command. What may move, when and
// where to is decided by the Stage alone (services/virtual_engraver/stage.h), whose rules
// are the same for both: the virtual engraver has VirtualAxes, a Linux board StepAxes
// (services/reference_controller/step_axes.h), which step motors.
// Machine frame, mm. Not thread-safe.

#include <optional>

#include "engrave/core/geometry.h"
#include "services/virtual_engraver/mechanics/mechanics.h"

namespace intaglio::virtual_engraver {

class StageAxes {
 public:
  virtual ~StageAxes() = default;

  /// `from_s` to `to_s` >= from_s of the command have passed.
  virtual void Follow(const CubicCommand& command, double from_s, double to_s) = 0;
  /// As the controller measures or counts it.
  virtual const Vec3& actual_mm() const = 0;
  /// They have nothing left to do when the command rests: no step is owed.
  virtual bool settled() const { return true; }
  /// How much later than its command each axis of constant speed is, as the controller
  /// knows it, s.
  virtual Vec3 velocity_lag_s() const { return Vec3::Zero(); }
  /// Where the controller's model of the axes' loops has them; absent: it has none.
  virtual std::optional<Vec3> expected_mm() const { return std::nullopt; }
  /// What a compare output computes ahead with; null: there is none.
  virtual const Mechanics* mechanics() const { return nullptr; }

  /// What nobody measures: how far beside actual_mm() they are, with the segment under
  /// way done to this ratio, 0..1.
  virtual Vec3 BesideMm(double done_ratio) const {
    (void)done_ratio;
    return Vec3::Zero();
  }
  /// The segment under way ends, another begins.
  virtual void PassEnd() {}
  /// Another segment begins where the one under way is done to this ratio, 0..1.
  virtual void LeaveAt(double done_ratio) { (void)done_ratio; }

  /// The home switch of this axis, 0 to 2, is pressed.
  virtual bool IsAtSwitch(int axis) const {
    (void)axis;
    return false;
  }
  /// From now on the place of this axis, actual and commanded, counts so much higher.
  virtual void ShiftPlace(int axis, double by_mm) { (void)axis, (void)by_mm; }

  /// An axis that does not move any more (-1: all of them), until Unstick.
  virtual void Stick(int axis) { (void)axis; }
  virtual void Unstick() {}
};

}  // namespace intaglio::virtual_engraver
