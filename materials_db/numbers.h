#pragma once

// Lists of numbers as text, bit for bit in both directions, independent of the locale.

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/optics/absorption.h"

namespace intaglio::materials_db {

/// Finite numbers between white space or commas; none when one of them is not a number.
std::optional<std::vector<double>> ParseNumbers(std::string_view text);

/// The shortest text that io::ParseFinite reads back as the same number.
std::string FormatNumber(double number);
/// The same, with one space between.
std::string FormatNumbers(const std::vector<double>& numbers);

/// Wavelength in um, ratio and thickness in mm of each entry, one entry after another.
std::vector<double> NumbersOf(std::span<const optics::Transmittance> table);
/// Back; nothing where the text is not three numbers an entry. Empty: no entries.
std::optional<std::vector<optics::Transmittance>> TransmittanceIn(std::string_view text);

/// The tokens of a line, split at white space.
std::vector<std::string_view> SplitTokens(std::string_view line);

}  // namespace intaglio::materials_db
