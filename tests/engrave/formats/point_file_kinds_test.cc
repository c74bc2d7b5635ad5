#include "engrave/formats/point_file_kinds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/test_folder.h"

namespace intaglio::formats {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

TEST(PointFileKinds, EveryReadableKindGivesTheWrittenPointsBack) {
  const PointTable table{{{0.1, 2, -1.0 / 3}, {1e-9, 5, 6}}, {}, {}};
  const fs::path folder = test::FreshFolder();
  for (const char* name :
       {"a.ply", "a.xyz", "a.txt", "a.cft", "a.scl", "a.dxf", "A.SCL", "b.Ply"}) {
    const fs::path file = folder / name;
    ASSERT_TRUE(WritePoints(file, table).has_value()) << name;
    const auto read = ReadPoints(file);
    ASSERT_TRUE(read.has_value()) << read.error().message;
    EXPECT_EQ(read->points_mm, table.points_mm) << name;
    const auto parsed = ParsePoints(test::ContentOf(file), file.extension().string());
    ASSERT_TRUE(parsed.has_value()) << parsed.error().message;
    EXPECT_EQ(parsed->points_mm, table.points_mm) << name;
  }
}

TEST(PointFileKinds, ErrorsNameTheFileAndWhatThereIs) {
  const fs::path folder = test::FreshFolder();
  const auto read = ReadPoints(folder / "cloud.las");
  EXPECT_EQ(read.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(read.error().message, HasSubstr("cloud.las: points of the kind 'las'"));
  EXPECT_THAT(read.error().message, HasSubstr("one of ply, xyz, txt, cft, scl, dxf"));
  const auto written = WritePoints(folder / "cloud", {});
  EXPECT_EQ(written.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(written.error().message, HasSubstr("one of ply, xyz, txt, cft, scl, dxf"));
  EXPECT_EQ(test::FileCountIn(folder), 0u);
  EXPECT_EQ(ParsePoints("1 2 3", "").error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(ReadPoints(folder / "absent.scl").error().code, ErrorCode::kNotFound);
}

TEST(PointFileKinds, AFileWithoutPointsIsRefusedInEveryKind) {
  const fs::path folder = test::FreshFolder();
  for (const char* name : {"a.ply", "a.xyz", "a.txt", "a.cft", "a.scl", "a.dxf"}) {
    const fs::path file = folder / name;
    ASSERT_TRUE(WritePoints(file, {}).has_value()) << name;
    const auto read = ReadPoints(file);
    ASSERT_FALSE(read.has_value()) << name;
    EXPECT_THAT(read.error().message, HasSubstr(name));
    EXPECT_FALSE(ParsePoints(test::ContentOf(file), file.extension().string())) << name;
  }
}

TEST(PointFileKinds, CommentsThatAreReadCanBeWritten) {
  // Carriage returns in the middle of a line, as of a Macintosh's text.
  const std::string ply =
      "ply\nformat ascii 1.0\ncomment a\rb\nelement vertex 1\nproperty float x\n"
      "property float y\nproperty float z\nend_header\n1 2 3\n";
  const std::string dxf =
      "999\na\rb\n0\nSECTION\n2\nENTITIES\n0\nPOINT\n10\n1\n0\nENDSEC\n0\nEOF\n";
  const fs::path folder = test::FreshFolder();
  for (const auto& [bytes, extension] :
       {std::pair<std::string, std::string>{"# a\rb\n1 2 3\n", "xyz"},
        {ply, "ply"},
        {dxf, "dxf"}}) {
    const auto table = ParsePoints(bytes, extension);
    ASSERT_TRUE(table.has_value()) << table.error().message;
    EXPECT_EQ(table->comments, std::vector<std::string>{"a b"}) << extension;
    EXPECT_TRUE(WritePoints(folder / "a.scl", *table).has_value());
  }
}

TEST(PointFileKinds, WritesTextToADevice) {
  EXPECT_TRUE(WritePoints("/dev/null", {{{1, 2, 3}}, {}, {}}).has_value());
}

}  // namespace
}  // namespace intaglio::formats
