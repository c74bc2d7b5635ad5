#pragma once

#include "engrave/core/result.h"
#include "services/client/exit_codes.h"

namespace intaglio::cli {

/// Prints the error on the standard error stream; returns the exit code of the command.
int Complain(const Error& error, int exit_code = client::kExitWrongInput);

}  // namespace intaglio::cli
