#include "engrave/discretize/warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::discretize {
namespace {

using ::testing::HasSubstr;

TEST(Warnings, WhatIsMissingIsReportedWithTheRemedy) {
  EXPECT_TRUE(WarningsOf({}, 0.1).empty());
  MethodStatistics statistics;
  statistics.parallel_area_mm2 = 50;
  statistics.ray_count = 1000;
  statistics.odd_ray_count = 3;
  statistics.rejected_triangle_count = 2;
  const auto warnings = WarningsOf(statistics, 0.1);
  ASSERT_EQ(warnings.size(), 3u);
  EXPECT_THAT(warnings[0].text, HasSubstr("50.00 mm^2"));
  EXPECT_THAT(warnings[1].text, HasSubstr("3 of 1000 rays"));
  EXPECT_THAT(warnings[2].text, HasSubstr("2 triangles"));
}

}  // namespace
}  // namespace intaglio::discretize
