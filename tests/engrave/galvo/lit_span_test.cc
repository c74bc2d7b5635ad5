// Strokes that are lit in spans: what each tick does, against the spans.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engrave/galvo/mark_ticks.h"

namespace intaglio::galvo {
namespace {

using testing::HasSubstr;

MarkTickOptions Sweeping(double speed_mm_s) {
  MarkTickOptions options;
  options.mark_mm_s = speed_mm_s;
  options.jump_mm_s = 5000;
  options.run_in_s = 6e-4;
  return options;
}

/// Dots of 0.05 mm at 60 uneven places of a line that is turned by 30 degrees.
MarkStroke UnevenRow() {
  MarkStroke row;
  for (int i = 0; i < 60; ++i) {
    const double from_mm = 0.113 * i + 0.01 * std::sin(i) * (i > 0 ? 1 : 0);
    row.lit.push_back({from_mm, from_mm + 0.05});
  }
  const double length_mm = row.lit.back().to_mm;
  row.points_mm = {{1, 2}, Vec2(1, 2) + length_mm * Vec2(std::sqrt(0.75), 0.5)};
  return row;
}

struct LitRun {
  std::size_t first, count;
  double middle_mm;  // along the row, by the places between which its ticks move
};

std::vector<LitRun> LitRuns(const std::vector<MarkTick>& ticks, const MarkStroke& row) {
  const Vec2 begin_mm = row.points_mm.front();
  const Vec2 along = (row.points_mm.back() - begin_mm).normalized();
  std::vector<LitRun> runs;
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    if (!ticks[k].laser) continue;
    if (runs.empty() || runs.back().first + runs.back().count != k)
      runs.push_back({k, 0, 0});
    ++runs.back().count;
  }
  for (LitRun& run : runs) {
    const Vec2 sum = ticks[run.first].place_mm + ticks[run.first + run.count].place_mm;
    run.middle_mm = (sum / 2 - begin_mm).dot(along);
  }
  return runs;
}

TEST(LitSpans, HaveAsManyTicksEachAtMostHalfATickFromTheirPlace) {
  const MarkStroke row = UnevenRow();
  for (const double speed_mm_s : {300.0, 1000.0, 1700.0, 3300.0}) {
    const auto ticks =
        MakeMarkTicks(std::vector{row}, {0, 0}, Sweeping(speed_mm_s)).value();
    const auto runs = LitRuns(ticks, row);
    ASSERT_EQ(runs.size(), row.lit.size()) << speed_mm_s;
    for (std::size_t i = 0; i < runs.size(); ++i) {
      EXPECT_EQ(runs[i].count, runs[0].count) << speed_mm_s << " " << i;
      const double middle_mm = (row.lit[i].from_mm + row.lit[i].to_mm) / 2;
      EXPECT_NEAR(runs[i].middle_mm, middle_mm, 0.5e-5 * speed_mm_s + 1e-9) << i;
    }
  }
}

TEST(LitSpans, AreSweptAtOneSpeedBeforeAndBehindThem) {
  const MarkStroke row = UnevenRow();
  const auto ticks = MakeMarkTicks(std::vector{row}, {0, 0}, Sweeping(1000)).value();
  const auto runs = LitRuns(ticks, row);
  const std::size_t end = runs.back().first + runs.back().count;
  for (std::size_t k = runs.front().first - 60; k < end + 60; ++k) {
    EXPECT_NEAR((ticks[k + 1].place_mm - ticks[k].place_mm).norm(), 0.01, 2e-5) << k;
  }
}

TEST(LitSpans, AreSwitchedLaterByTheDelaysOfTheLaser) {
  const MarkStroke row = UnevenRow();
  auto late = Sweeping(1000);
  late.laser_on_delay_s = late.laser_off_delay_s = 2e-4;
  const auto at_once =
      LitRuns(MakeMarkTicks(std::vector{row}, {0, 0}, Sweeping(1000)).value(), row);
  const auto later = LitRuns(MakeMarkTicks(std::vector{row}, {0, 0}, late).value(), row);
  ASSERT_EQ(later.size(), at_once.size());
  for (std::size_t i = 0; i < later.size(); ++i) {
    EXPECT_EQ(later[i].first, at_once[i].first + 20);
    EXPECT_EQ(later[i].count, at_once[i].count);
  }
  // A delay of the end alone that is shorter than a dot leaves each a tick.
  late.laser_off_delay_s = 0;
  EXPECT_EQ(LitRuns(MakeMarkTicks(std::vector{row}, {0, 0}, late).value(), row).size(),
            row.lit.size());
}

TEST(LitSpans, TakeTheTimeOfTheWholeStroke) {
  MarkStroke row = UnevenRow();
  for (const bool leads : {false, true}) {
    auto options = Sweeping(1000);
    options.lag_s = 2e-4;
    options.lead_servo = leads;
    const auto rows = CountStrokeTicks(std::vector{row}, options).value();
    const MarkStroke whole{row.points_mm, false, {}};
    // One is at most as fast as asked, the other the nearest to that.
    EXPECT_NEAR(
        static_cast<double>(rows.count),
        static_cast<double>(CountStrokeTicks(std::vector{whole}, options).value().count),
        1);
    EXPECT_EQ(rows.count + CountJumpTicks(rows.first_mm.norm(), options),
              MakeMarkTicks(std::vector{row}, {0, 0}, options).value().size());
  }
}

TEST(LitSpans, OfWhatIsNotSweptAtOneSpeedAreRefused) {
  MarkStroke corner = UnevenRow();
  corner.points_mm.push_back({0, 0});
  MarkStroke closed = UnevenRow();
  closed.closed = true;
  auto from_rest = Sweeping(1000);
  from_rest.run_in_s = 0;
  const auto refused = [](const MarkStroke& stroke, const MarkTickOptions& options) {
    const auto ticks = MakeMarkTicks(std::vector{stroke}, {0, 0}, options);
    return ticks ? std::string() : ticks.error().message;
  };
  for (const std::string& error :
       {refused(corner, Sweeping(1000)), refused(closed, Sweeping(1000)),
        refused(UnevenRow(), from_rest)})
    EXPECT_THAT(error, HasSubstr("stroke 1: lit spans need an open stroke"));
}

}  // namespace
}  // namespace intaglio::galvo
