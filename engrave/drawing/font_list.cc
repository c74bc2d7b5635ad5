#include "engrave/drawing/font_list.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <fontconfig/fontconfig.h>

#include <algorithm>
#include <array>
#include <memory>
#include <tuple>
#include <utility>

#include "engrave/drawing/closer.h"
#include "engrave/io/edit_distance.h"
#include "engrave/io/lower_case.h"

namespace intaglio::drawing {
namespace {

using FontConfig = std::unique_ptr<FcConfig, Closer<FcConfigDestroy>>;
using FontPattern = std::unique_ptr<FcPattern, Closer<FcPatternDestroy>>;
using FontObjects = std::unique_ptr<FcObjectSet, Closer<FcObjectSetDestroy>>;
using FontSet = std::unique_ptr<FcFontSet, Closer<FcFontSetDestroy>>;
using CharacterSet = std::unique_ptr<FcCharSet, Closer<FcCharSetDestroy>>;

constexpr std::size_t kMaxProposed = 16;
constexpr std::size_t kMaxSuggestions = 3;

// What packages of Debian have, wide coverage first.
constexpr std::array kUsualFamilies = {
    "DejaVu Sans",        "Noto Sans",         "Liberation Sans",  "FreeSans",
    "Noto Sans Symbols2", "Noto Sans Symbols", "Noto Sans CJK JP", "Droid Sans Fallback",
    "WenQuanYi Zen Hei",  "Noto Sans Hebrew",  "Noto Sans Thai",   "Noto Sans Georgian",
    "Noto Sans Armenian", "Unifont",           "Symbola"};

FcConfig* Config() {
  static const FontConfig config(FcInitLoadConfigAndFonts());
  return config.get();
}

const FcChar8* Bytes(const std::string& text) {
  return reinterpret_cast<const FcChar8*>(text.c_str());
}

std::string TextOf(FcPattern* font, const char* object) {
  FcChar8* text = nullptr;
  if (FcPatternGetString(font, object, 0, &text) != FcResultMatch) return "";
  return reinterpret_cast<const char*>(text);
}

/// Fonts with outlines; of a collection its first, which a file without an index means.
std::vector<InstalledFont> FontsLike(FcPattern* pattern) {
  FcPatternAddBool(pattern, FC_OUTLINE, FcTrue);
  const FontObjects objects(
      FcObjectSetBuild(FC_FAMILY, FC_STYLE, FC_FILE, FC_INDEX, nullptr));
  const FontSet found(FcFontList(Config(), pattern, objects.get()));
  std::vector<InstalledFont> fonts;
  for (int i = 0; found != nullptr && i < found->nfont; ++i) {
    FcPattern* font = found->fonts[i];
    int index = 0;
    FcPatternGetInteger(font, FC_INDEX, 0, &index);
    const std::string file = TextOf(font, FC_FILE);
    if (file.empty() || (index & 0xFFFF) != 0) continue;
    fonts.push_back({TextOf(font, FC_FAMILY), TextOf(font, FC_STYLE), file});
  }
  const auto key = [](const InstalledFont& font) {
    return std::tie(font.family, font.style, font.file);
  };
  std::sort(fonts.begin(), fonts.end(),
            [&](const auto& a, const auto& b) { return key(a) < key(b); });
  fonts.erase(std::unique(fonts.begin(), fonts.end(),
                          [&](const auto& a, const auto& b) { return key(a) == key(b); }),
              fonts.end());
  return fonts;
}

std::vector<std::string> NearFamilies(const std::string& asked) {
  const std::string wanted = io::LowerCase(asked);
  std::vector<std::pair<std::size_t, std::string>> near;
  for (const InstalledFont& font : InstalledFonts()) {
    const std::string known = io::LowerCase(font.family);
    const std::size_t edits = io::EditDistance(wanted, known);
    const bool contained = wanted.size() >= 3 && known.find(wanted) != known.npos;
    if (contained || edits <= 1 + wanted.size() / 5)
      near.emplace_back(edits, font.family);
  }
  std::sort(near.begin(), near.end());
  std::vector<std::string> families;
  for (auto& [edits, family] : near) {
    if (families.size() == kMaxSuggestions) break;
    if (families.empty() || families.back() != family) families.push_back(family);
  }
  return families;
}

void AddUnlessThere(std::string file, std::vector<std::string>& files) {
  if (file.empty() || std::find(files.begin(), files.end(), file) != files.end()) return;
  files.push_back(std::move(file));
}

}  // namespace

std::vector<InstalledFont> InstalledFonts() {
  const FontPattern every(FcPatternCreate());
  return FontsLike(every.get());
}

bool IsFontFile(std::string_view font) {
  if (font.find('/') != font.npos) return true;
  constexpr std::string_view kEndings[] = {".ttf", ".otf", ".ttc",
                                           ".pfb", ".TTF", ".OTF"};
  return std::ranges::any_of(kEndings, [&](auto end) { return font.ends_with(end); });
}

Result<std::string> FindFontFile(std::string_view family) {
  const auto colon = family.find(':');
  const std::string name(family.substr(0, colon));
  const std::string style(colon == family.npos ? "" : family.substr(colon + 1));
  const FontPattern pattern(FcPatternCreate());
  FcPatternAddString(pattern.get(), FC_FAMILY, Bytes(name));
  if (!style.empty()) FcPatternAddString(pattern.get(), FC_STYLE, Bytes(style));
  std::pair<bool, std::string> best;
  for (const InstalledFont& font : FontsLike(pattern.get())) {
    // The first by path, regular fonts first: the same result in whatever order the fonts
    // are listed.
    const bool regular = font.style == "Regular" || font.style == "Book";
    const std::pair candidate(!(regular && style.empty()), font.file);
    if (best.second.empty() || candidate < best) best = candidate;
  }
  if (!best.second.empty()) return best.second;
  const auto near = NearFamilies(name);
  return Fail(ErrorCode::kNotFound,
              fmt::format("the font \"{}\" is not installed; {}install it, correct its "
                          "name (intaglio fonts) or give its file",
                          family,
                          near.empty() ? ""
                                       : fmt::format("did you mean {}? Else ",
                                                     fmt::join(near, " or "))),
              std::string(family));
}

std::vector<std::string> FallbackFontFiles(std::u32string_view characters) {
  std::vector<std::string> files;
  for (const char* family : kUsualFamilies) {
    if (auto file = FindFontFile(family)) AddUnlessThere(std::move(*file), files);
  }
  const CharacterSet set(FcCharSetCreate());
  for (const char32_t c : characters) FcCharSetAddChar(set.get(), c);
  const FontPattern pattern(FcPatternCreate());
  FcPatternAddCharSet(pattern.get(), FC_CHARSET, set.get());
  FcPatternAddBool(pattern.get(), FC_OUTLINE, FcTrue);
  FcConfigSubstitute(Config(), pattern.get(), FcMatchPattern);
  FcDefaultSubstitute(pattern.get());
  FcResult result = FcResultNoMatch;
  const FontSet proposed(FcFontSort(Config(), pattern.get(), FcTrue, nullptr, &result));
  const std::size_t max_count = files.size() + kMaxProposed;
  for (int i = 0; proposed != nullptr && i < proposed->nfont && files.size() < max_count;
       ++i) {
    AddUnlessThere(TextOf(proposed->fonts[i], FC_FILE), files);
  }
  return files;
}

}  // namespace intaglio::drawing
