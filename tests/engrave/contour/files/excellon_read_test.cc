#include "engrave/contour/files/excellon_read.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace intaglio::contour {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

DrillFile FileOf(const std::string& text, const ExcellonOptions& options = {}) {
  auto file = ReadExcellon(text, "a.drl", options);
  EXPECT_TRUE(file) << file.error().message;
  return file ? *file : DrillFile{};
}

std::string RefusalOf(const std::string& text, const ExcellonOptions& options = {}) {
  const auto file = ReadExcellon(text, "a.drl", options);
  return file ? "no error" : file.error().message;
}

void ExpectHole(const DrillFile& file, std::size_t k, double x, double y, double d) {
  ASSERT_LT(k, file.holes.size());
  EXPECT_NEAR(file.holes[k].center_mm.x(), x, 1e-12) << k;
  EXPECT_NEAR(file.holes[k].center_mm.y(), y, 1e-12) << k;
  EXPECT_NEAR(file.holes[k].diameter_mm, d, 1e-12) << k;
}

TEST(Excellon, AByteOrderMarkIsNoCommand) {
  const DrillFile file =
      FileOf("\xEF\xBB\xBFM48\nMETRIC,TZ\nT1C0.8\n%\nT1\nX1.0Y1.0\nM30\n");
  ASSERT_EQ(file.holes.size(), 1U);
  ExpectHole(file, 0, 1, 1, 0.8);
}

// As KiCad writes it: decimal points, a slot by G85.
TEST(Excellon, WhatLiesBehindTheEndIsMissingInThePieceAndNamed) {
  const std::string one = "M48\nMETRIC,TZ\nT1C0.8\n%\nT1\nX1.0Y1.0\nM30\n";
  const DrillFile joined = FileOf(one + one);
  EXPECT_EQ(joined.holes.size(), 1U);
  ASSERT_EQ(joined.findings.size(), 1U);
  EXPECT_EQ(joined.findings.begin()->effect, Effect::kLost);
  EXPECT_TRUE(FileOf(one + "\r\n\x1a").findings.empty());
}

TEST(Excellon, ReadsHolesAndSlotsWithPoints) {
  const DrillFile file = FileOf(
      "M48\r\n; DRILL file\r\n; FORMAT={-:-/ absolute / metric / decimal}\r\nFMAT,2\r\n"
      "METRIC\r\nT1C0.800\r\nT2C1.000\r\n%\r\nG90\r\nG05\r\nT1\r\nX10.5Y-3.25\r\nY4.0\r\n"
      "T2\r\nX1.0Y2.0G85X3.0Y2.0\r\nX-1.0\r\nT0\r\nM30\r\n");
  ASSERT_EQ(file.holes.size(), 3U);
  ExpectHole(file, 0, 10.5, -3.25, 0.8);
  ExpectHole(file, 1, 10.5, 4, 0.8);
  ExpectHole(file, 2, -1, 2, 1);
  ASSERT_EQ(file.slots.size(), 1U);
  const auto& slot = std::get<Track>(file.slots[0].shape);
  EXPECT_EQ(slot.begin_mm, Vec2(1, 2));
  EXPECT_EQ(slot.end_mm, Vec2(3, 2));
  EXPECT_EQ(slot.width_mm, 1);
  EXPECT_TRUE(file.findings.empty());
}

// One place, 12.34 mm and 0.5 mm, in every way of leaving zeros out.
TEST(Excellon, KnowsWhichZerosAreLeftOut) {
  ExpectHole(FileOf("M48\nMETRIC,LZ\nT1C1\n%\nT1\nX01234Y0005\n"), 0, 12.34, 0.5, 1);
  ExpectHole(FileOf("M48\nMETRIC,TZ\nT1C1\n%\nT1\nX12340Y500\n"), 0, 12.34, 0.5, 1);
  ExpectHole(FileOf("M48\nMETRIC,TZ,0000.00\nT1C1\n%\nT1\nX1234Y-50\n"), 0, 12.34, -0.5,
             1);
  ExpectHole(FileOf("M48\nMETRIC,000.000,LZ\nT1C1\n%\nT1\nX01234Y-0005\n"), 0, 12.34,
             -0.5, 1);
  ExpectHole(FileOf("M48\nINCH,LZ\nT1C.04\n%\nT1\nX015Y0005\n"), 0, 1.5 * 25.4,
             0.05 * 25.4, 0.04 * 25.4);
  ExpectHole(FileOf("M48\nINCH,TZ\nT1C.04\n%\nT1\nX15000Y500\n"), 0, 1.5 * 25.4,
             0.05 * 25.4, 0.04 * 25.4);
  const std::string open = "M48\nMETRIC\nT1C1\n%\nT1\nX12340Y500\n";
  EXPECT_THAT(RefusalOf(open),
              AllOf(HasSubstr("a.drl: line 6:"), HasSubstr("LZ nor TZ")));
  ExcellonOptions trailing;
  trailing.units = "METRIC,TZ";
  ExpectHole(FileOf(open, trailing), 0, 12.34, 0.5, 1);
}

// A header that is wrong: 12.34 mm and 0.5 mm, written otherwise than declared.
TEST(Excellon, UnitsThatAreGivenGoFirstWhenThatIsAsked) {
  const auto replacing = [](const char* units) {
    ExcellonOptions options;
    options.units = units;
    options.replace_units = true;
    return options;
  };
  const auto expect = [&](const std::string& text, const char* units,
                          const std::vector<std::string>& whats) {
    const DrillFile file = FileOf(text, replacing(units));
    ExpectHole(file, 0, 12.34, 0.5, 1);
    std::vector<std::string> found;
    for (const FileFinding& finding : file.findings) {
      found.push_back(finding.what);
      EXPECT_EQ(finding.effect, Effect::kChanged);
      EXPECT_THAT(finding.where, HasSubstr("line "));
    }
    EXPECT_EQ(found, whats);
  };
  expect("M48\nINCH,TZ\nT1C1\n%\nT1\nX12.34Y.5\n", "METRIC",
         {"INCH of the file, METRIC as given"});
  expect("M48\nINCH,LZ\nT1C1\n%\nT1\nX12340Y500\n", "METRIC,TZ",
         {"INCH of the file, METRIC as given", "LZ of the file, TZ as given"});
  expect("M48\n;FILE_FORMAT=2:4\nMETRIC,TZ\nT1C1\n%\nT1\nX1234Y50\n", "METRIC,TZ,0000.00",
         {"2:4 digits of the file, 4:2 digits as given"});
  expect("M48\nM72\nT1C1\n%\nT1\nX12.34Y0.5\n", "METRIC",
         {"INCH of the file, METRIC as given"});
  // What is given has no digits: those of the file. What is the same is no finding.
  expect("M48\nMETRIC,LZ,0000.00\nT1C1\n%\nT1\nX1234Y50\n", "METRIC,TZ",
         {"LZ of the file, TZ as given"});
  expect("M48\nMETRIC,TZ\nT1C1\n%\nT1\nX12340Y500\n", "METRIC,TZ", {});
  // Without being asked to replace them the file's go first.
  ExcellonOptions given;
  given.units = "INCH,LZ";
  ExpectHole(FileOf("M48\nMETRIC,TZ\nT1C1\n%\nT1\nX12340Y500\n", given), 0, 12.34, 0.5,
             1);
}

TEST(Excellon, AddsStepsAndRepeats) {
  const DrillFile file =
      FileOf("M48\nM71\nT01F00S00C0.9\n%\nG91\nT01\nX1.0Y1.0\nX2.0\nR3Y0.5\nM30\nX9.0\n");
  ASSERT_EQ(file.holes.size(), 5U);
  ExpectHole(file, 1, 3, 1, 0.9);
  ExpectHole(file, 4, 3, 2.5, 0.9);
}

TEST(Excellon, RoutesLinesAndArcs) {
  const DrillFile file = FileOf(
      "M48\nMETRIC\nT1C2.0\n%\nT1\nG00X0.0Y0.0\nM15\nG01X5.0\nG03X10.0Y5.0A5.0\n"
      "G02X15.0Y10.0I5.0J0.0\nM16\nG00X1.0Y1.0\nG05\nX2.0Y2.0\n");
  ASSERT_EQ(file.slots.size(), 3U);
  EXPECT_EQ(std::get<Track>(file.slots[0].shape).end_mm, Vec2(5, 0));
  const Edge& left = std::get<ArcTrack>(file.slots[1].shape).arc;
  EXPECT_LT((left.center_mm - Vec2(5, 5)).norm(), 1e-9);
  EXPECT_NEAR(left.sweep_rad, std::numbers::pi / 2, 1e-9);
  const Edge& right = std::get<ArcTrack>(file.slots[2].shape).arc;
  EXPECT_LT((right.center_mm - Vec2(15, 5)).norm(), 1e-9);
  EXPECT_NEAR(right.sweep_rad, -std::numbers::pi / 2, 1e-9);
  ASSERT_EQ(file.holes.size(), 1U);
  ExpectHole(file, 0, 2, 2, 2);
}

// A file of such routes alone was refused as one that holds nothing, without a word.
TEST(Excellon, NamesRoutesThatNothingLowersTheToolFor) {
  const DrillFile file = FileOf(
      "M48\nMETRIC\nT1C2.0\n%\nT1\nG00X0.0Y0.0\nG01X5.0\nG01X5.0Y5.0\n"
      "M15\nG01X0.0\nM16\n");
  EXPECT_EQ(file.slots.size(), 1U);
  ASSERT_EQ(file.findings.size(), 1U);
  const FileFinding& finding = *file.findings.begin();
  EXPECT_EQ(finding.what, "route with the tool up");
  EXPECT_EQ(finding.where, "line 7");
  EXPECT_EQ(finding.count, 2U);
}

TEST(Excellon, RefusesWhatItWouldGuess) {
  EXPECT_THAT(RefusalOf(""), HasSubstr("no drill file"));
  EXPECT_THAT(RefusalOf("M48\nT1C1\n"), HasSubstr("neither METRIC nor INCH"));
  EXPECT_THAT(RefusalOf("M48\nMETRIC\n%\nX1.0\n"), HasSubstr("before any tool"));
  EXPECT_THAT(RefusalOf("M48\nMETRIC\n%\nT3\nX1.0\n"),
              AllOf(HasSubstr("line 5"), HasSubstr("T3 has no diameter")));
  EXPECT_THAT(RefusalOf("M48\nMETRIC\nT1C0\n"), HasSubstr("positive diameter"));
  EXPECT_THAT(RefusalOf("M48\nMETRIC,XZ\n"), HasSubstr("LZ, TZ"));
  EXPECT_THAT(RefusalOf("M48\nMETRIC\nT1C1\n%\nT1\nX1.0.0\n"), HasSubstr("length"));
  EXPECT_THAT(RefusalOf("M48\nMETRIC\nT1C1\n%\nT1\nX99999.0\n"), HasSubstr("length"));
  EXPECT_THAT(RefusalOf("M48\nMETRIC\nT1C1\n%\nT1\n$$\n"),
              HasSubstr("expected a command"));
  EXPECT_THAT(RefusalOf("M48\nMETRIC\nT1C1\n%\nT1\nM15\nG02X1.0Y1.0A0.1\n"),
              HasSubstr("half its chord"));
  ExcellonOptions few;
  few.max_holes = 2;
  EXPECT_THAT(RefusalOf("M48\nMETRIC\nT1C1\n%\nT1\nX1.0\nR9X1.0\n", few),
              HasSubstr("more than 2"));
}

}  // namespace
}  // namespace intaglio::contour
