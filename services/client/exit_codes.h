#pragma once

namespace intaglio::client {

/// Exit codes of every command; docs/cli.md repeats them.
enum ExitCode : int {
  kExitGood = 0,
  kExitInternal = 1,    ///< a fault of ours, or a service died
  kExitWrongInput = 2,  ///< options, job file, model, glass, disk
  kExitNotGood = 3,     ///< engraved, and the verdict is not good
  kExitMachine = 4,     ///< a machine or job fault ended it
  kExitCancelled = 5,   ///< cancelled by a person
  kExitLeft = 6,        ///< Ctrl-C of a command that follows a job, which goes on
};

}  // namespace intaglio::client
