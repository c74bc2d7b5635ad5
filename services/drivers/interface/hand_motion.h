#pragma once

// What a person can do at a machine through its driver: move it by hand, and set the zero
// that its controller keeps. Whether a person may is not decided here
// (services/cell/manual/manual_control.h). Axes in mm or rad.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "idl/motion.h"

namespace intaglio::drivers {

/// The controller's newest report of its state.
struct DriverState {
  bool link_up = false;
  bool taken_over = false;  ///< a newer host has the controller, for good
  std::uint64_t tick = 0;
  Vec3 position_mm = Vec3::Zero();
  Vec3 velocity_mm_s = Vec3::Zero();
  std::uint32_t run = 0;
  std::uint64_t covered_through_tick = 0;
  bool at_rest = false;
  intaglio_MotionFault fault = intaglio_MOTION_LINK_LOST;
  std::string message;  ///< the fault in a sentence that names the remedy
  /// Why the controller that answers now is refused, and what to do; empty: it is not.
  std::string refusal = {};
  double following_error_max_um = 0;
  std::uint32_t clock = 0;   ///< of its own, another number is another clock; 0: none
  std::uint64_t number = 0;  ///< grows with every report of the controller
  double position_tolerance_um = 0;  ///< of its in-position output; 0: not known
  /// False: the controller does not know where its axes are; nothing but Home is right.
  bool homed = true;
  /// What follows "home it" in a sentence for a person.
  std::string_view how_to_home = " (intaglio teach home)";
  /// Why the controller may not know where its axes are, and what a person does about it,
  /// of one that has no switches: no run begins, and positions and limits mean little,
  /// before SetZero. Empty: it knows, or `homed` says it.
  std::string place_lost = {};

  /// The controller has a stage that carries the block under a scan head.
  bool has_block_stage = false;
  Vec2 block_mm = Vec2::Zero();  ///< its place, by its own axes; at_rest is of it, too

  bool operator==(const DriverState&) const = default;
};

/// Why no run can begin before a person has homed the machine or has set its zero, and
/// how that is done; empty: the controller knows where its axes are.
std::string WhyPlaceIsUnknown(const DriverState& state);

/// What keeps a run from beginning; MOTION_OK: nothing.
struct MotionHindrance {
  intaglio_MotionFault fault = intaglio_MOTION_OK;
  std::string message;  ///< it in a sentence that names the remedy

  bool operator==(const MotionHindrance&) const = default;
};
/// The fault, or MOTION_PLACE_LOST while the place of the axes is not known, which
/// outlasts every fault that ClearFault clears; a line that is down and missing air,
/// which come first at a machine, keep their own.
MotionHindrance FindHindrance(const DriverState& state);

/// Corners of an outline, at most.
inline constexpr std::size_t kMaxOutlineCorners = 64;

class HandMotion {
 public:
  virtual ~HandMotion() = default;
  virtual const DriverState& state() const = 0;
  /// Clear a fault whose cause is gone.
  virtual Status ClearFault() = 0;

  /// Straight to `axes`, within the travel, at most at `speed_mm_s` of the focus or the
  /// tool (mm/s; rad/s of a rotary axis that moves alone). A person holds it: the caller
  /// ends it with Hold. kUnsupported: this family cannot.
  virtual Status Jog(const Vec3& axes, double speed_mm_s);
  /// To where the axes count from, as the controller does it.
  virtual Status Home();
  /// The controller counts the place where the tool is as `here` from now on, in the axes
  /// that `sets` has. Nothing moves; at_rest is false until it is done. kUnsupported:
  /// this family keeps no zero.
  virtual Status SetZero(const Vec3& here, const std::array<bool, 3>& sets);
  /// The guide laser draws the closed way over these corners (1 to kMaxOutlineCorners, by
  /// the first two axes, within the travel, mm), again and again, at most at
  /// `speed_mm_s`; the third axis rests, and the laser stays off. A person holds it: the
  /// caller ends it with Hold. kUnsupported: this machine has no such laser.
  virtual Status DrawOutline(std::span<const Vec2> corners_mm, double speed_mm_s);
  /// The stage that carries the block under a scan head goes straight to this place of
  /// its own axes, within their travel, at most at `speed_mm_s`; the other axes rest. The
  /// caller ends it with Hold. kUnsupported: this machine has no such stage.
  virtual Status MoveBlock(const Vec2& place_mm, double speed_mm_s);
  /// Ends Jog, Home, DrawOutline and MoveBlock, braking to rest.
  virtual Status Hold() = 0;
};

}  // namespace intaglio::drivers
