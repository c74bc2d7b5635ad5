#pragma once

#include <string>

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --bulk: what a recording keeps of the topics that grow with a job's points; all, thin
/// or none. `bulk` stays empty, which is all, unless it is given.
command_line::Option AddBulkFlag(command_line::Command command, std::string& bulk);

}  // namespace intaglio::cli
