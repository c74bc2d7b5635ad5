#pragma once

// A process that serves a machine in real time asks the system not to keep it waiting:
// before the lines fall silent for 250 ms, it is its turn, and its memory is there.

#include <string>

namespace intaglio::link {

/// Round-robin real-time scheduling for this thread and those it starts, memory locked.
/// Returns what the system refused, for the log; empty when it granted all.
std::string AskForRealTime();

}  // namespace intaglio::link
