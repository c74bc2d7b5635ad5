#pragma once

// Threads and time for algorithms that choose neither themselves.

#include <cstddef>
#include <functional>

#include "engrave/core/executor.h"

namespace intaglio::host {

/// This many threads (1 or more), for the time of each call; all but the caller give way.
Executor OnThreads(std::size_t threads);

/// OnThreads for as many as the machine has.
Executor AllCores();

/// Puts the calling thread behind those that have to answer in time: a computation can
/// wait, a heartbeat cannot.
void GiveWay();

/// The share used of `seconds` > 0 from now on; passes 1 when they are over.
std::function<double()> ShareOfTime(double seconds);

}  // namespace intaglio::host
