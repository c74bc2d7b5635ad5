#pragma once

// The axes of a stage with step motors: each is stepped to where it is commanded, and its
// place is the count of its steps. No step that a motor loses is seen.
//
// An axis owes steps while its command is more than 0.55 of a step away; so a command
// that rests between two steps makes none. Step makes at most one of each axis, and none
// sooner after the one before than the highest rate allows: what was late is made up for
// at that rate, and how far it is behind is the following error of the Stage.
// Machine frame, mm. Not thread-safe.

#include <array>
#include <chrono>
#include <cstdint>

#include "services/reference_controller/controller.h"
#include "services/reference_controller/pins.h"
#include "services/virtual_engraver/axes/stage_axes.h"

namespace intaglio::reference_controller {

struct StepOptions {
  Vec3 steps_per_mm = Vec3::Constant(200);  ///< > 0
  std::array<bool, 3> reversed = {};        ///< the direction is on towards minus
  double max_rate_hz = 20000;               ///< > 0, at most half of a step's length
  std::chrono::nanoseconds pulse{3000};     ///< how long a step is on, at least
  std::chrono::nanoseconds direction_setup{5000};  ///< from the direction to the step
};

class StepAxes final : public virtual_engraver::StageAxes {
 public:
  /// `pins` outlive this.
  StepAxes(const StepOptions& options, const Vec3& at_mm, Pins& pins,
           ControllerTime time);

  void Follow(const virtual_engraver::CubicCommand& command, double from_s,
              double to_s) override;
  const Vec3& actual_mm() const override { return actual_mm_; }
  bool settled() const override;
  bool IsAtSwitch(int axis) const override;
  void ShiftPlace(int axis, double by_mm) override;

  /// Which switches are pressed, of Pins::Levels.
  void SetSwitches(std::uint32_t levels) { levels_ = levels; }
  /// The steps that are due now. Waits for the length of one. kIo.
  Status Step();

 private:
  /// Steps away from the command, from -n to n.
  double Owed(int axis) const;
  Status TurnTo(int axis, bool on, bool& turned);

  StepOptions options_;
  std::chrono::nanoseconds min_period_;
  Vec3 origin_mm_, actual_mm_, commanded_mm_;
  std::array<std::int64_t, 3> count_ = {};
  std::array<bool, 3> direction_ = {};
  std::array<std::chrono::nanoseconds, 3> stepped_at_;
  std::uint32_t levels_ = ~0U;  // no switch is pressed
  Pins& pins_;
  ControllerTime time_;
};

}  // namespace intaglio::reference_controller
