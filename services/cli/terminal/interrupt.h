#pragma once

namespace intaglio::cli {

/// From now on Ctrl-C and SIGTERM are counted instead of ending the process.
void CatchInterrupts();
/// How often that happened.
int Interrupts();

}  // namespace intaglio::cli
