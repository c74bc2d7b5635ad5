#pragma once

#include "services/platform/command_line/program.h"

namespace intaglio::cli {

/// --same-block: a person's statement that every job goes into the block that is in. It
/// would be lost without a word where the command arms nothing.
inline void AddSameBlockFlag(command_line::Command command, bool& same_block) {
  const auto flag = command.AddFlag(
      "--same-block", same_block,
      "with --arm: your statement that every job goes into the block that is in "
      "the machine; without it a job behind another one is armed only when "
      "door or key was opened in between, or at another station");
  flag.Need(command.OptionOf("--arm"));
}

}  // namespace intaglio::cli
