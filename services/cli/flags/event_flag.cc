
#include "services/cli/flags/event_flag.h"

namespace intaglio::cli {

void AddEventsFlag(command_line::Command command, bool& events) {
  command.AddFlag("--events", events,
                  "write JSON lines for programs to the standard output, text for people "
                  "to the standard error stream");
}

}  // namespace intaglio::cli
