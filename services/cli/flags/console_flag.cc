#include "services/cli/flags/console_flag.h"

namespace intaglio::cli {

void AddConsoleFlag(command_line::Command command, std::string& port) {
  command
      .AddFlag("--console{0}", port,
               "open a web console of this computer and print its address; =PORT: on "
               "that TCP port (docs/console.md)")
      .Within(0, 65535);
}

int ConsolePortOf(const std::string& port) { return port.empty() ? -1 : std::stoi(port); }

}  // namespace intaglio::cli
