#pragma once

// Names of tests with parameters: what a report of them lists.

#include <cctype>
#include <string>
#include <string_view>

namespace intaglio::test {

/// A name that GoogleTest accepts: letters and digits of the text, and underscores for
/// everything else.
inline std::string AsTestName(std::string_view text) {
  std::string name(text);
  for (char& c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
  }
  return name;
}

}  // namespace intaglio::test
