#pragma once

// Threads and time for algorithms that choose neither themselves.

#include <functional>

#include "engrave/core/executor.h"

namespace intaglio::host {

/// As many threads as the machine has, for the time of each call.
Executor AllCores();

/// The share used of `seconds` > 0 from now on; passes 1 when they are over.
std::function<double()> ShareOfTime(double seconds);

}  // namespace intaglio::host
