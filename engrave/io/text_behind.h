#pragma once

// What stands behind the end of a file, where readers of its format read no more.

#include <string_view>

namespace intaglio::io {

/// The text from `end` on without the blanks before it, NUL and ^Z, with which old
/// systems fill a file up.
inline std::string_view TextBehind(std::string_view text, std::size_t end) {
  constexpr std::string_view kNothing(" \t\r\n\f\0\x1a", 7);
  const std::size_t begin = text.find_first_not_of(kNothing, end);
  return begin == std::string_view::npos ? std::string_view() : text.substr(begin);
}

}  // namespace intaglio::io
