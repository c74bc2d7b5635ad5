#include "engrave/drawing/font_outline.h"

#include <ft2build.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include FT_FREETYPE_H

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/drawing/font_list.h"
#include "engrave/io/whole_file.h"
#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

using ::testing::HasSubstr;

class FontOutline : public ::testing::Test {
 protected:
  void SetUp() override {
    options_.font.name = "DejaVu Sans";
    if (!FindFontFile(options_.font.name))
      GTEST_SKIP() << "no DejaVu Sans: install the package fonts-dejavu-core";
  }
  FlatDrawing Flat(const std::string& text) const {
    const auto drawing = TextOutline(text, options_);
    EXPECT_TRUE(drawing.has_value()) << (drawing ? "" : drawing.error().message);
    if (!drawing) return {};
    const auto flat = Flatten(*drawing);
    return flat ? *flat : FlatDrawing{};
  }
  Error ErrorOf(const std::string& text) const {
    const auto drawing = TextOutline(text, options_);
    EXPECT_FALSE(drawing.has_value());
    return drawing ? Error{} : drawing.error();
  }
  TextOptions options_;
};

TEST_F(FontOutline, CapitalsAreAsHighAsAsked) {
  options_.cap_height_mm = 12;
  const Box3 box = ExtentOf(Flat("HIT"));
  EXPECT_NEAR(box.min_mm.y(), 0, 1e-9);
  EXPECT_NEAR(box.max_mm.y(), 12, 1e-9);
}

TEST_F(FontOutline, OfFontsThatAreOpenIsThatOfFontsOpenedForIt) {
  const auto outliner = TextOutliner::Open(options_);
  ASSERT_TRUE(outliner) << outliner.error().message;
  for (const std::string text : {"HIT", "AV\nof 17", "HIT"}) {
    const FlatDrawing expected = Flat(text);
    const FlatDrawing flat = Flatten(outliner->Outline(text).value()).value();
    ASSERT_EQ(flat.curves.size(), expected.curves.size());
    for (std::size_t i = 0; i < flat.curves.size(); ++i)
      EXPECT_EQ(flat.curves[i].points_mm, expected.curves[i].points_mm);
  }
  EXPECT_FALSE(outliner->Outline(" "));
  EXPECT_TRUE(outliner->Outline("A"));
}

TEST_F(FontOutline, LettersHaveTheirContours) {
  // B has two holes, i two parts; all are closed.
  const FlatDrawing flat = Flat("Bi");
  EXPECT_EQ(flat.curves.size(), 3U + 2U);
  for (const FlatCurve& curve : flat.curves) EXPECT_TRUE(curve.closed);
  // Holes turn the other way, so the sum of areas, the ink, is less than the largest.
  double ink = 0, largest = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    ink += AreaOf(flat.curves[i]);
    largest = std::max(largest, std::abs(AreaOf(flat.curves[i])));
  }
  EXPECT_LT(std::abs(ink), largest);
}

TEST_F(FontOutline, LinesAndAlignment) {
  options_.alignment = TextAlignment::kCentre;
  const Box3 centred = ExtentOf(Flat("H\nHHHH"));
  EXPECT_NEAR(centred.center_mm().x(), 0, 1e-9);
  options_.alignment = TextAlignment::kRight;
  EXPECT_LT(ExtentOf(Flat("H\nHHHH")).max_mm.x(), 1e-9);
  options_.alignment = TextAlignment::kLeft;
  const Box3 left = ExtentOf(Flat("H\nHHHH"));
  EXPECT_GT(left.min_mm.x(), 0);
  const double step = -left.min_mm.y();
  options_.line_spacing_ratio = 2;
  EXPECT_NEAR(-ExtentOf(Flat("H\nHHHH")).min_mm.y(), 2 * step, 1e-9);
}

TEST_F(FontOutline, KerningDrawsPairsTogether) {
  const double kerned = ExtentOf(Flat("AVAVAV")).size_mm().x();
  options_.kerning = false;
  EXPECT_LT(kerned, ExtentOf(Flat("AVAVAV")).size_mm().x() - 0.1);
}

/// The font with its table renamed, so that no reader finds it.
std::string WithoutTable(std::string font, std::string_view tag) {
  const auto tables = static_cast<std::size_t>(static_cast<unsigned char>(font[5]));
  for (std::size_t i = 0; i < tables; ++i) {
    const std::size_t at = 12 + 16 * i;
    if (font.compare(at, 4, tag) == 0) font[at] = 'x';
  }
  return font;
}

// DejaVu Sans has its pairs twice, as kern and as GPOS; the oracle is FreeType, which
// reads kern alone.
TEST_F(FontOutline, KerningIsThatOfGposAndOfKern) {
  const std::string file = FindFontFile(options_.font.name).value();
  const std::string font = io::ReadWholeFile(file, 1 << 24).value();
  FT_Library library = nullptr;
  FT_Face face = nullptr;
  ASSERT_EQ(FT_Init_FreeType(&library), 0);
  ASSERT_EQ(FT_New_Face(library, file.c_str(), 0, &face), 0);
  const auto glyph = [&](char letter) {
    return FT_Get_Char_Index(face, static_cast<FT_ULong>(letter));
  };
  FT_Vector pair{};
  ASSERT_EQ(FT_Load_Glyph(face, glyph('H'), FT_LOAD_NO_SCALE), 0);
  const double cap_height = static_cast<double>(face->glyph->metrics.horiBearingY);
  for (const std::string_view letters : {"AV", "To", "Ta", "LT", "HH"}) {
    FT_Get_Kerning(face, glyph(letters[0]), glyph(letters[1]), FT_KERNING_UNSCALED,
                   &pair);
    const auto width = [&](const std::string& bytes, bool kerning) {
      options_.font = {"test.ttf", bytes};
      options_.kerning = kerning;
      return ExtentOf(Flat(std::string(letters))).size_mm().x();
    };
    const double mm = options_.cap_height_mm / cap_height * static_cast<double>(pair.x);
    const std::string gpos = WithoutTable(font, "kern"),
                      kern = WithoutTable(font, "GPOS");
    EXPECT_NEAR(width(gpos, true) - width(gpos, false), mm, 1e-9) << letters;
    EXPECT_NEAR(width(kern, true) - width(kern, false), mm, 1e-9) << letters;
    const std::string neither = WithoutTable(gpos, "GPOS");
    EXPECT_NEAR(width(neither, true), width(neither, false), 1e-9) << letters;
  }
  EXPECT_EQ(pair.x, 0) << "HH";
  FT_Done_FreeType(library);
}

TEST_F(FontOutline, Utf8AndMissingCharacters) {
  EXPECT_FALSE(Flat("Żółć Ω я").curves.empty());
  const Error missing = ErrorOf("A\xF0\x9F\xA6\x84");  // a unicorn
  EXPECT_EQ(missing.code, ErrorCode::kMissing);
  EXPECT_THAT(missing.message, HasSubstr("U+1F984"));
  EXPECT_EQ(ErrorOf("\xC0\x80").code, ErrorCode::kUnreadable);
  EXPECT_EQ(ErrorOf("\xE2\x82").code, ErrorCode::kUnreadable);
  EXPECT_EQ(ErrorOf("\xED\xA0\x80").code, ErrorCode::kUnreadable);
  EXPECT_EQ(ErrorOf("  \n ").code, ErrorCode::kMissing);
  options_.max_characters = 3;
  EXPECT_EQ(ErrorOf("ABCD").code, ErrorCode::kTooLarge);
}

TEST_F(FontOutline, LettersOfAnotherFontAreAsHigh) {
  // Hebrew letters are in DejaVu Sans alone; the capitals of Serif decide the height.
  options_.cap_height_mm = 7;
  const Box3 own = ExtentOf(Flat("\u05D0"));
  options_.font.name = "DejaVu Serif";
  EXPECT_THAT(ErrorOf("\u05D0").message, HasSubstr("U+05D0"));
  options_.fallbacks = {{"DejaVu Sans"}};
  EXPECT_NEAR(ExtentOf(Flat("\u05D0")).size_mm().y(), own.size_mm().y(), 1e-9);
  EXPECT_NEAR(ExtentOf(Flat("\u05D0")).size_mm().x(), own.size_mm().x(), 1e-9);
  // What the font has stays in its own letters.
  const double serif_mm = ExtentOf(Flat("mm")).size_mm().x();
  options_.fallbacks.clear();
  EXPECT_EQ(ExtentOf(Flat("mm")).size_mm().x(), serif_mm);
}

TEST_F(FontOutline, FontsByFileStyleAndName) {
  const auto bold = FindFontFile("DejaVu Sans:Bold");
  ASSERT_TRUE(bold);
  options_.font.name = *bold;
  EXPECT_GT(ExtentOf(Flat("mm")).size_mm().x(), 0);
  options_.font.name = "No Such Family";
  EXPECT_EQ(ErrorOf("A").code, ErrorCode::kNotFound);
  options_.font.name = "/no/such/font.ttf";
  EXPECT_EQ(ErrorOf("A").code, ErrorCode::kNotFound);
  options_.font.name = std::string(INTAGLIO_SOURCE_DIR) + "/CMakeLists.txt";
  EXPECT_EQ(ErrorOf("A").code, ErrorCode::kUnreadable);
  options_.cap_height_mm = 0;
  EXPECT_THROW((void)TextOutline("A", options_), PreconditionError);
}

}  // namespace
}  // namespace intaglio::drawing
