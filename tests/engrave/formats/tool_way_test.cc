// The record of a tool's way against bytes that were written elsewhere, and cut.

#include "engrave/formats/tool_way.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "engrave/io/whole_file.h"

namespace intaglio::formats {
namespace {

const std::filesystem::path kTwoSteps =
    INTAGLIO_SOURCE_DIR "/tests/fuzz/corpus/tool_way_fuzz/two.rec";

TEST(ToolWay, ReadsAFileOfAnotherWriter) {
  // Written by Python's struct and zlib.
  const auto way = ReadToolWay(kTwoSteps);
  ASSERT_TRUE(way) << way.error().message;
  EXPECT_EQ(way->header.tool_diameter_mm, 0.3);
  EXPECT_EQ(way->header.sheet_thickness_mm, 1.6);
  EXPECT_EQ(way->header.sheet_height_mm, -0.05);
  EXPECT_FALSE(way->header.is_laser);
  ASSERT_EQ(way->steps.size(), 2U);
  EXPECT_FALSE(way->steps[0].is_on);
  const ToolWayStep& step = way->steps[1];
  EXPECT_EQ(step.end_us, 123456U);
  EXPECT_EQ(step.end_mm, Vec3(1.5, -2.5, -0.1));
  EXPECT_EQ(step.power, 10000);
  EXPECT_TRUE(step.is_on);
  EXPECT_EQ(way->torn_bytes, 0U);
}

TEST(ToolWay, IsWrittenAsTheOtherWriterWroteIt) {
  const auto way = ReadToolWay(kTwoSteps);
  ASSERT_TRUE(way);
  std::vector<std::byte> bytes = EncodeToolWayHeader(way->header);
  for (const ToolWayStep& step : way->steps) AppendToolWayStep(step, bytes);
  const std::string written(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  EXPECT_EQ(written, *io::ReadWholeFile(kTwoSteps, 1000));
}

TEST(ToolWay, IsReadableUpToWhereItWasCutOrDamaged) {
  std::vector<std::byte> bytes = EncodeToolWayHeader({0.2, 1.6, 0, true});
  for (std::uint64_t i = 0; i < 3; ++i) AppendToolWayStep({i, {1, 2, 3}, 1, true}, bytes);
  for (std::size_t size = kToolWayHeaderSize; size <= bytes.size(); ++size) {
    const auto way = ParseToolWay(std::span(bytes).first(size));
    ASSERT_TRUE(way);
    EXPECT_EQ(way->steps.size(), (size - kToolWayHeaderSize) / kToolWayStepSize);
    EXPECT_EQ(way->torn_bytes, (size - kToolWayHeaderSize) % kToolWayStepSize);
  }
  bytes[kToolWayHeaderSize + kToolWayStepSize + 10] ^= std::byte(1);
  EXPECT_EQ(ParseToolWay(bytes)->steps.size(), 1U);
  bytes[3] ^= std::byte(1);
  EXPECT_FALSE(ParseToolWay(bytes));
  EXPECT_FALSE(ReadToolWay("/nonexistent/cut.rec"));
}

TEST(ToolWay, RefusesAToolOrASheetThatIsNone) {
  constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
  for (const ToolWayHeader& header :
       {ToolWayHeader{0, 1.6, 0, false}, ToolWayHeader{0.2, -1, 0, false},
        ToolWayHeader{kNaN, 1.6, 0, false}, ToolWayHeader{0.2, 1.6, kNaN, false}}) {
    const auto way = ParseToolWay(EncodeToolWayHeader(header));
    ASSERT_FALSE(way);
    EXPECT_EQ(way.error().code, ErrorCode::kUnreadable);
  }
}

}  // namespace
}  // namespace intaglio::formats
