#pragma once

// Threads and time for algorithms that choose neither themselves.

#include <functional>

#include "engrave/core/executor.h"

namespace intaglio::host {

/// As many threads as the machine has, for the time of each call; all but the caller give
/// way.
Executor AllCores();

/// Puts the calling thread behind those that have to answer in time: a computation can
/// wait, a heartbeat cannot.
void GiveWay();

/// The share used of `seconds` > 0 from now on; passes 1 when they are over.
std::function<double()> ShareOfTime(double seconds);

}  // namespace intaglio::host
