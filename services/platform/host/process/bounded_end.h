#pragma once

// A service that has said that it ends has let go of its machine; what is left is the end
// of the DDS participant. On a secured bus the library (Cyclone DDS 0.10.2) was seen to
// loop there for good, in the timers of its handshakes (dds_security_fsm_stop), with a
// whole processor, on a busy computer.

#include <chrono>

namespace intaglio::host {

/// Ends the process with this exit code after this time, if it has not ended until then,
/// with a sentence on stderr. Uses SIGALRM. `time`: 1 s at least.
void EndWithin(std::chrono::seconds time, int exit_code);

}  // namespace intaglio::host
