#pragma once

// Completion of commands, options and choices in shells, made from a program's tables.

#include <string>

#include "services/platform/command_line/description.h"

namespace intaglio::command_line {

/// Scripts that the shells load for `program`. They complete commands, options and the
/// values of options that have choices; everything else as file names. Hidden options
/// (without a group) are left out.
std::string BashCompletion(const std::string& program, const CommandDescription& root);
std::string ZshCompletion(const std::string& program, const CommandDescription& root);
std::string FishCompletion(const std::string& program, const CommandDescription& root);

}  // namespace intaglio::command_line
