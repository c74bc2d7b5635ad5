#include "services/cli/fonts_command.h"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <iostream>
#include <memory>

#include "engrave/drawing/font_list.h"
#include "engrave/drawing/text_coverage.h"
#include "engrave/drawing/utf8_characters.h"
#include "engrave/io/lower_case.h"
#include "proto/lists.pb.h"
#include "services/cli/json/print_json.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"

namespace intaglio::cli {
namespace {

using drawing::InstalledFont;

constexpr std::size_t kMaxShownCharacters = 12;

struct FontsOptions {
  std::string family;
  std::string text;
  bool json = false;
};

struct FontRow {
  InstalledFont font;
  std::u32string missing;  ///< of the text
};

bool IsAsked(const InstalledFont& font, const std::string& family) {
  return io::LowerCase(font.family).find(io::LowerCase(family)) != std::string::npos;
}

/// Fonts that have the most characters of the text first.
Result<std::vector<FontRow>> FontRowsOf(const FontsOptions& options) {
  std::vector<FontRow> rows;
  for (InstalledFont& font : drawing::InstalledFonts()) {
    if (!IsAsked(font, options.family)) continue;
    FontRow row{std::move(font), {}};
    if (!options.text.empty()) {
      const drawing::FontSource source{row.font.file};
      const auto coverage = drawing::CoverageOf(options.text, {&source, 1});
      if (!coverage) {
        if (!drawing::CharactersOf(options.text)) return tl::unexpected(coverage.error());
        continue;  // the file cannot be used
      }
      for (const auto& c : coverage->missing) row.missing.push_back(c.character);
    }
    rows.push_back(std::move(row));
  }
  std::stable_sort(rows.begin(), rows.end(), [](const FontRow& a, const FontRow& b) {
    return a.missing.size() < b.missing.size();
  });
  return rows;
}

std::string CoverageText(const FontRow& row) {
  if (row.missing.empty()) return "all";
  const std::u32string shown = row.missing.substr(0, kMaxShownCharacters);
  const std::size_t more = row.missing.size() - shown.size();
  std::string text = "not";
  for (const char32_t c : shown) text += " " + drawing::NameOfCharacter(c);
  return more == 0 ? text : fmt::format("{} and {} more", text, more);
}

int PrintFontList(const std::vector<FontRow>& rows) {
  FontList list;
  for (const FontRow& row : rows) {
    FontRecord& font = *list.add_fonts();
    font.set_family(row.font.family);
    font.set_style(row.font.style);
    font.set_file(row.font.file);
    font.set_has_text(row.missing.empty());
    for (const char32_t c : row.missing) font.add_missing(drawing::Utf8Of({&c, 1}));
  }
  return PrintJson(list);
}

int Fonts(const FontsOptions& options) {
  const auto rows = FontRowsOf(options);
  if (!rows) return Complain(rows.error(), client::kExitWrongInput);
  if (rows->empty()) {
    return Complain(
        {ErrorCode::kNotFound,
         options.family.empty()
             ? "no font is installed; install the package fonts-dejavu-core, "
               "or give a job the file of a font"
             : fmt::format("no font \"{}\" is installed; intaglio fonts lists "
                           "all",
                           options.family),
         options.family},
        client::kExitWrongInput);
  }
  if (options.json) return PrintFontList(*rows);
  std::size_t family = 6, style = 5, file = 4;
  for (const FontRow& row : *rows) {
    family = std::max(family, row.font.family.size());
    style = std::max(style, row.font.style.size());
    file = std::max(file, row.font.file.size());
  }
  const bool with_text = !options.text.empty();
  fmt::print(std::cout, "{:<{}}  {:<{}}  {:<{}}{}\n", "FAMILY", family, "STYLE", style,
             "FILE", with_text ? file : 4, with_text ? "  HAS OF THE TEXT" : "");
  for (const FontRow& row : *rows) {
    fmt::print(std::cout, "{:<{}}  {:<{}}  {:<{}}{}\n", row.font.family, family,
               row.font.style, style, row.font.file, with_text ? file : 0,
               with_text ? "  " + CoverageText(row) : "");
  }
  return client::kExitGood;
}

}  // namespace

void AddFontsCommand(command_line::Command app) {
  auto options = std::make_shared<FontsOptions>();
  command_line::Command fonts =
      app.AddCommand("fonts", "list the fonts that can be engraved");
  fonts.AddOption("FAMILY", options->family, "only families with this in their name");
  fonts.AddOption("--text", options->text,
                  "which of them have the characters of this text; those that have all "
                  "come first");
  fonts.AddFlag("--json", options->json, "for programs");
  fonts.SetFooter(
      "Example: intaglio fonts --text \"Łódź\"\n"
      "A job names a font by its family and style, \"DejaVu Sans:Bold\", or by its "
      "file.");
  fonts.SetAction([options] { return Fonts(*options); });
}

}  // namespace intaglio::cli
