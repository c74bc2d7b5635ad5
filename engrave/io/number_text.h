#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace intaglio::io {

/// The shortest decimals that give the same double, with an exponent where that is
/// shorter.
void AppendShortest(double value, std::string& text);

/// The same without an exponent, for readers that know none. 326 characters at most.
void AppendShortestFixed(double value, std::string& text);

/// The number that the word is as a whole, rounded to Number (float or double), finite or
/// not; a plus sign may be in front of it. What is too large is infinite, what is too
/// small is 0. Nothing when the word is not a number.
template <typename Number = double>
std::optional<Number> ParseNumber(std::string_view word);
extern template std::optional<float> ParseNumber(std::string_view word);
extern template std::optional<double> ParseNumber(std::string_view word);

/// The same; nothing when the number is not finite.
std::optional<double> ParseFinite(std::string_view word);

}  // namespace intaglio::io
