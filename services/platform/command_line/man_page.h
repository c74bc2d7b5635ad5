#pragma once

// Manual pages made from the tables of commands and options.

#include <string>
#include <vector>

#include "services/platform/command_line/description.h"

namespace intaglio::command_line {

struct ManPage {
  std::string file_name;  ///< "intaglio-run.1"
  std::string text;       ///< troff with the macros of man(7), UTF-8
};

/// The page of a program, and one of each of its commands, which has the commands below
/// it as sections; `man PROGRAM COMMAND` opens it. Section 1 of the manual. Hidden
/// options (without a group) are left out.
std::vector<ManPage> ManPagesOf(const std::string& program,
                                const CommandDescription& description);

}  // namespace intaglio::command_line
