#include "services/cli/flags/console_flag.h"

namespace intaglio::cli {

void AddConsoleFlag(command_line::Command command, int& port) {
  command
      .AddFlag("--console{0}", port,
               "open a web console of this computer and print its address; =PORT: on "
               "that TCP port (docs/console.md)")
      .Within(0, 65535);
}

}  // namespace intaglio::cli
