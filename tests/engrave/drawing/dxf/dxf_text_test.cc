#include "engrave/drawing/dxf/dxf_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "engrave/drawing/dxf/dxf_read.h"
#include "engrave/drawing/font_list.h"
#include "engrave/drawing/font_outline.h"
#include "tests/engrave/drawing/dxf_text.h"
#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

using ::testing::HasSubstr;

/// With the blanks beside the first and the last letter.
double TextOutlineWidth(const std::string& text, double height) {
  const auto typesetter = Typesetter::Open({"DejaVu Sans"});
  const auto line = typesetter->SetLine(std::u32string(text.begin(), text.end()), true);
  return line->width * height / typesetter->cap_height();
}

class DxfText : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!FindFontFile("DejaVu Sans"))
      GTEST_SKIP() << "no DejaVu Sans: install the package fonts-dejavu-core";
    options_.text_font = FontSource{"DejaVu Sans"};
  }
  Drawing Read(const std::string& pairs) const {
    const auto drawing = ReadDxf(Entities(pairs), options_);
    EXPECT_TRUE(drawing.has_value()) << (drawing ? "" : drawing.error().message);
    return drawing ? *drawing : Drawing();
  }
  Box3 Extent(const std::string& pairs) const { return ExtentOf(*Flatten(Read(pairs))); }
  /// The oracle: a text whose capitals are `height` tall, at the origin, to the right.
  static Box3 Text(const std::string& text, double height,
                   TextAlignment alignment = TextAlignment::kLeft) {
    TextOptions options;
    options.font.name = "DejaVu Sans";
    options.cap_height_mm = height;
    options.alignment = alignment;
    return ExtentOf(*Flatten(*TextOutline(text, options)));
  }
  static void ExpectSame(const Box3& a, const Box3& b) {
    EXPECT_LT((a.min_mm - b.min_mm).norm(), 1e-9) << a.min_mm << "; " << b.min_mm;
    EXPECT_LT((a.max_mm - b.max_mm).norm(), 1e-9) << a.max_mm << "; " << b.max_mm;
  }
  static Box3 Moved(Box3 box, const Vec3& by) {
    return {box.min_mm + by, box.max_mm + by};
  }

  ReadOptions options_;
};

TEST_F(DxfText, BeginsAtItsPointAndIsAsHighAsItsCapitals) {
  const Drawing drawing = Read("0 TEXT|8 names|62 3|10 7|20 -2|40 4|1 HIT");
  EXPECT_TRUE(drawing.findings.empty());
  ASSERT_EQ(drawing.curves.size(), 3u);
  EXPECT_EQ(drawing.names[drawing.curves[0].layer], "names");
  EXPECT_TRUE(drawing.curves[0].closed);
  ExpectSame(ExtentOf(*Flatten(drawing)), Moved(Text("HIT", 4), {7, -2, 0}));
}

TEST_F(DxfText, WithoutAFontItIsLeftOutByName) {
  options_.text_font.reset();
  const Drawing drawing = Read("0 TEXT|40 4|1 HIT|0 MTEXT|40 4|1 HIT|0 POINT|10 1");
  EXPECT_EQ(drawing.findings.CountOf("TEXT"), 1u);
  EXPECT_EQ(drawing.findings.CountOf("MTEXT"), 1u);
  EXPECT_EQ(drawing.curves.size(), 1u);
}

// Code 72: 1 centre, 2 right, 4 middle; 73: 2 middle, 3 top. Their point is the second.
TEST_F(DxfText, IsAlignedByItsCodes) {
  const std::string text = "0 TEXT|10 99|20 99|11 5|21 6|40 4|1 HIT|";
  ExpectSame(Extent(text + "72 1"),
             Moved(Text("HIT", 4, TextAlignment::kCentre), {5, 6, 0}));
  ExpectSame(Extent(text + "72 2"),
             Moved(Text("HIT", 4, TextAlignment::kRight), {5, 6, 0}));
  ExpectSame(Extent(text + "72 2|73 3"),
             Moved(Text("HIT", 4, TextAlignment::kRight), {5, 2, 0}));
  ExpectSame(Extent(text + "72 1|73 2"),
             Moved(Text("HIT", 4, TextAlignment::kCentre), {5, 4, 0}));
  ExpectSame(Extent(text + "72 4"),
             Moved(Text("HIT", 4, TextAlignment::kCentre), {5, 4, 0}));
}

TEST_F(DxfText, FillsTheWayBetweenTwoPoints) {
  const std::string text = "0 TEXT|10 1|20 2|11 1|21 42|40 4|1 HIT|";
  const Vec3 own = Text("HIT", 4).size_mm();
  const double width = TextOutlineWidth("HIT", 4);
  // Upwards, so that the width is along y; 3: the height grows with it.
  const Vec3 aligned = Extent(text + "72 3").size_mm();
  EXPECT_NEAR(aligned.y(), own.x() * 40 / width, 1e-9);
  EXPECT_NEAR(aligned.x(), own.y() * 40 / width, 1e-9);
  const Vec3 fit = Extent(text + "72 5").size_mm();
  EXPECT_NEAR(fit.y(), own.x() * 40 / width, 1e-9);
  EXPECT_NEAR(fit.x(), own.y(), 1e-9);
}

TEST_F(DxfText, IsTurnedStretchedSlantedAndMirrored) {
  const Box3 own = Text("HIT", 4);
  Box3 box = Extent("0 TEXT|40 4|41 2|1 HIT");
  EXPECT_NEAR(box.size_mm().x(), 2 * own.size_mm().x(), 1e-9);
  EXPECT_NEAR(box.size_mm().y(), 4, 1e-9);
  box = Extent("0 TEXT|40 4|50 90|1 HIT");
  EXPECT_NEAR(box.min_mm.x(), -4, 1e-9);
  EXPECT_NEAR(box.max_mm.y(), own.max_mm.x(), 1e-9);
  box = Extent("0 TEXT|40 4|51 45|1 I");
  EXPECT_NEAR(box.size_mm().x(), Text("I", 4).size_mm().x() + 4, 1e-9);
  box = Extent("0 TEXT|40 4|71 2|1 HIT");
  EXPECT_NEAR(box.min_mm.x(), -own.max_mm.x(), 1e-9);
  EXPECT_NEAR(Extent("0 TEXT|40 4|71 4|1 HIT").min_mm.y(), -4, 1e-9);
  // Extrusion -z: x is mirrored (arbitrary axis algorithm).
  box = Extent("0 TEXT|10 3|40 4|1 HIT|210 0|220 0|230 -1");
  EXPECT_NEAR(box.max_mm.x(), -3 - own.min_mm.x(), 1e-9);
}

TEST_F(DxfText, MtextHasLinesAndAPlaceByItsAttachment) {
  const std::string text = "0 MTEXT|10 5|20 6|40 3|1 HH\\PI|71 ";
  const double lines = 3 + 5;  // the second baseline is 5/3 of the height below the first
  const std::array left = {0.0, 0.5, 1.0};
  for (int attachment = 1; attachment <= 9; ++attachment) {
    const Box3 box = Extent(text + std::to_string(attachment));
    const double lift = 0.5 * lines * ((attachment - 1) / 3);
    EXPECT_NEAR(box.max_mm.y(), 6 + lift, 1e-9) << attachment;
    EXPECT_NEAR(box.min_mm.y(), 6 + lift - lines, 1e-9) << attachment;
    const double share = left[static_cast<std::size_t>((attachment - 1) % 3)];
    EXPECT_NEAR(box.min_mm.x(),
                5 + Text("HH", 3).min_mm.x() - share * TextOutlineWidth("HH", 3), 1e-9);
  }
  EXPECT_NEAR(Extent(text + "1|44 2").size_mm().y(), 3 + 10, 1e-9);
  EXPECT_NEAR(Extent(text + "1|11 0|21 1|31 0").size_mm().x(), lines, 1e-9);
}

TEST_F(DxfText, MtextIsBrokenAtItsWidthAndOfSeveralGroups) {
  // 250 characters a group 3, the rest in 1; blanks at the border are kept.
  const std::string text = "0 MTEXT|40 2|3 HH HH |1 HH|41 ";
  const double word = TextOutlineWidth("HH", 2);
  const double step = 2 * 5.0 / 3;
  EXPECT_NEAR(Extent(text + "0").size_mm().y(), 2, 1e-9);
  EXPECT_NEAR(Extent(text + std::to_string(1.5 * word)).size_mm().y(), 2 + 2 * step,
              1e-9);
  EXPECT_NEAR(Extent(text + std::to_string(2.7 * word)).size_mm().y(), 2 + step, 1e-9);
  EXPECT_NEAR(Extent(text + "0.01").size_mm().y(), 2 + 2 * step, 1e-9);
}

TEST_F(DxfText, HeightsOfMtextAreAbsoluteOrTimesTheLastOne) {
  EXPECT_NEAR(Extent("0 MTEXT|40 2|1 I{\\H7;I}I").size_mm().y(), 7, 1e-9);
  EXPECT_NEAR(Extent("0 MTEXT|40 2|1 I{\\H1.5x;I}I").size_mm().y(), 3, 1e-9);
  EXPECT_NEAR(Extent("0 MTEXT|40 2|1 \\H3;\\H2x;I").size_mm().y(), 6, 1e-9);
  EXPECT_NEAR(Extent("0 MTEXT|40 2|1 {\\fArial;\\W2;I}").size_mm().x(),
              2 * Text("I", 2).size_mm().x(), 1e-9);
}

TEST(DxfTextCodes, OfText) {
  EXPECT_EQ(PlainDxfText(U"%%c12 %%p0.1 90%%d %%uA%%u 5%%%"),
            U"\u230012 \u00B10.1 90\u00B0 A 5%");
  EXPECT_EQ(PlainDxfText(U"\\U+0141%%065 %% \\U+00"), U"\u0141A %% \\U+00");
}

TEST(DxfTextCodes, OfMtext) {
  const auto lines = DxfMtextLines(
      U"{\\fArial|b1;A\\{b\\}}\\~\\LC\\l\\P\\pi0,l2;\\S1^2;\\C1;^I\\U+00D8\\\\\\H2x;D");
  ASSERT_EQ(lines.size(), 2u);
  ASSERT_EQ(lines[0].size(), 1u);
  EXPECT_EQ(lines[0][0].text, U"A{b}\u00A0C");
  ASSERT_EQ(lines[1].size(), 2u);
  EXPECT_EQ(lines[1][0].text, U"1/2 \u00D8\\");
  EXPECT_EQ(lines[1][1].text, U"D");
  EXPECT_EQ(lines[1][1].height_ratio, 2);
  // Broken codes end, and lose no more than themselves.
  EXPECT_EQ(DxfMtextLines(U"A\\").front().front().text, U"A\\");
  EXPECT_EQ(DxfMtextLines(U"}}A\\Hx;").front().front().text, U"A");
}

TEST_F(DxfText, WhatCannotBeWrittenIsLeftOutAndDamageIsAnError) {
  const Drawing drawing = Read(
      "0 TEXT|40 2|1 \xF0\x9F\xA6\x84|0 TEXT|40 2|1 \xB3\xF3\x64|0 ATTRIB|40 2|70 1|1 "
      "A|0 TEXT|40 2|1 A");
  EXPECT_EQ(drawing.findings.CountOf("text with letters not in the font"), 1u);
  EXPECT_EQ(drawing.findings.CountOf("text not in UTF-8"), 1u);
  EXPECT_EQ(drawing.findings.CountOf("invisible"), 1u);
  EXPECT_EQ(drawing.curves.size(), 2u);
  const auto flat = ReadDxf(Entities("0 TEXT|40 0|1 A"), options_, "a.dxf");
  ASSERT_FALSE(flat);
  EXPECT_THAT(flat.error().message, HasSubstr("height of a text must be positive"));
  options_.text_font = FontSource{"/no/such/font.ttf"};
  const auto no_font = ReadDxf(Entities("0 TEXT|40 1|1 A"), options_, "a.dxf");
  ASSERT_FALSE(no_font);
  EXPECT_THAT(no_font.error().message, HasSubstr("/no/such/font.ttf"));
}

}  // namespace
}  // namespace intaglio::drawing
