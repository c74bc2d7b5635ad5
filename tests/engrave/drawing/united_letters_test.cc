// Letters of joined scripts: what their outlines enclose together, by counting how often
// each outline as the font has it runs around a point.

#include "engrave/drawing/united_letters.h"

#include <ft2build.h>
#include <gtest/gtest.h>
#include FT_FREETYPE_H

#include <cmath>
#include <random>

#include "engrave/drawing/flatten.h"
#include "engrave/drawing/font_list.h"
#include "engrave/drawing/font_outline.h"
#include "engrave/drawing/pieces.h"
#include "engrave/drawing/typesetter.h"
#include "engrave/drawing/utf8_characters.h"
#include "tests/engrave/drawing/outline_oracles.h"

namespace intaglio::drawing {
namespace {

class UnitedLetters : public ::testing::Test {
 protected:
  void SetUp() override {
    options_.font.name = "DejaVu Sans";
    options_.cap_height_mm = 10;
    if (!FindFontFile(options_.font.name))
      GTEST_SKIP() << "no DejaVu Sans: install the package fonts-dejavu-core";
  }
  /// The letters as the font has them, at their places.
  Drawing Separate(const std::string& text) const {
    const auto typesetter = Typesetter::Open(options_.font);
    Drawing drawing;
    drawing.curves = typesetter->SetLine(*CharactersOf(text), true)->curves;
    Transform(options_.cap_height_mm / typesetter->cap_height() * Mat3::Identity(),
              Vec3::Zero(), drawing);
    return drawing;
  }
  Drawing United(const std::string& text) const {
    const auto drawing = TextOutline(text, options_);
    EXPECT_TRUE(drawing) << (drawing ? "" : drawing.error().message);
    return drawing ? *drawing : Drawing{};
  }
  TextOptions options_;
};

TEST_F(UnitedLetters, EncloseWhatTheirOutlinesEnclosed) {
  for (const char* text : {"ممم", "سلام", "بيت ممم"}) {
    const auto parts = Flatten(Separate(text)), whole = Flatten(United(text));
    ASSERT_TRUE(parts && whole);
    Box3 box;
    for (const FlatCurve& curve : parts->curves)
      for (const Vec3& p : curve.points_mm) box.Extend(p);
    std::mt19937 random(1);
    std::uniform_real_distribution<> x(box.min_mm.x(), box.max_mm.x());
    std::uniform_real_distribution<> y(box.min_mm.y(), box.max_mm.y());
    int inside = 0;
    for (int i = 0; i < 2000; ++i) {
      const Vec2 at(x(random), y(random));
      if (DistanceToCurves(*parts, at) < 0.005) continue;
      const bool is_inside = WindingAt(*parts, at) != 0;
      inside += is_inside ? 1 : 0;
      ASSERT_EQ(WindingAt(*whole, at) != 0, is_inside)
          << text << " at " << at.transpose();
      ASSERT_LE(std::abs(WindingAt(*whole, at)), 1) << "no outline within another letter";
    }
    EXPECT_GT(inside, 200);
  }
}

TEST_F(UnitedLetters, HaveNoBordersBetweenThem) {
  // Three letters with a hole each: one outline and three holes.
  EXPECT_EQ(Separate("ممم").curves.size(), 6u);
  EXPECT_EQ(United("ممم").curves.size(), 4u);
  const auto parts = Flatten(Separate("ممم")), whole = Flatten(United("ممم"));
  ASSERT_TRUE(parts && whole);
  // Beside every edge of the result there is glass that no letter has.
  for (const FlatCurve& curve : whole->curves) {
    for (std::size_t i = 0; i < curve.points_mm.size(); ++i) {
      const Vec2 p = curve.points_mm[i].head<2>();
      const Vec2 q = curve.points_mm[(i + 1) % curve.points_mm.size()].head<2>();
      if ((q - p).norm() < 0.05) continue;
      const Vec2 aside = 0.01 * Vec2(p.y() - q.y(), q.x() - p.x()).normalized();
      const Vec2 middle = 0.5 * (p + q);
      EXPECT_TRUE(WindingAt(*parts, middle + aside) == 0 ||
                  WindingAt(*parts, middle - aside) == 0)
          << middle.transpose();
    }
  }
}

TEST_F(UnitedLetters, StayExactlyAsTheyAreWhereNoneIsJoined) {
  const Drawing parts = Separate("AVATAR Tofu 0815 %"),
                whole = United("AVATAR Tofu 0815 %");
  ASSERT_EQ(whole.curves.size(), parts.curves.size());
  for (std::size_t i = 0; i < parts.curves.size(); ++i) {
    ASSERT_EQ(whole.curves[i].pieces.size(), parts.curves[i].pieces.size());
    for (std::size_t k = 0; k < parts.curves[i].pieces.size(); ++k) {
      EXPECT_EQ(whole.curves[i].pieces[k].index(), parts.curves[i].pieces[k].index());
      EXPECT_EQ(BeginOf(whole.curves[i].pieces[k]), BeginOf(parts.curves[i].pieces[k]));
    }
  }
}

}  // namespace
}  // namespace intaglio::drawing
