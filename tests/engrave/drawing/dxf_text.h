#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace intaglio::drawing {

/// A file from "code value|code value|..." behind the sections' own lines.
inline std::string Groups(const std::string& pairs) {
  std::string text;
  std::string_view rest = pairs;
  while (!rest.empty()) {
    const auto bar = rest.find('|');
    const std::string_view pair = rest.substr(0, bar);
    const auto blank = pair.find(' ');
    text += fmt::format("{}\n{}\n", pair.substr(0, blank), pair.substr(blank + 1));
    rest = bar == rest.npos ? "" : rest.substr(bar + 1);
  }
  return text;
}
inline std::string Entities(const std::string& pairs) {
  return Groups("0 SECTION|2 ENTITIES|" + pairs + "|0 ENDSEC|0 EOF");
}
inline std::string WithBlocks(const std::string& blocks, const std::string& entities) {
  return Groups("0 SECTION|2 BLOCKS|" + blocks + "|0 ENDSEC") + Entities(entities);
}

}  // namespace intaglio::drawing
