#include "materials_db/numbers.h"

#include <fmt/format.h>

#include "engrave/io/number_text.h"

namespace intaglio::materials_db {
namespace {

bool IsSpace(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == '\f' || c == '\v';
}

/// Parts between characters for which `is_separator` holds, empty ones left out.
template <typename F>
std::vector<std::string_view> Split(std::string_view text, F is_separator) {
  std::vector<std::string_view> parts;
  std::size_t i = 0;
  while (i < text.size()) {
    while (i < text.size() && is_separator(text[i])) ++i;
    const std::size_t start = i;
    while (i < text.size() && !is_separator(text[i])) ++i;
    if (i > start) parts.push_back(text.substr(start, i - start));
  }
  return parts;
}

}  // namespace

std::optional<std::vector<double>> ParseNumbers(std::string_view text) {
  std::vector<double> numbers;
  for (const auto word : Split(text, [](char c) { return IsSpace(c) || c == ','; })) {
    const auto number = io::ParseFinite(word);
    if (!number) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

std::string FormatNumber(double number) { return fmt::format("{}", number); }

std::string FormatNumbers(const std::vector<double>& numbers) {
  return fmt::format("{}", fmt::join(numbers, " "));
}

std::vector<double> NumbersOf(std::span<const optics::Transmittance> table) {
  std::vector<double> numbers;
  for (const optics::Transmittance& entry : table) {
    numbers.insert(numbers.end(), {entry.wavelength_um, entry.ratio, entry.thickness_mm});
  }
  return numbers;
}

std::optional<std::vector<optics::Transmittance>> TransmittanceIn(std::string_view text) {
  const auto numbers = ParseNumbers(text);
  if (!numbers || numbers->size() % 3 != 0) return std::nullopt;
  std::vector<optics::Transmittance> table;
  for (std::size_t i = 0; i < numbers->size(); i += 3) {
    table.push_back({(*numbers)[i], (*numbers)[i + 1], (*numbers)[i + 2]});
  }
  return table;
}

std::vector<std::string_view> SplitTokens(std::string_view line) {
  return Split(line, IsSpace);
}

}  // namespace intaglio::materials_db
