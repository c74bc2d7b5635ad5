#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace intaglio::io {

/// The shortest decimals that give the same double, with an exponent where that is
/// shorter.
void AppendShortest(double value, std::string& text);

/// The same without an exponent, for readers that do not support one. 326 characters at
/// most.
void AppendShortestFixed(double value, std::string& text);

/// The number that the whole text represents, rounded to Number (float or double), finite
/// or not; a leading plus sign is allowed. Too large a number is infinite, too small a
/// number is 0. Nothing when the text is not a number.
template <typename Number = double>
std::optional<Number> ParseNumber(std::string_view word);
extern template std::optional<float> ParseNumber(std::string_view word);
extern template std::optional<double> ParseNumber(std::string_view word);

/// The same; nothing when the number is not finite.
std::optional<double> ParseFinite(std::string_view word);

}  // namespace intaglio::io
