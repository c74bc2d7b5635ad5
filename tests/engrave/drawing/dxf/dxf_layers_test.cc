#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engrave/drawing/dxf/dxf_read.h"
#include "tests/engrave/drawing/dxf_text.h"

namespace intaglio::drawing {
namespace {

/// One layer each that is on, off, frozen, both; the table's own head names LAYER too,
/// and other tables have flags and colours of their own.
std::string Tables() {
  return Groups(
      "0 SECTION|2 TABLES|0 TABLE|2 LTYPE|70 1|0 LTYPE|2 on|70 1|0 ENDTAB|"
      "0 TABLE|2 LAYER|70 4|0 LAYER|5 2A|2 on|70 4|62 1|0 LAYER|2 Off|70 0|62 -1|"
      "0 LAYER|2 frozen|70 65|62 7|0 LAYER|2 both|62 -7|70 1|0 ENDTAB|0 ENDSEC");
}
Drawing DrawingOf(const std::string& text) {
  auto drawing = ReadDxf(text);
  EXPECT_TRUE(drawing.has_value()) << (drawing ? "" : drawing.error().message);
  return drawing ? std::move(*drawing) : Drawing{};
}
/// The x of the points that are drawn, in order.
std::string Drawn(const Drawing& drawing) {
  std::string drawn;
  for (const Curve& curve : drawing.curves) {
    drawn += fmt::format("{} ", std::get<Polyline>(curve.pieces[0]).points_mm[0].x());
  }
  return drawn;
}

// Two drawings that were joined into one file are not the first of them.
TEST(DxfLayers, WhatLiesBehindTheEndOfTheFileIsFound) {
  const std::string one = Entities("0 POINT|10 1");
  const Drawing joined = DrawingOf(one + one);
  EXPECT_EQ(Drawn(joined), "1 ");
  EXPECT_EQ(joined.findings.CountOf("text behind EOF"), 1U);
  EXPECT_TRUE(DrawingOf(one + "\r\n\x1a").findings.empty());
}

TEST(DxfLayers, OffAndFrozenLayersAreNotDrawnButCounted) {
  const Drawing drawing =
      DrawingOf(Tables() + Entities("0 POINT|8 on|10 1|0 POINT|8 off|10 2|"
                                    "0 POINT|8 FROZEN|10 3|0 POINT|8 both|10 4|"
                                    "0 POINT|8 unknown|10 5|0 POINT|10 6|"
                                    "0 POINT|8 frozen|60 1|10 7|0 POINT|8 off|67 1|"
                                    "0 POINT|8 Off|62 3|10 8"));
  EXPECT_EQ(Drawn(drawing), "1 5 6 ");
  EXPECT_EQ(drawing.findings.CountOf("on a layer that is off"), 2U);
  EXPECT_EQ(drawing.findings.CountOf("on a frozen layer"), 2U);
  EXPECT_EQ(drawing.findings.CountOf("invisible"), 1U);
  EXPECT_EQ(drawing.findings.CountOf("on a sheet"), 1U);
  // A colour of the entity's own is none of the layer: it may be negative by a mistake.
  EXPECT_EQ(Drawn(DrawingOf(Entities("0 POINT|8 off|62 -3|10 1"))), "1 ");
}

// What is on layer 0 of a block lies on the layer of its insertion. A frozen layer hides
// the whole block inserted on it, one that is off only what lies on it itself.
TEST(DxfLayers, BlocksOnOffAndFrozenLayers) {
  const std::string blocks =
      "0 BLOCK|2 B|0 POINT|8 0|10 1|0 POINT|10 2|0 POINT|8 on|10 3|0 POINT|8 frozen|10 "
      "4|0 ENDBLK|0 BLOCK|2 C|0 INSERT|8 0|2 B|0 ENDBLK";
  const auto drawn = [&](const std::string& entities) {
    return Drawn(DrawingOf(Tables() + WithBlocks(blocks, entities)));
  };
  EXPECT_EQ(drawn("0 INSERT|8 on|2 B"), "1 2 3 ");
  EXPECT_EQ(drawn("0 INSERT|8 off|2 B"), "3 ");
  EXPECT_EQ(drawn("0 INSERT|8 frozen|2 B"), "");
  EXPECT_EQ(drawn("0 INSERT|8 on|60 1|2 B"), "");
  EXPECT_EQ(drawn("0 INSERT|8 off|2 C"), "3 ");
  EXPECT_EQ(drawn("0 INSERT|8 both|2 C"), "");
  EXPECT_EQ(drawn("0 INSERT|2 C"), "1 2 3 ");
}

TEST(DxfLayers, BrokenRecordsAndTooManyEndInErrors) {
  const auto error_of = [](const std::string& records, std::uint64_t largest) {
    ReadOptions options;
    options.limits.max_entities = largest;
    const auto drawing =
        ReadDxf(Groups("0 SECTION|2 TABLES|" + records + "|0 ENDSEC"), options, "a.dxf");
    return drawing ? Error{} : drawing.error();
  };
  const Error color = error_of("0 LAYER|2 a|62 red", 9);
  EXPECT_EQ(color.value, "red");
  EXPECT_THAT(color.message, ::testing::HasSubstr("a.dxf, line 10, LAYER"));
  EXPECT_EQ(error_of("0 LAYER|2 a|62 -1|0 LAYER|2 b|62 -1", 1).code,
            ErrorCode::kTooLarge);
  EXPECT_EQ(error_of("0 LAYER|2 a|70 1e300|62 1", 1).message, "");
}

// A line is made through; of texts a line type has no effect.
TEST(DxfLayers, DashesOfALineTypeAreNamed) {
  const std::string tables = Groups(
      "0 SECTION|2 TABLES|0 TABLE|2 LTYPE|70 3|0 LTYPE|2 Dashed|70 0|73 2|40 9|49 6|49 "
      "-3|0 LTYPE|2 CONTINUOUS|70 0|73 0|40 0|0 ENDTAB|0 TABLE|2 LAYER|70 2|0 LAYER|2 "
      "Bend|70 0|62 1|6 DASHED|0 LAYER|2 cut|70 0|62 1|6 CONTINUOUS|0 ENDTAB|0 ENDSEC");
  const auto dashed_count = [&](const std::string& groups) {
    const Drawing drawing =
        DrawingOf(tables + Entities("0 LINE|" + groups + "|10 0|20 0|11 9|21 0"));
    EXPECT_EQ(drawing.curves.size(), 1U);
    for (const FileFinding& finding : drawing.findings)
      EXPECT_EQ(finding.effect, Effect::kChanged);
    return drawing.findings.CountOf("dashes of a line type");
  };
  for (const char* dashed : {"8 cut|6 DASHED", "8 BEND", "8 bend|6 ByLayer"})
    EXPECT_EQ(dashed_count(dashed), 1U) << dashed;
  for (const char* whole :
       {"8 cut", "8 bend|6 Continuous", "8 other", "8 cut|6 BYLAYER", "8 cut|6 unknown"})
    EXPECT_EQ(dashed_count(whole), 0U) << whole;
}

}  // namespace
}  // namespace intaglio::drawing
