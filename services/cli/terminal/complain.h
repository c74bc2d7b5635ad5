#pragma once

#include "engrave/core/result.h"
#include "engrave/core/warning.h"
#include "services/client/exit_codes.h"

namespace intaglio::cli {

/// Prints the error on the standard error stream, with --json as a CommandAnswer on the
/// standard output (command_outcome.h); returns the exit code of the command.
int Complain(const Error& error, int exit_code = client::kExitWrongInput);

/// Warnings of texts before the work begins, on the standard error stream.
void PrintTextWarnings(const Warnings& warnings);

/// Warnings and notes of files, as reports have them, on the standard error stream.
void PrintWarningLines(const Warnings& warnings);

}  // namespace intaglio::cli
