#pragma once

// A line of a text format without the blanks around it, and without the carriage return
// that other systems write before its end.

#include <string_view>

namespace intaglio::io {

inline std::string_view TrimmedLine(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = line.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return line.substr(first, line.find_last_not_of(kBlanks) - first + 1);
}

}  // namespace intaglio::io
