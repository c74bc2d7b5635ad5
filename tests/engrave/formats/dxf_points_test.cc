#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engrave/formats/point_file.h"
#include "engrave/formats/point_file_kinds.h"
#include "tests/test_folder.h"

namespace intaglio::formats {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::string Drawing(const std::string& header, const std::string& entities) {
  return "0\nSECTION\n2\nHEADER\n" + header + "0\nENDSEC\n0\nSECTION\n2\nENTITIES\n" +
         entities + "0\nENDSEC\n0\nEOF\n";
}

constexpr char kPoint[] = "0\nPOINT\n8\n0\n10\n1\n20\n2.5\n30\n-3\n";

TEST(DxfPoints, AreWrittenAsPointEntities) {
  const fs::path file = test::FreshFolder() / "one.dxf";
  ASSERT_TRUE(WriteDxf(file, {{{0.1, 20, -1e-7}}, {}, {"mm"}}).has_value());
  EXPECT_EQ(
      test::ContentOf(file),
      "999\nmm\n0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n4\n"
      "0\nENDSEC\n0\nSECTION\n2\nENTITIES\n0\nPOINT\n8\npoints\n10\n0.1\n20\n20\n30\n"
      "-0.0000001\n0\nENDSEC\n0\nEOF\n");
}

TEST(DxfPoints, RoundTripKeepsEveryBit) {
  PointTable table{{{0.1, 1.0 / 3, -3e-17}, {1e17, 0, 2}}, {}, {"mm", "and so on"}};
  const fs::path file = test::FreshFolder() / "cloud.DXF";
  ASSERT_TRUE(WriteDxf(file, table).has_value());
  const auto read = ReadPoints(file);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_EQ(read->points_mm, table.points_mm);
  EXPECT_EQ(read->comments, table.comments);
}

TEST(DxfPoints, TakesOnlyThePointsOfTheModelSpace) {
  const std::string elsewhere =
      std::string("0\nSECTION\n2\nBLOCKS\n") + kPoint + "0\nENDSEC\n";
  const auto read =
      ParseDxf(elsewhere +
               Drawing("", std::string("0\nLINE\n10\n9\n20\n9\n11\n8\n21\n8\n") + kPoint +
                               "0\nCIRCLE\n10\n7\n20\n7\n40\n1\n0\nLINE\n10\n5\n"));
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_THAT(read->points_mm, ElementsAre(Vec3(1, 2.5, -3)));
  EXPECT_THAT(read->comments,
              ElementsAre("3 entities other than POINT were ignored: CIRCLE 1, LINE 2"));
}

// A carriage return inside a line is of a damaged file, or of an old Macintosh.
TEST(DxfPoints, WhatWasPassedOverIsReportedInOneLine) {
  const auto read = ParseDxf(Drawing("", std::string("0\nEND\rREC\n") + kPoint));
  ASSERT_TRUE(read.has_value()) << read.error().message;
  ASSERT_EQ(read->comments.size(), 1u);
  EXPECT_EQ(read->comments[0].find_first_of("\r\n"), std::string::npos);
}

TEST(DxfPoints, ReadsWindowsLineEndsAndAPointWithoutZ) {
  const auto read = ParseDxf(
      "  0\r\nSECTION\r\n  2\r\nENTITIES\r\n  0\r\nPOINT\r\n 10\r\n"
      " 4.0\r\n 20\r\n5\r\n  0\r\nENDSEC\r\n  0\r\nEOF\r\n");
  ASSERT_TRUE(read.has_value()) << read.error().message;
  EXPECT_THAT(read->points_mm, ElementsAre(Vec3(4, 5, 0)));
}

TEST(DxfPoints, AppliesTheDrawingsUnit) {
  for (const auto& [code, mm] : {std::pair{"0", 1.0},
                                 {"1", 25.4},
                                 {"4", 1.0},
                                 {"6", 1000.0},
                                 {"24", 5280 * 1200 / 3.937}}) {
    const auto read =
        ParseDxf(Drawing(fmt::format("9\n$INSUNITS\n70\n     {}\n", code), kPoint));
    ASSERT_TRUE(read.has_value()) << read.error().message;
    // Within the roundings of two ways to write a survey mile.
    EXPECT_TRUE(read->points_mm[0].isApprox(Vec3(1, 2.5, -3) * mm, 1e-15)) << code;
  }
  const auto unknown = ParseDxf(Drawing("9\n$INSUNITS\n70\n25\n", kPoint));
  EXPECT_EQ(unknown.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(unknown.error().message, HasSubstr("to millimetres"));
}

TEST(DxfPoints, ReportsWhatIsWrong) {
  const std::string whole = Drawing("", kPoint);
  EXPECT_EQ(ParseDxf("AutoCAD Binary DXF\r\n\x1a").error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(ParseDxf("0\nSECTION\nnonsense\n").error().message,
              HasSubstr("line 3 is not a group code"));
  EXPECT_THAT(ParseDxf(Drawing("", "0\nPOINT\n10\n1,5\n")).error().message,
              HasSubstr("is not a coordinate: \"1,5\""));
  EXPECT_EQ(ParseDxf(Drawing("", "0\nPOINT\n10\ninf\n")).error().code,
            ErrorCode::kInvalidValue);
  const auto none = ParseDxf(Drawing("", "0\nLINE\n10\n1\n"));
  EXPECT_EQ(none.error().code, ErrorCode::kMissing);
  EXPECT_THAT(none.error().message, HasSubstr("no POINT, only LINE 1"));
  EXPECT_EQ(ParseDxf(Drawing("", "")).error().code, ErrorCode::kMissing);
  EXPECT_THAT(ParseDxf(whole + whole).error().message, HasSubstr("more behind its EOF"));
  EXPECT_TRUE(ParseDxf(whole + "\r\n\x1a"));
  PointFileLimits limits;
  limits.max_points = 1;
  EXPECT_EQ(ParseDxf(Drawing("", std::string(kPoint) + kPoint), limits).error().code,
            ErrorCode::kTooLarge);
  for (std::size_t size = 0; size + 5 < whole.size(); ++size) {
    EXPECT_EQ(ParseDxf(whole.substr(0, size)).error().code, ErrorCode::kUnreadable)
        << size;
  }
}

TEST(DxfPoints, DrawingsOfCurvesAreNamedAsSuch) {
  const auto read = ReadPoints(INTAGLIO_SOURCE_DIR "/tests/data/trimesh/wrench.dxf");
  ASSERT_FALSE(read.has_value());
  EXPECT_THAT(read.error().message, HasSubstr("wrench.dxf: it has no POINT, only"));
}

}  // namespace
}  // namespace intaglio::formats
