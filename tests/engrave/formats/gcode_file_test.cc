#include "engrave/formats/gcode_file.h"

#include <gtest/gtest.h>

#include "engrave/core/check.h"
#include "tests/test_folder.h"

namespace intaglio::formats {
namespace {

namespace fs = std::filesystem;

PointTable Path() {
  return {{{10, 20.0004, -0.0001}, {10.1234567, 20, 5}, {-3, 0, 1000}},
          {{"tick", std::vector<double>{0, 1, 2}}},
          {"glass frame, mm (of the block)"}};
}

TEST(GcodeFile, IsTheGoldenFile) {
  const fs::path file = test::FreshFolder() / "path.nc";
  ASSERT_TRUE(WriteGcode(file, Path()).has_value());
  EXPECT_EQ(test::ContentOf(file), test::ContentOf(fs::path(INTAGLIO_SOURCE_DIR) /
                                                   "tests/data/formats/path_default.nc"));
}

TEST(GcodeFile, IsTheGoldenFileOfAllItsOptions) {
  GcodeOptions options;
  options.decimals = 5;
  options.feed_mm_min = 1200;
  options.pulse = "M3 S1000\nG4 P0.001\nM5";
  options.origin_mm = Vec3(10, 20, 5);
  options.header = "G21 G90 G64\nG0 Z50";
  options.footer = "G0 Z50\nM30";
  const fs::path file = test::FreshFolder() / "path.nc";
  ASSERT_TRUE(WriteGcode(file, Path(), options).has_value());
  EXPECT_EQ(test::ContentOf(file), test::ContentOf(fs::path(INTAGLIO_SOURCE_DIR) /
                                                   "tests/data/formats/path_options.nc"));
}

TEST(GcodeFile, RefusesOptionsOutsideTheirRanges) {
  const fs::path file = test::FreshFolder() / "path.nc";
  GcodeOptions options;
  options.decimals = 10;
  EXPECT_THROW((void)WriteGcode(file, Path(), options), PreconditionError);
  options = {};
  options.feed_mm_min = -1;
  EXPECT_THROW((void)WriteGcode(file, Path(), options), PreconditionError);
  options = {};
  options.pulse.clear();
  EXPECT_THROW((void)WriteGcode(file, Path(), options), PreconditionError);
}

}  // namespace
}  // namespace intaglio::formats
