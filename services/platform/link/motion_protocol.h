#pragma once

// The messages of the motion line, between a motion bridge (host) and the virtual
// engraver's stage controller (device). Framing and byte order as in laser_protocol.h.
//
// A run is a program of position-velocity-time segments from rest to rest. It starts at
// an absolute tick; each segment is the cubic Hermite curve from the knot before it.
// Positions travel in whole nm (int32: +-2.1 m), velocities in nm/s, durations in 1/65536
// tick: sums are exact, and a point's knot falls on a whole tick.
//
// A controller with a clock of its own does not know how long a tick is. It announces
// this (ControllerClock), takes runs whose knots have times of its own clock, ns since
// its power-up, and stamps its positions with that clock: the host estimates how the two
// clocks relate.

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "services/platform/link/message.h"

namespace intaglio::link {

enum class MotionFrame : std::uint8_t {
  // host -> device
  kBeginRun = 0x30,
  kSegments = 0x31,
  kAbortRun = 0x32,  ///< no payload: brake to rest, drop the queue, end the run
  kMotionStatusRequest = 0x33,  ///< no payload
  kMotionReset = 0x34,          ///< no payload: clears a fault when its cause is gone
  kBeginTimedRun = 0x35,        ///< the next two only to a clock of its own
  kTimedSegments = 0x36,
  kJogMove = 0x37,
  kHome = 0x38,  ///< no payload: by hand, to where the axes count from
  kMoveBlock = 0x39,
  // device -> host
  kMotionIdentity = 0x40,  ///< once after every handshake
  kMotionStatus = 0x41,    ///< on request, on every fault, every 20 ms, at rest 40 ms
  kPositions = 0x42,
  kTimedPositions = 0x43,   ///< in place of kPositions from a clock of its own
  kControllerClock = 0x44,  ///< after the identity: this controller has its own clock
  kStageTolerance = 0x45,   ///< after the identity: this controller reports its tolerance
  kStageSpeed = 0x46,       ///< after the identity, before the tolerance
};

/// Refused (status with fault kRunRefused) unless the stage is at rest without a fault,
/// and with kBlockPlace unless the stage that carries the block is at this place; a
/// controller without one takes 0 alone. A run during which the block leaves the place
/// ends with the same fault.
struct BeginRun {
  std::uint32_t run = 0;
  std::uint64_t start_tick = 0;  ///< in the future
  std::int32_t block_x_nm = 0, block_y_nm = 0;
};

struct WireSegment {
  std::int32_t x_nm = 0, y_nm = 0, z_nm = 0;  ///< end position, machine frame
  std::int32_t vx_counts = 0, vy_counts = 0, vz_counts = 0;  ///< end velocity
  std::uint32_t duration_subticks = 0;                       ///< > 0
  bool pulse = false;        ///< in-position output at its end
  bool program_end = false;  ///< at rest at its end, run over
};

struct Segments {
  std::uint32_t run = 0;
  std::uint64_t first_number = 0;     ///< of the first segment in its run, from 0
  std::vector<WireSegment> segments;  ///< 1..kMaxSegments
};
inline constexpr std::size_t kMaxSegments = 32;

struct MotionIdentity {
  std::int32_t travel_min_nm[3] = {0, 0, 0};
  std::int32_t travel_max_nm[3] = {0, 0, 0};
  std::uint32_t queue_capacity = 0;  ///< segments
  std::string serial_number = {};    ///< printable ASCII, at most 64; empty: it has none
  /// Its compare output is on for an instant when the stage passes nearest to a knot that
  /// is marked for a pulse, within the tick that begins at the knot.
  bool compares_place = false;
  /// Its stage floats on compressed air: without pressure it neither moves nor takes a
  /// run, with the fault kNoAir.
  bool watches_air = false;
  /// One count of the velocities on this line, > 0. With 1 nm/s an axis makes 2.1 m/s at
  /// most; mirrors are faster.
  std::uint32_t velocity_unit_nm_s = 1;
  /// It has a stage that carries the block under a scan head (MoveBlock).
  bool moves_block = false;
};

enum class StageFault : std::uint8_t {
  kNone = 0,
  kStarved = 1,         ///< the queue ran empty in mid-run (never in lockstep: it waits)
  kLimit = 2,           ///< an end position outside the travel
  kFollowingError = 3,  ///< the stage is not where it should be
  kLate = 4,            ///< start tick in the past
  kRunRefused = 5,
  kSafeState = 6,    ///< no valid frame for 250 ms: the stage was stopped
  kBadSequence = 7,  ///< segment numbers with a gap
  kNoAir = 8,        ///< its bearings have no compressed air; no Reset clears it
  kAirReturned = 9,  ///< it stopped for that; Reset clears it
  kBlockPlace = 10,  ///< the block is not where the run needs it
  // Of a stage whose axes find their place by switches:
  kPlaceLost = 11,    ///< a run where the axes may be anywhere: Home is first
  kNoSwitch = 12,     ///< Home: a switch was not met within the way that was searched
  kSwitchStuck = 13,  ///< Home: a switch stays pressed
  kSwitchMet = 14,    ///< outside Home a switch was met: the place is lost
  kDriveFault = 15,   ///< an amplifier reports a fault; no Reset clears it before
  kStopPressed = 16,  ///< the stop button; no Reset clears it while it is pressed
  kTooFast = 17,      ///< a segment ends faster than the axes can be stepped
};

struct MotionStatus {
  std::uint64_t tick = 0;
  std::int32_t x_nm = 0, y_nm = 0, z_nm = 0;                 ///< actual position
  std::int32_t vx_counts = 0, vy_counts = 0, vz_counts = 0;  ///< actual velocity
  std::uint32_t run = 0;
  std::uint64_t covered_through_tick = 0;  ///< last whole tick the queue reaches
  std::uint32_t queue_free = 0;            ///< segments that still fit
  std::uint64_t segments_taken = 0;        ///< of this run, since its begin
  bool at_rest = true;                     ///< no run, at rest
  StageFault fault = StageFault::kNone;
  std::uint32_t following_error_max_nm = 0;  ///< since the last status
  /// JogMove, Home and MoveBlock since power-up, modulo 2^32.
  std::uint32_t jogs_taken = 0;
  /// Actual place of the stage that carries the block, by its own axes; 0: it has none.
  std::int32_t block_x_nm = 0, block_y_nm = 0;
  bool place_lost = false;  ///< the axes may be anywhere: only Home moves them
  std::array<bool, 3> fault_axes = {};  ///< those that the fault is of; none: not known
};

/// Motion by hand, without a run: straight to a place of the axes, by the controller's
/// own timer, with constant acceleration and at most this speed. Dropped unless at rest
/// without a fault; kAbortRun ends it at rest. A place outside the travel is kLimit, and
/// nothing moves. Every JogMove and Home is counted in MotionStatus::jogs_taken, also one
/// that is dropped.
struct JogMove {
  std::int32_t x_nm = 0, y_nm = 0, z_nm = 0;
  std::uint32_t speed_nm_s = 0;  ///< of the focus, > 0
};

/// As JogMove, of the stage that carries the block: by its own axes, straight, without a
/// run, counted in jogs_taken. The other axes rest meanwhile. A controller without such a
/// stage drops it.
struct MoveBlock {
  std::int32_t x_nm = 0, y_nm = 0;
  std::uint32_t speed_nm_s = 0;  ///< > 0
};

/// Actual positions latched at lamp sync, one a tick while a run is executed, in order.
struct Positions {
  std::uint32_t run = 0;
  std::uint64_t first_tick = 0;
  struct Position {
    std::int32_t x_nm = 0, y_nm = 0, z_nm = 0;
  };
  std::vector<Position> positions;  ///< 1..kMaxPositions
};
inline constexpr std::size_t kMaxPositions = 64;

/// As BeginRun.
struct BeginTimedRun {
  std::uint32_t run = 0;
  std::uint64_t start_ns = 0;  ///< controller's clock, in the future
  std::int32_t block_x_nm = 0, block_y_nm = 0;
};

struct WireTimedSegment {
  std::int32_t x_nm = 0, y_nm = 0, z_nm = 0;  ///< end position, machine frame
  std::int32_t vx_counts = 0, vy_counts = 0, vz_counts = 0;  ///< end velocity
  std::uint64_t end_ns = 0;  ///< controller's clock, after the segment's before
  bool pulse = false;        ///< in-position output around its end
  bool program_end = false;  ///< at rest at its end, run over
};

struct TimedSegments {
  std::uint32_t run = 0;
  std::uint64_t first_number = 0;
  std::vector<WireTimedSegment> segments;  ///< 1..kMaxTimedSegments
};
inline constexpr std::size_t kMaxTimedSegments = 30;

/// Actual positions, one for every lamp sync that the controller was notified of, in
/// order.
struct TimedPositions {
  std::uint32_t run = 0;
  std::uint64_t first_tick = 0;
  struct Position {
    std::uint64_t at_ns = 0;  ///< controller's clock, when it was notified of the tick
    std::int32_t x_nm = 0, y_nm = 0, z_nm = 0;  ///< at that time, a while after the tick
  };
  std::vector<Position> positions;  ///< 1..kMaxTimedPositions
};
inline constexpr std::size_t kMaxTimedPositions = 48;

/// Sent once after the identity.
struct ControllerClock {
  std::uint32_t power_up = 0;  ///< random number, not 0: another one is another clock
  std::uint64_t now_ns = 0;    ///< since power-up
};

/// Sent once between the identity and the tolerance, by a controller that ends a run of
/// faster segments with kTooFast: its motors are stepped.
struct StageSpeed {
  /// No axis goes faster, > 0; counts as of velocities.
  std::uint32_t x_counts = 0, y_counts = 0, z_counts = 0;
};

/// Sent once after the identity. A controller that does not send it has an in-position
/// output of unknown tolerance.
struct StageTolerance {
  std::uint32_t position_nm = 0;  ///< of the in-position output, > 0
};

}  // namespace intaglio::link
