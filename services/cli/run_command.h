#pragma once

#include "engrave/core/result.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// Exit codes of every command; docs/cli.md repeats them.
enum ExitCode : int {
  kExitGood = 0,
  kExitInternal = 1,    ///< a fault of ours, or a service died
  kExitWrongInput = 2,  ///< options, job file, model, glass, disk
  kExitNotGood = 3,     ///< engraved, and the verdict is not good
  kExitMachine = 4,     ///< a machine or job fault ended it
  kExitCancelled = 5,   ///< somebody did
};

/// Says on the standard error stream what is wrong; the code, for the command to end
/// with.
int Complain(const Error& error, int exit_code = kExitWrongInput);

/// `intaglio run`: engraves one job with a private set of processes, and proves it.
void AddRunCommand(command_line::Command app);

}  // namespace intaglio::cli
