#include "engrave/contour/files/gerber_parameters.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "engrave/core/try.h"
#include "engrave/io/number_text.h"

namespace intaglio::contour {
namespace {

constexpr double kMaxRepeat = 10'000;
constexpr std::size_t kMaxNumbers = 64;

tl::unexpected<Error> WrongParameter(const char* sentence) {
  return Fail(ErrorCode::kInvalidValue, sentence);
}

/// Numbers, each behind one of the letters, e.g. A0.00B0, or one without a letter, that
/// all have this value. None: the default, which is the value.
bool AreAll(std::string_view values, std::string_view letters, double value) {
  while (!values.empty()) {
    if (!letters.empty()) {
      if (letters.find(values.front()) == std::string_view::npos) return false;
      values.remove_prefix(1);
    }
    const std::size_t end =
        letters.empty() ? std::string_view::npos : values.find_first_of(letters);
    if (io::ParseFinite(values.substr(0, end)) != value) return false;
    values.remove_prefix(std::min(end, values.size()));
  }
  return true;
}

}  // namespace

Result<GerberFormat> ParseGerberFormat(std::string_view block) {
  if (block.size() != 10 || block[4] != 'X' || block[7] != 'Y' || block[3] != 'A' ||
      (block[2] != 'L' && block[2] != 'T') || block.substr(5, 2) != block.substr(8, 2) ||
      block[5] < '0' || block[5] > '6' || block[6] < '1' || block[6] > '7')
    return WrongParameter("expected an absolute format such as FSLAX46Y46");
  const int behind = block[6] - '0';
  return GerberFormat{block[5] - '0' + behind, behind, block[2] == 'T'};
}

Result<double> ParseGerberUnit(std::string_view block) {
  if (block != "MOMM" && block != "MOIN") return WrongParameter("expected MOMM or MOIN");
  return block == "MOMM" ? 1 : 25.4;
}

Result<GerberRepeat> ParseGerberRepeat(std::string_view block, double unit_mm) {
  double values[4] = {1, 1, 0, 0};
  for (std::size_t begin = 2; begin < block.size();) {
    const std::size_t letter = std::string_view("XYIJ").find(block[begin]);
    const std::size_t end =
        std::min(block.find_first_of("XYIJ", begin + 1), block.size());
    const auto value = io::ParseFinite(block.substr(begin + 1, end - begin - 1));
    if (letter == std::string_view::npos || !value || *value < 0 || *value > kMaxRepeat)
      return WrongParameter("expected a repeat such as SRX2Y3I5J4");
    values[letter] = *value;
    begin = end;
  }
  if (values[0] < 1 || values[1] < 1) return WrongParameter("a repeat has no times");
  return GerberRepeat{static_cast<int>(values[0]), static_cast<int>(values[1]),
                      unit_mm * Vec2(values[2], values[3])};
}

Result<std::pair<int, GerberAperture>> ParseGerberAperture(std::string_view block,
                                                           const GerberMacros& macros,
                                                           double unit_mm) {
  const std::size_t letter = block.find_first_not_of("0123456789", 3);
  double number = -1;
  if (letter != std::string_view::npos && letter > 3)
    number = io::ParseFinite(block.substr(3, letter - 3)).value_or(-1);
  if (!block.starts_with("ADD") || number < 10 || number > 1e6)
    return WrongParameter("expected an aperture such as ADD10C,0.5");
  const std::size_t comma = std::min(block.find(','), block.size());
  const std::string_view kind = block.substr(letter, comma - letter);
  std::vector<double> numbers;
  for (std::size_t begin = comma + 1; begin <= block.size();) {
    const std::size_t end = std::min(block.find('X', begin), block.size());
    std::string_view word = block.substr(begin, end - begin);
    word.remove_prefix(std::min(word.find_first_not_of(' '), word.size()));
    word = word.substr(0, word.find_last_not_of(' ') + 1);
    const auto value = io::ParseFinite(word);
    if (!value || numbers.size() == kMaxNumbers)
      return WrongParameter("an aperture has a wrong number");
    numbers.push_back(*value);
    begin = end + 1;
  }
  const auto macro = macros.find(kind);
  GerberAperture aperture = INTAGLIO_TRY(
      macro != macros.end()
          ? MacroAperture(macro->second, numbers, unit_mm)
          : StandardAperture(kind.size() == 1 ? kind[0] : '?', numbers, unit_mm));
  return std::pair(static_cast<int>(number), std::move(aperture));
}

bool HasNoEffect(std::string_view block) {
  const std::string_view code = block.substr(0, 2), values = block.substr(code.size());
  if (code == "LR" || code == "IR") return AreAll(values, "", 0);
  if (code == "LS") return AreAll(values, "", 1);
  if (code == "OF" || code == "MI") return AreAll(values, "AB", 0);
  if (code == "SF") return AreAll(values, "AB", 1);
  for (const char* name : {"TF", "TA", "LN", "IN"}) {
    if (code == name) return true;
  }
  for (const char* whole : {"IPPOS", "LMN", "ASAXBY", "ICAS"}) {
    if (block == whole) return true;
  }
  return false;
}

bool DrawsBackOfBoard(std::string_view text) {
  constexpr std::string_view kFunction = "TF.FileFunction,";
  const std::size_t found = text.find(kFunction);
  if (found == std::string_view::npos) return false;
  const std::string_view rest = text.substr(found + kFunction.size());
  const std::string_view function = rest.substr(0, rest.find('*'));
  return function.starts_with("Copper,") && function.find(",Bot") != function.npos;
}

}  // namespace intaglio::contour
