#include "engrave/drawing/font_outline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/check.h"
#include "engrave/drawing/font_list.h"
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
