#include "engrave/render/letters/letter_outlines.h"

#include <algorithm>
#include <map>
#include <mutex>
#include <string>

#include "engrave/core/try.h"
#include "engrave/drawing/flatten.h"
#include "engrave/drawing/font_list.h"
#include "engrave/drawing/font_outline.h"
#include "engrave/drawing/text_coverage.h"
#include "engrave/drawing/utf8_characters.h"

namespace intaglio::render {
namespace {

constexpr std::size_t kMaxKept = 500;  // lines of letters, which pictures repeat
// The flattened curves are as large as capitals of this height, mm.
constexpr double kCapital = 100;
constexpr double kChordTolerance = 0.2;
constexpr double kMaxTurn_rad = 0.3;

Result<drawing::Drawing> Outline(const std::string& utf8,
                                 const std::vector<std::string>& files,
                                 const std::string& font) {
  drawing::TextOptions options;
  options.font = {font};
  options.cap_height_mm = kCapital;
  for (const std::string& file :
       INTAGLIO_TRY(drawing::NeededFallbacks(utf8, font, files)))
    options.fallbacks.push_back({file});
  return drawing::TextOutline(utf8, options);
}

std::optional<LetterOutlines> OutlinesIn(const drawing::Drawing& drawn) {
  const auto flat =
      drawing::Flatten(drawn, {kChordTolerance, kMaxTurn_rad, std::uint64_t{1'000'000}});
  if (!flat) return std::nullopt;
  LetterOutlines outlines;
  for (const drawing::FlatCurve& curve : flat->curves) {
    std::vector<Vec2>& loop = outlines.loops.emplace_back();
    for (const Vec3& p : curve.points_mm) {
      loop.emplace_back(p.head<2>() / kCapital);
      outlines.width = std::max(outlines.width, loop.back().x());
    }
  }
  return outlines;
}

std::optional<LetterOutlines> SetLetters(std::u32string_view letters) {
  const std::vector<std::string> files = drawing::FallbackFontFiles(letters);
  const std::string utf8 = drawing::Utf8Of(letters);
  for (const std::string& font : files) {
    if (const auto drawn = Outline(utf8, files, font)) return OutlinesIn(*drawn);
  }
  return std::nullopt;
}

}  // namespace

std::optional<LetterOutlines> OutlinesOfLetters(std::u32string_view letters) {
  static std::mutex mutex;
  static std::map<std::u32string, std::optional<LetterOutlines>, std::less<>> kept;
  const std::lock_guard lock(mutex);
  if (const auto found = kept.find(letters); found != kept.end()) return found->second;
  if (kept.size() >= kMaxKept) kept.clear();
  return kept.emplace(letters, SetLetters(letters)).first->second;
}

}  // namespace intaglio::render
