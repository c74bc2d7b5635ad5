#include "services/platform/command_line/option_text.h"

#include <fmt/format.h>

namespace intaglio::command_line {

bool IsHidden(const OptionDescription& option) {
  return option.group.empty() && !option.positional;
}

// The kind of value is followed by the checks of the value: "INT:INT in [0 - 99]".
std::string PlaceholderOf(const OptionDescription& option) {
  const std::string kind = option.value.substr(0, option.value.find(':'));
  if (kind == "FLOAT") return "NUMBER";
  return kind == "INT" || kind == "UINT" ? "N" : kind;
}

std::string RangeOf(const OptionDescription& option) {
  const auto begin = option.value.find(" in [");
  const auto dash = option.value.find(" - ", begin);
  const auto end = option.value.find(']', dash);
  if (begin == std::string::npos || dash == std::string::npos || end == std::string::npos)
    return option.value.ends_with(":POSITIVE") ? "above 0" : "";
  return fmt::format("{}..{}", option.value.substr(begin + 5, dash - begin - 5),
                     option.value.substr(dash + 3, end - dash - 3));
}

}  // namespace intaglio::command_line
