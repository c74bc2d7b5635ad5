#pragma once

// The UTF-8 byte order mark, which editors and spreadsheets of Windows write before a
// text: EF BB BF (Unicode 15, 23.8). It is no part of the text, and readers of text
// formats skip it.

#include <string_view>

namespace intaglio::io {

inline constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

inline std::string_view WithoutByteOrderMark(std::string_view text) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  return text;
}

}  // namespace intaglio::io
