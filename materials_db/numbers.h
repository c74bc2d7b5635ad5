#pragma once

// Lists of numbers as text, bit for bit in both directions, independent of the locale.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace intaglio::materials_db {

/// Finite numbers between white space or commas; none when one of them is not a number.
std::optional<std::vector<double>> ParseNumbers(std::string_view text);

/// The shortest text that io::ParseFinite reads back as the same number.
std::string FormatNumber(double number);
/// The same, with one space between.
std::string FormatNumbers(const std::vector<double>& numbers);

/// The tokens of a line, split at white space.
std::vector<std::string_view> SplitTokens(std::string_view line);

}  // namespace intaglio::materials_db
