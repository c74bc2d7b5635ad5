#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --same-block: a person's statement that every job goes into the block that is in.
inline void AddSameBlockFlag(command_line::Command command, bool& same_block) {
  command.AddFlag(
      "--same-block", same_block,
      "with --arm: your statement that every job goes into the block that is in "
      "the machine; without it a job behind another one is armed only when "
      "door or key was opened in between, or at another station");
}

}  // namespace intaglio::cli
