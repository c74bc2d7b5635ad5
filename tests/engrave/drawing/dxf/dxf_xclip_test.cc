#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "engrave/drawing/dxf/dxf_read.h"
#include "engrave/drawing/flatten.h"
#include "tests/engrave/drawing/dxf_text.h"
#include "tests/engrave/drawing/lengths.h"

namespace intaglio::drawing {
namespace {

using std::numbers::pi;

struct Kept {
  std::size_t count = 0;
  double length_mm = 0;
  Box3 box;
};

Kept KeptOf(const Drawing& drawing, const std::string& layer) {
  Kept kept;
  const auto flat = Flatten(drawing);
  EXPECT_TRUE(flat);
  for (const FlatCurve& curve : flat->curves) {
    if (drawing.names[curve.layer] != layer) continue;
    ++kept.count;
    kept.length_mm += LengthOf(curve);
    for (const Vec3& p : curve.points_mm) kept.box.Extend(p);
  }
  return kept;
}

// A block of eleven lines, inserted and clipped in seven ways. The clips at their places
// are from ezdxf 1.4.4, the lengths and boxes of what is inside from lines cut at its
// polygons by a program of a few lines: tests/data/README.md.
TEST(DxfXclip, BlocksAreCutAsOtherProgramsShowThem) {
  struct Expected {
    const char* layer;
    std::size_t count;
    double length_mm, x0, y0, x1, y1;
  };
  const Expected all[] = {
      {"RECT", 6, 102.003113, 63.6649, 13.4871, 79.5709, 24.2672},
      {"L", 8, 108.023435, -59.5, 31.0625, -41.5, 38.25},
      {"MOVED", 8, 35.468769, 12.7686, -66.6358, 22.6332, -59.7972},
      {"OFF", 11, 176.085917, 99, 99, 115, 109.5},
      {"INVERTED", 16, 146.071272, -61.0000, -51.0000, -45.0000, -40.5000},
      {"NESTED", 17, 183.215693, 118.9135, -32.9436, 151.989, -18.47},
  };
  const auto drawing =
      ReadDxf(FileText(INTAGLIO_SOURCE_DIR "/tests/data/kinds/xclip.dxf"));
  ASSERT_TRUE(drawing) << drawing.error().message;
  EXPECT_TRUE(drawing->findings.empty());
  for (const Expected& expected : all) {
    const Kept kept = KeptOf(*drawing, expected.layer);
    EXPECT_EQ(kept.count, expected.count) << expected.layer;
    EXPECT_NEAR(kept.length_mm, expected.length_mm, 1e-5) << expected.layer;
    EXPECT_NEAR(kept.box.min_mm.x(), expected.x0, 1e-4) << expected.layer;
    EXPECT_NEAR(kept.box.min_mm.y(), expected.y0, 1e-4) << expected.layer;
    EXPECT_NEAR(kept.box.max_mm.x(), expected.x1, 1e-4) << expected.layer;
    EXPECT_NEAR(kept.box.max_mm.y(), expected.y1, 1e-4) << expected.layer;
  }
}

const char kXclipIdentity[] =
    "|40 1|40 0|40 0|40 0|40 0|40 1|40 0|40 0|40 0|40 0|40 1|40 0";

/// A block with `content`, inserted at 10, 20 and clipped by a filter of these groups.
Result<Drawing> XclipOf(const std::string& content, const std::string& filter,
                        const std::string& insert = "", const std::string& more = "") {
  return ReadDxf(
      Groups("0 SECTION|2 BLOCKS|0 BLOCK|2 B|10 0|20 0|30 0|" + content +
             "|0 ENDBLK|0 ENDSEC|0 SECTION|2 ENTITIES|0 INSERT|5 a0|102 {ACAD_XDICTIONARY"
             "|360 A1|102 }|2 B|10 10|20 20" +
             insert +
             "|0 ENDSEC|0 SECTION|2 OBJECTS|0 DICTIONARY|5 A1|3 ACAD_FILTER|360 A2"
             "|0 DICTIONARY|5 A2|3 SPATIAL|360 A3|0 SPATIAL_FILTER|5 A3"
             "|102 {ACAD_XDICTIONARY|360 A4|102 }|330 A2" +
             filter + more + "|0 ENDSEC|0 EOF"));
}

const char kXclipLine[] = "0 LINE|8 0|10 0|20 1|11 20|21 1";
const char kXclipBox[] = "|70 2|10 2|20 0|10 12|20 5|210 0|220 0|230 1";

double LengthIn(const Result<Drawing>& drawing) {
  EXPECT_TRUE(drawing) << drawing.error().message;
  return drawing ? KeptOf(*drawing, "0").length_mm : -1;
}

// The second matrix leads from the world into the plane of the clip, whose origin is at
// 12, 21 here and whose x axis is the world's y axis: the box of 10 x 30 along these axes
// is 30 x 10 in the world, from (-18, 21) to (12, 31).
TEST(DxfXclip, TheSecondMatrixPlacesTheClip) {
  const std::string first =
      "|40 1|40 0|40 0|40 -10|40 0|40 1|40 0|40 -20|40 0|40 0|40 1|40 0";
  const std::string second =
      "|40 0|40 1|40 0|40 -21|40 -1|40 0|40 0|40 12|40 0|40 0|40 1|40 0";
  const std::string filter =
      "|70 2|10 0|20 0|10 10|20 30|210 0|220 0|230 1|11 12|21 21|31 0|71 1|72 0|73 0" +
      first + second;
  const auto drawing = XclipOf(
      "0 LINE|8 0|10 -50|20 5|11 50|21 5|0 LINE|8 0|10 0|20 -50"
      "|11 0|21 50",
      filter);
  ASSERT_TRUE(drawing) << drawing.error().message;
  EXPECT_TRUE(drawing->findings.empty());
  const Kept kept = KeptOf(*drawing, "0");
  EXPECT_EQ(kept.count, 2U);
  EXPECT_NEAR(kept.box.min_mm.x(), -18, 1e-9);
  EXPECT_NEAR(kept.box.max_mm.x(), 12, 1e-9);
  EXPECT_NEAR(kept.box.min_mm.y(), 21, 1e-9);
  EXPECT_NEAR(kept.box.max_mm.y(), 31, 1e-9);
}

// Outlines are lines and are opened; hatches are areas and stay closed.
TEST(DxfXclip, LinesAreCutOpenAndAreasAsAreas) {
  const std::string filter = kXclipBox + std::string(kXclipIdentity) + kXclipIdentity;
  const auto circle = XclipOf("0 CIRCLE|8 0|10 2|20 2|40 1.5", filter);
  EXPECT_NEAR(LengthIn(circle), 1.5 * pi, 1e-3);
  const auto hatch = XclipOf(
      "0 HATCH|8 0|10 0|20 0|30 0|2 SOLID|70 1|71 0|91 1|92 2|72 0|73 1|93 4|10 0|20 1"
      "|10 6|20 1|10 6|20 4|10 0|20 4|97 0|75 0|76 1|98 0",
      filter);
  ASSERT_TRUE(hatch) << hatch.error().message;
  const auto flat = Flatten(*hatch);
  ASSERT_EQ(flat->curves.size(), 1U);
  EXPECT_TRUE(flat->curves[0].closed);
  EXPECT_NEAR(std::abs(AreaOf(flat->curves[0])), 12, 1e-6);
}

// Front and back planes cut along z, which a flat drawing does not have.
TEST(DxfXclip, PlanesAreWarnedOfAndTheBoundaryCuts) {
  const auto drawing =
      XclipOf(kXclipLine, kXclipBox + std::string("|71 1|72 1|40 7|73 1|41 -7") +
                              kXclipIdentity + std::string(kXclipIdentity));
  EXPECT_NEAR(LengthIn(drawing), 10, 1e-9);
  EXPECT_EQ(drawing->findings.CountOf("plane of an XCLIP in front or behind"), 1U);
}

TEST(DxfXclip, WhatIsNotReadIsWarnedOfByNameAndNotCut) {
  const std::string matrices = std::string(kXclipIdentity) + kXclipIdentity;
  const std::string flat = "|40 1|40 0|40 0|40 0|40 1|40 0|40 0|40 0|40 0|40 0|40 1|40 0";
  const std::string tilted =
      "|40 1|40 0|40 0|40 0|40 0|40 0.8|40 0.6|40 0|40 0|40 -0.6|40 0.8|40 0";
  const std::string inverted =
      "|0 DICTIONARY|5 A4|3 ACAD_XREC_ROUNDTRIP|360 A5|0 XRECORD|5 A5"
      "|102 ACAD_INVERTEDCLIP_ROUNDTRIP|10 2|20 0|10 12|20 5"
      "|102 ACAD_INVERTEDCLIP_ROUNDTRIP_COMPARE|10 2|20 0|10 12|20 5";
  struct Case {
    std::string what, filter, insert, more;
  };
  const Case cases[] = {
      {"without a boundary or its matrices", kXclipBox + std::string(kXclipIdentity), "",
       ""},
      {"without a boundary or its matrices", "|70 1|10 2|20 0" + matrices, "", ""},
      {"without a boundary or its matrices", "|10 2|20 x|10 12|20 5" + matrices, "", ""},
      {"with a matrix that flattens it", kXclipBox + flat + kXclipIdentity, "", ""},
      {"in a plane of its own", "|10 2|20 0|10 12|20 5|210 0|220 1|230 0" + matrices, "",
       ""},
      {"in a plane of its own", kXclipBox + ("|11 3|21 0|31 0" + matrices), "", ""},
      {"not along z, or of too many edges", kXclipBox + (tilted + kXclipIdentity), "",
       ""},
      {"of an array", kXclipBox + matrices, "|70 2|44 30", ""},
      {"inverted, with a boundary of another form", kXclipBox + matrices, "", inverted}};
  for (const Case& one : cases) {
    const auto drawing = XclipOf(kXclipLine, one.filter, one.insert, one.more);
    const double lines = one.insert.empty() ? 1 : 2;
    EXPECT_NEAR(LengthIn(drawing), 20 * lines, 1e-9) << one.what;
    ASSERT_GE(drawing->findings.size(), 1U) << one.what;
    EXPECT_EQ(drawing->findings.begin()->what, "XCLIP of a block, " + one.what);
    EXPECT_EQ(drawing->findings.begin()->effect, Effect::kChanged);
    EXPECT_NE(drawing->findings.begin()->where.find("SPATIAL_FILTER"), std::string::npos);
  }
  const auto unnamed =
      ReadDxf(Groups("0 SECTION|2 OBJECTS|0 SPATIAL_FILTER|5 A3|70 2|0 ENDSEC|0 EOF"));
  ASSERT_TRUE(unnamed);
  EXPECT_EQ(unnamed->findings.CountOf("XCLIP of a block, which is not named"), 1U);
}

}  // namespace
}  // namespace intaglio::drawing
