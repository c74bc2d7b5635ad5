#pragma once

// The table of commands of intaglio as one list.

#include <vector>

#include "services/cli/intaglio_program.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// All below `command`.
inline void CollectCommands(const command_line::CommandDescription& command,
                            std::vector<command_line::CommandDescription>& all) {
  for (const command_line::CommandDescription& below : command.commands) {
    all.push_back(below);
    CollectCommands(below, all);
  }
}

inline std::vector<command_line::CommandDescription> AllCommands() {
  std::vector<command_line::CommandDescription> all;
  CollectCommands(IntaglioProgram()->Describe(), all);
  return all;
}

}  // namespace intaglio::cli
