#include "engrave/drawing/font_outline.h"

#include <fmt/format.h>

#include <memory>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/drawing/pieces.h"
#include "engrave/drawing/typesetter.h"
#include "engrave/drawing/united_letters.h"
#include "engrave/drawing/utf8_characters.h"

namespace intaglio::drawing {
namespace {

double ShareLeftOf(TextAlignment alignment) {
  if (alignment == TextAlignment::kLeft) return 0;
  return alignment == TextAlignment::kCentre ? 0.5 : 1;
}

Result<Drawing> SetLines(std::u32string_view text, const Typesetter& typesetter,
                         const TextOptions& options) {
  if (text.size() > options.max_characters) {
    return Fail(ErrorCode::kTooLarge,
                fmt::format("the text has more than {} characters; divide it",
                            options.max_characters));
  }
  Drawing drawing;
  std::vector<std::uint32_t> letters;
  std::uint32_t letter_count = 0;
  const double step = options.line_spacing_ratio * typesetter.line_height();
  double baseline = 0;
  for (std::u32string_view rest = text;; baseline -= step) {
    const auto end = rest.find(U'\n');
    auto line = INTAGLIO_TRY(typesetter.SetLine(rest.substr(0, end), options.kerning));
    const Vec3 shift(-ShareLeftOf(options.alignment) * line.width, baseline, 0);
    for (Curve& curve : line.curves) {
      for (Piece& piece : curve.pieces) Transform(Mat3::Identity(), shift, piece);
      drawing.curves.push_back(std::move(curve));
    }
    for (const std::uint32_t letter : line.letters)
      letters.push_back(letter_count + letter);
    letter_count += line.letter_count;
    if (end == rest.npos) break;
    rest.remove_prefix(end + 1);
  }
  if (drawing.curves.empty()) {
    return Fail(ErrorCode::kMissing, "the text has no visible character");
  }
  Transform(options.cap_height_mm / typesetter.cap_height() * Mat3::Identity(),
            Vec3::Zero(), drawing);
  UniteLetters(letters, drawing.curves);
  return drawing;
}

}  // namespace

TextOutliner::TextOutliner(TextOptions options, std::unique_ptr<Typesetter> typesetter)
    : options_(std::move(options)), typesetter_(std::move(typesetter)) {}
TextOutliner::~TextOutliner() = default;
TextOutliner::TextOutliner(TextOutliner&&) noexcept = default;
TextOutliner& TextOutliner::operator=(TextOutliner&&) noexcept = default;

Result<TextOutliner> TextOutliner::Open(TextOptions options) {
  Require(options.cap_height_mm >= 0.1 && options.cap_height_mm <= 1000,
          "cap_height_mm must be 0.1 .. 1000, is {}", options.cap_height_mm);
  Require(options.line_spacing_ratio >= 0.5 && options.line_spacing_ratio <= 5,
          "line_spacing_ratio must be 0.5 .. 5, is {}", options.line_spacing_ratio);
  auto typesetter = INTAGLIO_TRY(Typesetter::Open(options.font, options.fallbacks));
  return TextOutliner(std::move(options),
                      std::make_unique<Typesetter>(std::move(typesetter)));
}

Result<Drawing> TextOutliner::Outline(std::string_view utf8) const {
  const auto text = INTAGLIO_TRY(CharactersOf(utf8));
  return SetLines(text, *typesetter_, options_);
}

Result<Drawing> TextOutline(std::string_view utf8, const TextOptions& options) {
  const auto outliner = INTAGLIO_TRY(TextOutliner::Open(options));
  return outliner.Outline(utf8);
}

}  // namespace intaglio::drawing
