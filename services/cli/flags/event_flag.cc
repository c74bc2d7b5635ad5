
#include "services/cli/flags/event_flag.h"

namespace intaglio::cli {

void AddEventsFlag(command_line::Command command, bool& events) {
  command.AddFlag("--events", events,
                  "JSON lines for programs on the standard output, what people read on "
                  "the standard error stream");
}

}  // namespace intaglio::cli
