#pragma once

#include "engrave/core/result.h"
#include "services/client/exit_codes.h"

namespace intaglio::cli {

/// Says on the standard error stream what is wrong; the code, for the command to end
/// with.
int Complain(const Error& error, int exit_code = client::kExitWrongInput);

}  // namespace intaglio::cli
