// The oracle is the cubic Hermite polynomial, written here once more.
#include "services/drivers/linuxcnc/row_course.h"

#include <gtest/gtest.h>

namespace intaglio::drivers {
namespace {

constexpr double kTick_s = 0.01;
constexpr std::uint32_t kPeriods = 10;

motion::Segment To(double x_mm, double speed_mm_s, std::uint32_t subticks,
                   bool pulse = false, bool end = false) {
  motion::Segment segment;
  segment.end_position_mm = Vec3(x_mm, 0, 0);
  segment.end_velocity_mm_s = Vec3(speed_mm_s, 0, 0);
  segment.duration_subticks = subticks;
  segment.pulse = pulse;
  segment.program_end = end;
  return segment;
}

double Hermite(double p0, double v0, double p1, double v1, double duration_s, double u) {
  return (2 * u * u * u - 3 * u * u + 1) * p0 +
         (u * u * u - 2 * u * u + u) * duration_s * v0 +
         (3 * u * u - 2 * u * u * u) * p1 + (u * u * u - u * u) * duration_s * v1;
}

TEST(RowCourse, SamplesThePlanWithKnotsOnTheirRows) {
  RowCourse course;
  course.Begin(3, 100, Vec3(1, 0, 0), kTick_s);
  const std::uint32_t tick = motion::kSubticksPerTick;
  course.Append(
      std::vector{To(1.5, 20, 3 * tick, true), To(2.2, 0, 5 * tick, false, true)});
  EXPECT_EQ(course.covered_through_tick(), 108u);
  EXPECT_EQ(course.At(99, 5, kPeriods)->position_mm.x(), 1);
  for (std::uint32_t row = 0; row <= 8 * kPeriods; ++row) {
    const auto place = course.At(100 + row / kPeriods, row % kPeriods, kPeriods);
    ASSERT_TRUE(place) << row;
    const double t = row / static_cast<double>(kPeriods);
    const double expected = t < 3 ? Hermite(1, 0, 1.5, 20, 3 * kTick_s, t / 3)
                                  : Hermite(1.5, 20, 2.2, 0, 5 * kTick_s, (t - 3) / 5);
    EXPECT_NEAR(place->position_mm.x(), expected, 1e-12) << row;
    EXPECT_EQ(place->pulse, row == 3 * kPeriods) << row;
    EXPECT_EQ(place->ended, row == 8 * kPeriods) << row;
  }
  EXPECT_TRUE(course.At(110, 0, kPeriods)->ended);
}

// 7 rows a tick and 13 parts of 65536: sums of fractions would drift.
TEST(RowCourse, MeetsAKnotAMillionTicksOnExactly) {
  RowCourse course;
  course.Begin(1, 5, Vec3::Zero(), kTick_s);
  std::uint64_t at = 0;
  const auto advance = [&](std::uint32_t subticks) {
    at += subticks;
    course.Append(std::vector{To(static_cast<double>(at), 0, subticks, true)});
  };
  constexpr std::uint32_t kLong = 60000 * motion::kSubticksPerTick;
  for (int i = 0; i < 17; ++i) advance(kLong);
  advance(5041 * 13);
  advance(motion::kSubticksPerTick - 5041 * 13);
  const auto before = course.At(5 + 17 * 60000, 6, 7);
  ASSERT_TRUE(before);
  EXPECT_FALSE(before->pulse);
  const auto place = course.At(5 + 17 * 60000 + 1, 0, 7);
  ASSERT_TRUE(place);
  EXPECT_TRUE(place->pulse);
  EXPECT_EQ(place->position_mm.x(), static_cast<double>(at));
  EXPECT_FALSE(course.At(5 + 17 * 60000 + 1, 1, 7)) << "motion that ends without its end";
}

}  // namespace
}  // namespace intaglio::drivers
