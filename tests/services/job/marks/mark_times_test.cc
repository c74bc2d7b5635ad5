#include "services/job/marks/mark_times.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace intaglio {
namespace {

mark::MarkSet RandomSet(std::size_t repeats, std::mt19937& random) {
  std::uniform_real_distribution<double> place(-20, 20);
  mark::MarkSet set;
  set.pens.push_back({"item 1", 1000, 0.5, 20000, 2});
  for (std::size_t k = 0; k < repeats; ++k) {
    for (int i = 0; i < 30; ++i) {
      const Vec2 a(place(random), place(random));
      set.marks.push_back({0,
                           i % 2 == 0,
                           50.0 * static_cast<double>(k),
                           {{a, 0}, {a + Vec2(1, 0), 0}, {a + Vec2(1, 2), 0}}});
    }
  }
  return set;
}

HeadFigures HeadOf(double field_mm) {
  HeadFigures head;
  head.window = galvo::FieldWindow(field_mm);
  return head;
}

TEST(MarkTimes, AddUpMarksJumpsAndDelays) {
  mark::MarkSet set;
  set.pens.push_back({"pen", 100, 0.5, 20000, 3});
  set.marks.push_back({0, false, 0, {{{0, 0}, 0}, {{10, 0}, 0}}});
  set.marks.push_back({0, true, 0, {{{10, 5}, 0}, {{10, 10}, 0}, {{10, 7}, 0}}});
  HeadFigures head = HeadOf(100);
  head.ticks.jump_mm_s = 1000;
  head.ticks.run_in_s = 0;
  head.ticks.jump_delay_s = head.ticks.mark_delay_s = 0.0005;
  const MarkTimes times = TimesOf(set, head);
  EXPECT_NEAR(times.mark_mm, 30 + 30, 1e-12);
  EXPECT_NEAR(times.jump_mm, 5, 1e-12);
  // Three passes of 0.1 s with a delay behind each and two ways back of 10 mm with
  // theirs, a jump with its, and three rounds of 0.1 s; ticks of rounding.
  EXPECT_NEAR(times.time_s, 0.3 + 0.0015 + 0.02 + 0.001 + 0.005 + 0.0005 + 0.3 + 0.0015,
              2e-4);
}

// What the driver sends, mark by mark, each from where the mirrors rest behind the one
// before.
TEST(MarkTimes, AreThoseOfTheTicks) {
  std::mt19937 random(5);
  const mark::MarkSet set = RandomSet(1, random);
  HeadFigures head = HeadOf(100);
  head.ticks.lag_s = 2e-4;
  head.ticks.lead_servo = true;
  galvo::MarkTickOptions options = head.ticks;
  options.mark_mm_s = set.pens[0].speed_mm_s;
  Vec2 at_mm = set.marks.front().places.front().at_mm;
  std::size_t count = 0;
  const auto timed = TimedMarksOf(set, head);
  for (std::size_t i = 0; i < set.marks.size(); ++i) {
    galvo::MarkStroke stroke{mark::PlacesOf(set.marks[i], 1e-4), set.marks[i].closed};
    const auto ticks =
        galvo::MakeMarkTicks(std::vector{stroke, stroke}, at_mm, options).value();
    EXPECT_NEAR(timed[i].time_s, static_cast<double>(ticks.size()) / options.rate_hz,
                1e-12);
    at_mm = ticks.back().place_mm;
    count += ticks.size();
  }
  EXPECT_NEAR(TimesOf(set, head).time_s, static_cast<double>(count) / options.rate_hz,
              1e-9);
}

TEST(MarkTimes, TheOrderForAWebIsAtLeastAsFastAsThatOfTheJob) {
  std::mt19937 random(3);
  const HeadFigures head = HeadOf(60);
  const mark::MarkSet set = RandomSet(8, random);
  const auto ordered = OrderForWeb(set, head, true);
  ASSERT_TRUE(ordered) << ordered.error().message;
  ASSERT_EQ(ordered->marks.size(), set.marks.size());
  const auto fast = galvo::MaxSpeed(TimedMarksOf(*ordered, head), head.web_field_mm());
  ASSERT_TRUE(fast) << fast.error().message;
  const auto as_given = galvo::MaxSpeed(TimedMarksOf(set, head), head.web_field_mm());
  EXPECT_TRUE(!as_given || *fast > *as_given);
  EXPECT_TRUE(
      galvo::MissedMarks(TimedMarksOf(*ordered, head), head.web_field_mm(), 0.999 * *fast)
          .empty());
  EXPECT_FALSE(
      galvo::MissedMarks(TimedMarksOf(*ordered, head), head.web_field_mm(), 1.02 * *fast)
          .empty());
}

// Places of a web that runs at the speed: all of a mark is in the field while it is made.
TEST(MarkTimes, EveryMarkLiesInTheFieldWhileItIsMade) {
  std::mt19937 random(4);
  const HeadFigures head = HeadOf(60);
  const auto ordered = OrderForWeb(RandomSet(6, random), head, true);
  ASSERT_TRUE(ordered);
  const auto timed = TimedMarksOf(*ordered, head);
  const double speed = 0.98 * galvo::MaxSpeed(timed, head.web_field_mm()).value();
  double now_s = 0;
  for (std::size_t i = 0; i < timed.size(); ++i) {
    double low = 1e9, high = -1e9;
    for (const mark::Place& p : ordered->marks[i].places) {
      low = std::min(low, p.at_mm.x() - ordered->marks[i].web_mm);
      high = std::max(high, p.at_mm.x() - ordered->marks[i].web_mm);
    }
    // The web has run by speed * now_s since its first frame was in the middle; it waits
    // for none.
    const double enters_s = (-head.web_field_mm() / 2 - low) / speed;
    now_s = i == 0 ? enters_s : std::max(now_s, enters_s);
    now_s += timed[i].time_s;
    EXPECT_LE(high + speed * now_s, head.web_field_mm() / 2 + 1e-6) << i;
  }
}

TEST(MarkTimes, WhatDoesNotFitIntoTheFieldIsNamed) {
  mark::MarkSet set;
  set.pens.push_back({"item 2", 100, 0.5, 20000, 1});
  set.marks.push_back({0, false, 700, {{{0, 0}, 0}, {{40, 0}, 0}}});
  EXPECT_TRUE(CheckField(set, true, HeadOf(60.5)));
  const auto outside = CheckField(set, false, HeadOf(60));
  ASSERT_FALSE(outside);
  EXPECT_EQ(outside.error().code, ErrorCode::kOutsideBlock);
  EXPECT_EQ(outside.error().message,
            "marks.item 2: mark 1 lies in x 0..40, y 0..0 mm and does not fit into the "
            "field of 60 mm; move it, make it smaller or use a larger field");
  EXPECT_FALSE(CheckField(set, true, HeadOf(30)));
}

TEST(MarkTimes, AnOrderCountsMarksAndEndsWhenItIsAskedTo) {
  std::mt19937 random(3);
  const HeadFigures head = HeadOf(60);
  const mark::MarkSet set = RandomSet(4, random);
  std::vector<std::uint64_t> done;
  const ProgressSink sink = [&](std::uint64_t marks, std::uint64_t total) {
    done.push_back(marks);
    EXPECT_EQ(total, set.marks.size());
    return true;
  };
  ASSERT_TRUE(OrderForWeb(set, head, true, sink));
  // Behind the last repeat its bar stays full while the order of all is chosen.
  ASSERT_GT(done.size(), 4U);
  EXPECT_TRUE(std::all_of(done.begin() + 4, done.end(),
                          [](std::uint64_t marks) { return marks == 120; }));
  done.resize(4);
  EXPECT_EQ(done, (std::vector<std::uint64_t>{0, 30, 60, 90}));
  const auto ended = OrderForWeb(
      set, head, true, [&](std::uint64_t marks, std::uint64_t) { return marks < 60; });
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, ErrorCode::kCancelled);
  const auto ended_late = OrderForWeb(
      set, head, true, [&](std::uint64_t marks, std::uint64_t) { return marks < 120; });
  ASSERT_FALSE(ended_late);
  EXPECT_EQ(ended_late.error().code, ErrorCode::kCancelled);
}

}  // namespace
}  // namespace intaglio
