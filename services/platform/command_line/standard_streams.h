#pragma once

// The three standard streams of a program. With one of them closed (`intaglio up >&-`),
// the next file that is opened would get its number, and what is printed would be
// written into a lock, a journal or a queue.

#include "engrave/core/result.h"

namespace intaglio::command_line {

/// Each that is closed becomes one that cannot be used: reading or writing it fails.
/// Before anything is opened.
void KeepStandardStreams();

/// Whether everything printed to the standard output has arrived there. kIo, with the
/// cause: results are missing in the file or the pipe that it leads to.
Status FlushOutput();

}  // namespace intaglio::command_line
