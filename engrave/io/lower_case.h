#pragma once

#include <string>
#include <string_view>

namespace intaglio::io {

/// ASCII letters in lower case, all other bytes unchanged, independent of the locale.
constexpr char LowerCase(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

/// An ASCII letter, independent of the locale.
constexpr bool IsLetter(char c) {
  const char lower = LowerCase(c);
  return lower >= 'a' && lower <= 'z';
}

inline std::string LowerCase(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = LowerCase(c);
  return lower;
}

/// Of ".STL" or "STL": "stl".
inline std::string LowerCaseExtension(std::string_view extension) {
  if (extension.starts_with('.')) extension.remove_prefix(1);
  return LowerCase(extension);
}

}  // namespace intaglio::io
