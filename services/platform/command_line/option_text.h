#pragma once

// What manual pages and completions show of an option.

#include <string>

#include "services/platform/command_line/description.h"

namespace intaglio::command_line {

/// Not in --help either: an option without a heading.
bool IsHidden(const OptionDescription& option);
/// What is typed behind the option's name: "TEXT", "NUMBER", "N"; "" of a flag.
std::string PlaceholderOf(const OptionDescription& option);
/// "0..99"; "" when any value is allowed.
std::string RangeOf(const OptionDescription& option);

}  // namespace intaglio::command_line
