#include <CLI/App.hpp>

#include "services/cli/event_lines.h"

namespace intaglio::cli {

void AddEventsFlag(CLI::App& command, bool& events) {
  command.add_flag("--events", events,
                   "JSON lines for programs on the standard output, what people read on "
                   "the standard error stream");
}

}  // namespace intaglio::cli
