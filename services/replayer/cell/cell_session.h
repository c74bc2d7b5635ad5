#pragma once

// What a synchronizer received while it had one task, from the recording: when its runs
// began, the stage's positions, what became of each armed point, and whatever else came
// between (permission, stops, interlocks, faults of the stage, a withdrawn task).
//
// The laser's line itself is not recorded, but its content is on the bus: LampSync and
// Interlock are its statuses, PulseEventBatch its reports. What is in neither (how far it
// was decided, its counters of a session) follows from what the synchronizer sends to it.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "engrave/core/geometry.h"
#include "proto/task.pb.h"
#include "services/platform/recording/mcap_reader.h"
#include "services/replayer/cell/cell_messages.h"
#include "services/replayer/recorded_samples.h"
#include "services/replayer/recorded_stops.h"

namespace intaglio::replayer {

/// Permission, without its own number.
struct PermissionMessage {
  std::uint64_t epoch = 0, grant = 0, renewal = 0;
  bool granted = false;
  std::uint32_t speed_percent = 100, first_point = 0;
  bool fire_uncertain = false;
  bool operator==(const PermissionMessage&) const = default;
};
/// Those of the machine's own interlocks that no process on the bus can change.
struct InterlockMessage {
  bool key_on = true, door_closed = true;
  bool stop_released = true, safe_state = false;
  bool operator==(const InterlockMessage&) const = default;
};
struct StageFaultMessage {
  std::string fault;  ///< intaglio_MotionFault by name
  std::string message;
  bool operator==(const StageFaultMessage&) const = default;
};
struct RevokeMessage {
  bool take_up = false;
};

struct CellEvent {
  std::uint64_t time_ns = 0;  ///< when it was published
  std::size_t run = 0;        ///< before the begin of run number `run` of the reports
  std::uint64_t tick = 0;     ///< newest of the lamp by then; 0: none yet
  std::variant<PermissionMessage, StopMessage, InterlockMessage, StageFaultMessage,
               RevokeMessage>
      message;
};

struct CellSession {
  RecordedTask task;
  FrozenJob job;
  CellMessages messages;        ///< what it made of it
  std::vector<Vec3> starts_mm;  ///< the stage's position at rest, of each run
  /// Where the stage that carries the block was, by its own axes, when the first run
  /// began; none: the machine has none.
  std::optional<Vec2> block_mm;
  std::vector<CellEvent> events;  ///< by time
  /// Version of the taught positions that the machine had when its first run began, or at
  /// the end without one; nothing: not recorded.
  std::optional<std::uint32_t> taught_number;
  /// Something happened that cannot be made to happen again: a sentence. The reports end
  /// before it.
  std::string ends_early;
  /// Topic of which there is nothing of this task, although there was; empty: none.
  std::string lacks;
};

/// Reads all engraving tasks of which something was recorded. kUnsupported for a
/// recording whose samples are not known.
Result<std::vector<CellSession>> ReadCellSessions(const recording::McapReader& reader);

}  // namespace intaglio::replayer
