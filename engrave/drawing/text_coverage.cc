#include "engrave/drawing/text_coverage.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/drawing/font_face.h"
#include "engrave/drawing/font_list.h"
#include "engrave/drawing/utf8_characters.h"

namespace intaglio::drawing {
namespace {

constexpr std::size_t kMaxNamed = 20;

/// Every character that needs a letter, once, with its first line.
std::vector<MissingCharacter> DistinctCharacters(std::u32string_view text) {
  std::vector<MissingCharacter> distinct;
  std::set<char32_t> seen;
  std::size_t line = 1;
  for (const char32_t c : text) {
    if (c == '\n') ++line;
    if (c == '\n' || c == '\r' || !seen.insert(c).second) continue;
    distinct.push_back({c, line});
  }
  return distinct;
}

std::u32string Uncovered(std::u32string_view text, const FontFace& font) {
  std::u32string uncovered;
  for (const MissingCharacter& c : DistinctCharacters(text)) {
    if (!font.Has(c.character)) uncovered.push_back(c.character);
  }
  return uncovered;
}

}  // namespace

Result<TextCoverage> CoverageOf(std::string_view utf8,
                                std::span<const FontSource> fonts) {
  Require(!fonts.empty(), "CoverageOf without a font");
  const auto text = INTAGLIO_TRY(CharactersOf(utf8));
  TextCoverage coverage;
  coverage.missing = DistinctCharacters(text);
  for (std::size_t i = 0; i < fonts.size(); ++i) {
    if (i > 0 && coverage.missing.empty()) break;
    const auto face = INTAGLIO_TRY(FontFace::Open(fonts[i]));
    coverage.fonts.push_back(face.Name());
    std::erase_if(coverage.missing, [&](const MissingCharacter& c) {
      const bool found = face.Has(c.character);
      if (found && i > 0) coverage.borrowed[i].push_back(c.character);
      return found;
    });
  }
  return coverage;
}

Status CheckCoverage(const TextCoverage& coverage) {
  if (coverage.missing.empty()) return {};
  std::vector<std::string> named;
  for (const MissingCharacter& c : coverage.missing) {
    if (named.size() == kMaxNamed) break;
    named.push_back(
        c.line == 1 ? NameOfCharacter(c.character)
                    : fmt::format("{} in line {}", NameOfCharacter(c.character), c.line));
  }
  const std::size_t more = coverage.missing.size() - named.size();
  return Fail(
      ErrorCode::kMissing,
      fmt::format("no letter for {}{} in {}; name a font that has it, or another text",
                  fmt::join(named, ", "),
                  more > 0 ? fmt::format(" and {} more", more) : "",
                  fmt::join(coverage.fonts, ", ")),
      Utf8Of({&coverage.missing.front().character, 1}));
}

Result<std::vector<std::string>> NeededFallbacks(
    std::string_view utf8, const std::string& font,
    std::span<const std::string> candidates) {
  const auto text = INTAGLIO_TRY(CharactersOf(utf8));
  const auto first = INTAGLIO_TRY(FontFace::Open({font}));
  std::u32string missing = Uncovered(text, first);
  std::vector<std::string> needed;
  for (const std::string& candidate : candidates) {
    if (missing.empty()) break;
    const auto face = FontFace::Open({candidate});
    if (!face) continue;
    const std::u32string left = Uncovered(missing, *face);
    if (left.size() < missing.size()) needed.push_back(candidate);
    missing = left;
  }
  return needed;
}

Result<std::vector<std::string>> InstalledFallbacks(std::string_view utf8,
                                                    const std::string& font) {
  const auto text = INTAGLIO_TRY(CharactersOf(utf8));
  const auto first = INTAGLIO_TRY(FontFace::Open({font}));
  const std::u32string missing = Uncovered(text, first);
  if (missing.empty()) return std::vector<std::string>();
  return NeededFallbacks(utf8, font, FallbackFontFiles(missing));
}

}  // namespace intaglio::drawing
