#pragma once

// A process that serves a machine in real time asks the system not to keep it waiting:
// before the lines fall silent for 250 ms, it is its turn, and its memory is there.

#include <string>

namespace intaglio::link {

/// What the system gave, and what it refused, each as a part of a sentence; empty:
/// nothing.
struct RealTimeGrant {
  std::string granted, refused;
};

/// Round-robin real-time scheduling for this thread and those it starts; where the system
/// refuses that, a nice value below all others that it allows.
RealTimeGrant RaisePriority();

/// The same, and memory locked.
RealTimeGrant AskForRealTime();

}  // namespace intaglio::link
