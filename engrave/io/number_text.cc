#include "engrave/io/number_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <type_traits>

namespace intaglio::io {

void AppendShortest(double value, std::string& text) {
  std::array<char, 32> digits;  // the longest double takes 24
  const auto written = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  text.append(digits.data(), written.ptr);
}

void AppendShortestFixed(double value, std::string& text) {
  std::array<char, 352> digits;  // the smallest denormal takes 326, the largest double
                                 // 309
  const auto written = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                     std::chars_format::fixed);
  text.append(digits.data(), written.ptr);
}

template <typename Number>
std::optional<Number> ParseNumber(std::string_view word) {
  if (word.size() > 1 && word[0] == '+' && word[1] != '-') word.remove_prefix(1);
  const char* end = word.data() + word.size();
  Number value = 0;
  const auto parsed = std::from_chars(word.data(), end, value);
  if (parsed.ptr != end) return std::nullopt;
  if (parsed.ec == std::errc()) return value;
  if (parsed.ec != std::errc::result_out_of_range) return std::nullopt;
  // from_chars returns no value for a number that is too large or too small.
  if constexpr (std::is_same_v<Number, float>) {
    double wide = 0;
    if (std::from_chars(word.data(), end, wide).ec == std::errc()) {
      return static_cast<float>(wide);
    }
  }
  const bool tiny = word.find("e-") != std::string_view::npos ||
                    word.find("E-") != std::string_view::npos;
  const Number magnitude = tiny ? 0 : std::numeric_limits<Number>::infinity();
  return word[0] == '-' ? -magnitude : magnitude;
}

template std::optional<float> ParseNumber(std::string_view word);
template std::optional<double> ParseNumber(std::string_view word);

std::optional<double> ParseFinite(std::string_view word) {
  const std::optional<double> number = ParseNumber(word);
  return number && std::isfinite(*number) ? number : std::nullopt;
}

}  // namespace intaglio::io
