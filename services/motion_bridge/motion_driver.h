#pragma once

// What a motion controller family has to be able to do for the bridge. A driver is one
// header, one source, one test and one line of the registry in motion_driver.cc.
// Frame machine, mm and mm/s; time in ticks of the lamp sync, and for a controller with a
// clock of its own also in ns of that clock.

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/motion/segment.h"
#include "idl/motion.h"
#include "proto/machine.pb.h"

namespace intaglio::motion_bridge {

/// The controller's newest word on itself.
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
  std::string message;  ///< the fault in a sentence that says what to do
  /// Why the controller that answers now is refused, and what to do; empty: it is not.
  std::string refusal = {};
  double following_error_max_um = 0;
  std::uint32_t clock = 0;   ///< of its own, another number is another clock; 0: none
  std::uint64_t number = 0;  ///< grows with every word of the controller
};

/// Actual positions at consecutive ticks, or when a clock of its own was told of them.
struct LatchedPositions {
  std::uint32_t run = 0;
  std::uint64_t first_tick = 0;
  PointList positions_mm;
  std::vector<std::uint64_t> at_ns = {};  ///< by a clock of its own; else empty
};

/// Not thread-safe. Nothing blocks: what cannot be sent now is refused by Room() == 0 or
/// kRefused and tried again by the caller.
class MotionDriver {
 public:
  virtual ~MotionDriver() = default;
  /// Moves bytes both ways and opens a lost line again; never an error by itself:
  /// state() tells.
  virtual void Poll() = 0;
  virtual int fd() const = 0;
  virtual const DriverState& state() const = 0;
  virtual std::vector<LatchedPositions> TakePositions() = 0;

  /// From rest, without a fault, at a tick to come. `start_ns` is that tick by the
  /// controller's own clock; 0 when it has none.
  virtual Status BeginRun(std::uint32_t run, std::uint64_t start_tick,
                          std::uint64_t start_ns) = 0;
  /// Segments that one Append would take now.
  virtual std::size_t Room() const = 0;
  /// All of them (1..Room()), or none and an error. `end_ns` has the times of their ends
  /// by the controller's own clock; empty when it has none.
  virtual Status Append(std::span<const motion::Segment> segments,
                        std::span<const std::uint64_t> end_ns) = 0;
  /// Brake to rest and forget the run.
  virtual Status AbortRun() = 0;
  /// Clear a fault whose cause is gone.
  virtual Status Reset() = 0;
};

/// The driver that the machine's motion_line names; kUnsupported lists what there is.
Result<std::unique_ptr<MotionDriver>> MakeDriver(const MachineSpec& machine);

}  // namespace intaglio::motion_bridge
