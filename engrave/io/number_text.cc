#include "engrave/io/number_text.h"

#include <array>
#include <charconv>

namespace intaglio::io {

void AppendShortest(double value, std::string& text) {
  std::array<char, 32> digits;  // the longest double takes 24
  const auto written = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), written.ptr);
}

void AppendShortestFixed(double value, std::string& text) {
  std::array<char, 352> digits;  // the least denormal takes 326, the largest double 309
  const auto written = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                     std::chars_format::fixed);
  text.append(digits.data(), written.ptr);
}

bool ParseNumber(std::string_view word, double& value) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const char* end = word.data() + word.size();
  const auto parsed = std::from_chars(word.data(), end, value);
  return parsed.ec == std::errc() && parsed.ptr == end;
}

}  // namespace intaglio::io
