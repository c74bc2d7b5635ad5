#pragma once

// Has a service repeat the tasks of a recording, alone on a bus of its own, and compares
// the new results with the recorded ones.
//
// The tasks are given one after the other to the one service that is there. Input goes
// under its credit; output is taken under credit and compared batch by batch, bit by bit.
// The results of the stages depend on their input, options and code alone, so that a
// difference has one of these causes, checked in this order:
//
//   option   an option of the frozen job is another one
//   input    nothing differs, and the recording lacks what a task was sent
//   chance   the same done twice now differs, too (an order that anneals for a time)
//   version  the software's version is another one
//   code     none of these
//
// From one thread.

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "proto/replay.pb.h"
#include "proto/task.pb.h"
#include "services/replayer/recorded_samples.h"

namespace intaglio::bus {
class Bus;
}

namespace intaglio::replayer {

enum class Stage { kDiscretize, kSort };

struct RehearsalOptions {
  Stage stage = Stage::kSort;
  /// Changes the options of a job before it is given; may be null.
  std::function<Status(FrozenJob& job)> change;
};

/// Asked some hundred times a second; an error ends everything.
using KeepOn = std::function<Status()>;

/// kMissing: nothing in the recording to compare. kTimedOut: no service, or it does not
/// go on. Other errors are those of `keep_on`. The field `recording` is left open.
Result<ReplayComparison> Rehearse(bus::Bus& bus, const recording::McapReader& reader,
                                  const RehearsalOptions& options, const KeepOn& keep_on);

}  // namespace intaglio::replayer
