#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>

#include "engrave/formats/point_file.h"
#include "tests/test_folder.h"

namespace intaglio::formats {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(XyzFile, RoundTripKeepsEveryBit) {
  std::mt19937_64 random(5);
  PointTable table;
  table.points_mm = {{-0.0, std::numeric_limits<double>::denorm_min(),
                      -std::numeric_limits<double>::max()}};
  while (table.points_mm.size() < 20'000) {
    const Vec3 p(std::bit_cast<double>(random()), std::bit_cast<double>(random()),
                 std::bit_cast<double>(random()));
    if (p.allFinite()) table.points_mm.push_back(p);
  }
  table.comments = {"glass frame, mm", "", "# twice"};
  const fs::path file = test::FreshFolder() / "cloud.xyz";
  ASSERT_TRUE(WriteXyz(file, table).has_value());
  const auto read = ReadXyz(file);
  ASSERT_TRUE(read.has_value()) << read.error().message;
  ASSERT_EQ(read->points_mm.size(), table.points_mm.size());
  for (std::size_t i = 0; i < table.points_mm.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      ASSERT_EQ(std::bit_cast<std::uint64_t>(read->points_mm[i][axis]),
                std::bit_cast<std::uint64_t>(table.points_mm[i][axis]));
    }
  }
  EXPECT_EQ(read->comments, table.comments);
}

TEST(XyzFile, IsShortText) {
  PointTable table;
  table.points_mm = {{0.1, 20, -3.25}};
  table.comments = {"one point"};
  const fs::path file = test::FreshFolder() / "one.xyz";
  ASSERT_TRUE(WriteXyz(file, table).has_value());
  EXPECT_EQ(test::ContentOf(file), "# one point\n0.1 20 -3.25\n");
}

TEST(XyzFile, AByteOrderMarkIsNoPartOfTheFirstPoint) {
  for (const char* text : {"\xEF\xBB\xBF"
                           "1 2 3\r\n4 5 6\r\n",
                           "\xEF\xBB\xBF# two\n1 2 3\n4 5 6\n"}) {
    const auto table = ParseXyz(text);
    ASSERT_TRUE(table.has_value()) << table.error().message;
    EXPECT_THAT(table->points_mm, ElementsAre(Vec3(1, 2, 3), Vec3(4, 5, 6)));
  }
}

// Programs of many countries write them; "1,2,3" and "1, 2, 3" stay three numbers.
TEST(XyzFile, DecimalCommasBetweenBlanksAreDecimals) {
  const auto table =
      ParseXyz("20,5 12,1 3\n1;-2,25;3,5\n1,2,3\n1, 2, 3\n1.5,2 3\n1,2 3\n0,5\t1\t2\n");
  ASSERT_TRUE(table.has_value()) << table.error().message;
  EXPECT_THAT(table->points_mm, ElementsAre(Vec3(20.5, 12.1, 3), Vec3(1, -2.25, 3.5),
                                            Vec3(1, 2, 3), Vec3(1, 2, 3), Vec3(1.5, 2, 3),
                                            Vec3(1, 2, 3), Vec3(0.5, 1, 2)));
}

// Commas of thousands, and decimal commas beside points, are no other point.
TEST(XyzFile, CommasThatMayBeOfANumberAreRefused) {
  for (const char* line :
       {"1,234.5 2 3", "1 2,345.5 3", "1,5 2 3.5 4", "1,5;2;3 # 0.1"}) {
    const auto table = ParseXyz(std::string("1 2 3\n") + line + "\n");
    ASSERT_FALSE(table.has_value()) << line;
    EXPECT_EQ(table.error().code, ErrorCode::kUnreadable);
    EXPECT_THAT(table.error().message,
                HasSubstr("line 2 has commas and other separators"));
  }
}

// 1.5 2.5 3.5, or 1 5 2 and what follows: one line that has no such reading decides.
TEST(XyzFile, SixWholeNumbersAreRefusedWhereAllLinesMayHaveDecimalCommas) {
  const auto doubtful = ParseXyz("# x,y,z\n1,5,2,5,3,5\n2,0,1,25,3,0\n");
  ASSERT_FALSE(doubtful);
  EXPECT_THAT(doubtful.error().message,
              HasSubstr("line 2 and all others have six numbers divided by commas, or"));
  const auto colours = ParseXyz("10,20,30,255,0,0\n10.5,20,30,255,0,0\n");
  ASSERT_TRUE(colours) << colours.error().message;
  EXPECT_EQ(colours->points_mm[0], Vec3(10, 20, 30));
}

TEST(XyzFile, TakesAnySeparatorAndPassesOverTheRest) {
  const auto table = ParseXyz(
      "#comment\r\n\r\n1 2 3\r\n  4,5,\t6 , 255\n+7;8;9e-1\n  # indented\n \t\n1 2 3.5 "
      "word");
  ASSERT_TRUE(table.has_value()) << table.error().message;
  EXPECT_THAT(table->points_mm, ElementsAre(Vec3(1, 2, 3), Vec3(4, 5, 6), Vec3(7, 8, 0.9),
                                            Vec3(1, 2, 3.5)));
  EXPECT_THAT(table->comments, ElementsAre("comment", "indented"));
}

TEST(XyzFile, NamesTheLineThatIsWrong) {
  for (const char* line :
       {"1 2", "1 2 three", "1 2 3x", "x 1 2", "1 2 +-3", "1 2 0x10 4"}) {
    const auto table = ParseXyz(std::string("1 2 3\n# fine\n") + line + "\n4 5 6\n");
    ASSERT_FALSE(table.has_value()) << line;
    EXPECT_EQ(table.error().code, ErrorCode::kUnreadable);
    EXPECT_THAT(table.error().message, HasSubstr("line 3 is not three numbers"));
  }
  const auto infinite = ParseXyz("1 2 3\n1 inf 2\n");
  ASSERT_FALSE(infinite.has_value());
  EXPECT_EQ(infinite.error().code, ErrorCode::kInvalidValue);
  EXPECT_THAT(infinite.error().message, HasSubstr("line 2"));
}

TEST(XyzFile, RefusesNoPointsAndTooMany) {
  EXPECT_EQ(ParseXyz("# nothing\n").error().code, ErrorCode::kMissing);
  PointFileLimits limits;
  limits.max_points = 2;
  EXPECT_TRUE(ParseXyz("1 2 3\n1 2 3\n", limits).has_value());
  EXPECT_EQ(ParseXyz("1 2 3\n1 2 3\n1 2 3\n", limits).error().code, ErrorCode::kTooLarge);
}

TEST(XyzFile, ErrorNamesTheFile) {
  const fs::path file = test::FreshFolder() / "bad.xyz";
  std::ofstream(file) << "abc\n";
  EXPECT_THAT(ReadXyz(file).error().message, HasSubstr("bad.xyz: line 1 is not"));
  EXPECT_EQ(ReadXyz("/nonexistent.xyz").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace intaglio::formats
