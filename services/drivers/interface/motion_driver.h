#pragma once

// What a motion controller family has to be able to do for the bridge. A family is a
// folder of services/drivers and a row of the table in motion_drivers.cc; in
// tests/services/drivers a folder with its controller or a simulation of it, which has a
// row of its own (tests/services/drivers/rig_row.h).
// Frame machine, mm and mm/s; time in ticks of the lamp sync, and for a controller with a
// clock of its own also in ns of that clock.

#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/motion/segments/segment.h"
#include "proto/machine.pb.h"
#include "services/drivers/interface/hand_motion.h"

namespace intaglio::drivers {

class LaserController;

/// Actual positions at consecutive ticks, or at the times at which a clock of its own was
/// notified of them.
struct LatchedPositions {
  std::uint32_t run = 0;
  std::uint64_t first_tick = 0;
  PointList positions_mm;
  std::vector<std::uint64_t> at_ns = {};  ///< by a clock of its own; else empty
};

/// Guarantees of every driver together with its controller; each is checked for all that
/// MotionDriverKinds lists (tests/services/drivers/motion_conformance.cc):
///   M1  Nothing blocks. What cannot be taken now is refused, by Room() == 0 or an error,
///       and nothing of it is done; the caller tries again.
///   M2  state() is the controller's own newest report. While nothing is known of it,
///       link_up is false, `fault` is the reason, and every command is refused; so it is
///       within 300 ms after a line is cut. `message` contains the remedy.
///   M3  A run begins at its tick, from rest and without a fault. Begun too late, or
///       while another moves, it is a fault, and the stage comes to rest.
///   M4  Segments are executed completely, each once, in order, and end at their place
///       and time; a segment with `program_end` ends the run at rest.
///   M5  AbortRun brings the stage to rest, without a fault; nothing of the run follows.
///   M6  A fault brings the stage to rest and lasts until ClearFault; no run begins
///       before. ClearFault moves nothing.
///   M7  A target outside the travel, or one that is not a number, is MOTION_LIMIT, and
///       the stage does not leave the travel for it.
///   M8  Motion that ends without `program_end` is MOTION_STARVED.
///   M9  A line that is cut at any byte, and a host that dies or hangs, bring the stage
///       to rest by the controller itself: within 250 ms and the time that braking takes.
///   M10 A lost line comes back by itself; no motion does. The run that was lost shows as
///       MOTION_STARVED until ClearFault.
///   M11 A power cycle of the controller ends everything that was begun before.
///   M12 Positions are latched once for every tick of a run, in order, without gap, and
///       are where the stage is, in the machine frame.
///   M13 A controller with another serial number than the profile's is refused
///       (MOTION_WRONG_CONTROLLER) and moves nothing.
///   M17 What the controller reports of itself is none of MOTION_LINK_LOST,
///   MOTION_STARVED
///       and MOTION_LATE, which are of the line alone: a reset, an emergency stop, a
///       hold, a limit, an alarm and an error each end the motion as a fault that lasts
///       until ClearFault, or, as a power cycle does, as another power-up of the
///       controller. Nothing moves by itself when its cause is gone.
///   M18 Where the controller may not know where its axes are, place_lost or `homed` says
///       so. Until a person has homed it or, by SetZero, has stated where they are, a run
///       ends as MOTION_SAFE_STATE, with its number in state(), and nothing moves for it.
///       So does a run, or a motion by hand, in which the place is lost; a controller
///       that switches the laser counts that as an opening. FindHindrance(state()) is
///       MOTION_PLACE_LOST until then, whatever ClearFault has cleared.
/// And of one that can be moved by hand (Jog does not return kUnsupported):
///   M14 Jog and Home move from rest, without a fault, and without a run; else they are
///       refused and nothing moves. While they move, at_rest is false from the moment in
///       which Jog returns.
///   M15 Hold brings the stage to rest, without a fault, wherever it is on its way. A run
///       that begins meanwhile is refused (M3).
///   M16 No pulse is possible while it is moved by hand: a controller that drives the
///       laser, too, has switched it off before it moves.
/// And of one whose guide laser draws outlines (DrawOutline does not return
/// kUnsupported):
///   M19 An outline is begun as a jog is (M14), with corners that are in the travel, and
///       ends as one: by Hold (M15), without a host (M9), and by a stop of the controller
///       (M17). The guide laser is on from the first corner until the end, and at no
///       other time; where it is on, the focus is on the closed way over the corners. As
///       long as the outline is drawn no pulse is possible, whatever the laser's side is
///       told: the gate of the laser stays closed.
/// And of one with a stage that carries the block under a scan head (has_block_stage):
///   M20 MoveBlock is a motion by hand (M14 to M16, M9, M17) of this stage alone. A run
///       begins only with it at rest at the place of the newest RequireBlockAt, within
///       the position tolerance, by the controller's own report; else, and when it leaves
///       the place in a run, that ends as MOTION_SAFE_STATE, and no pulse is fired in it.
/// Not thread-safe.
///
/// A controller that moves the stage and switches the laser has one driver object that is
/// a LaserController (services/drivers/interface/laser_controller.h), too; its row in
/// MotionDriverKinds has `switches_laser`, and the profile's laser_line.protocol is
/// "motion-output". Either Poll alone keeps the object alive; whoever uses both sides
/// calls both. fd() is the same in both interfaces, and nothing else is.
class MotionDriver : public HandMotion {
 public:
  /// Moves bytes both ways and opens a lost line again; never an error by itself:
  /// state() has it.
  virtual void Poll() = 0;
  /// For poll(2); -1 when there is none.
  virtual int fd() const = 0;
  /// The longest time between two Polls of a machine at rest, which nothing has come for.
  /// A family that sends something of its own, as requests for a status, needs it shorter
  /// than one that only answers its controller.
  virtual std::chrono::milliseconds resting_wait() const { return kRestingWait; }
  static constexpr std::chrono::milliseconds kRestingWait{10};
  virtual std::vector<LatchedPositions> TakePositions() = 0;

  /// From rest, without a fault, at a tick to come. `start_ns` is that tick by the
  /// controller's own clock; 0 when it has none.
  virtual Status BeginRun(std::uint32_t run, std::uint64_t start_tick,
                          std::uint64_t start_ns) = 0;
  /// Runs begun from now on are of a block at this place of its stage's axes; before the
  /// first call and of a machine without such a stage 0. kUnsupported: another place.
  virtual Status RequireBlockAt(const Vec2& place_mm);
  /// Segments that one Append would take now.
  virtual std::size_t Room() const = 0;
  /// All of them (1..Room()), or none and an error. `end_ns` has the times of their ends
  /// by the controller's own clock; empty when it has none.
  virtual Status Append(std::span<const motion::Segment> segments,
                        std::span<const std::uint64_t> end_ns) = 0;
  /// Brake to rest and forget the run.
  virtual Status AbortRun() = 0;

  /// This object as a laser driver; null: the controller only moves.
  virtual LaserController* laser() { return nullptr; }

  /// As AbortRun, unless a family has another way.
  Status Hold() override { return AbortRun(); }
};

/// The travel of a profile's linear axes, mm, machine frame.
Box3 TravelOf(const MachineSpec& machine);

}  // namespace intaglio::drivers
