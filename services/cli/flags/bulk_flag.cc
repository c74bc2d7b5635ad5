#include "services/cli/flags/bulk_flag.h"

namespace intaglio::cli {

command_line::Option AddBulkFlag(command_line::Command command, std::string& bulk) {
  return command
      .AddOption("--bulk", bulk,
                 "what a recording keeps of models, points, motion and positions, which "
                 "are most of its size: all (default), thin (one message in ten, no "
                 "models), none")
      .OneOf({"all", "thin", "none"});
}

}  // namespace intaglio::cli
