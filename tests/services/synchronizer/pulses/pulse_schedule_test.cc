#include "services/synchronizer/pulses/pulse_schedule.h"

#include <gtest/gtest.h>

#include <map>
#include <random>

#include "engrave/core/check.h"

namespace intaglio::synchronizer {
namespace {

using formats::PointOutcome;
using link::PulseReport;
using link::TickOutcome;

struct Recorder {
  std::map<std::uint32_t, PulseResult> results;
  PulseSchedule::ResultSink sink() {
    return [this](const PulseResult& result) {
      EXPECT_TRUE(results.emplace(result.point, result).second)
          << "point " << result.point << " has two results";
    };
  }
};

const auto kIgnoreArmed = [](std::uint64_t, std::uint32_t) {};
const auto kNoLate = [](std::uint32_t point) { ADD_FAILURE() << point << " is late"; };

TEST(PulseSchedule, DecidesOnlyAsManyPointsAsMayBeUnsettled) {
  PulseSchedule schedule;
  Recorder recorder;
  for (std::uint32_t i = 0; i < 10; ++i) schedule.Add(10 + 3 * i, i);
  EXPECT_EQ(schedule.LastTickFor(4), 21u) << "up to before the fifth, of tick 22";
  schedule.Decide(1, 21, kIgnoreArmed, kNoLate);
  EXPECT_EQ(schedule.armed_count(), 4u);
  EXPECT_EQ(schedule.LastTickFor(4), 21u);
  schedule.Apply(PulseReport{10, {TickOutcome::kFiredSeen}}, recorder.sink());
  EXPECT_EQ(schedule.LastTickFor(4), 24u);
  EXPECT_EQ(schedule.LastTickFor(9), UINT64_MAX) << "no more are planned";
}

TEST(PulseSchedule, TicksOfPointsThatAreAlikeEndBeforeTheFirstThatIsNot) {
  PulseSchedule schedule;
  for (const std::uint32_t tick : {10, 12, 15, 20}) schedule.Add(tick, tick);
  const auto through = [&](std::uint64_t first, std::uint64_t last) {
    const auto alike = schedule.AlikeFrom(
        first, last, [](std::uint32_t point) { return point < 15 ? 2.0 : 3.0; });
    return std::pair(alike.last, alike.value);
  };
  EXPECT_EQ(through(8, 30), std::pair(std::uint64_t{14}, 2.0));
  EXPECT_EQ(through(8, 13), std::pair(std::uint64_t{13}, 2.0));
  EXPECT_EQ(through(13, 30), std::pair(std::uint64_t{30}, 3.0)) << "12 is too late";
  EXPECT_EQ(through(21, 30), std::pair(std::uint64_t{30}, 0.0)) << "no point";
  schedule.Decide(8, 14, kIgnoreArmed, kNoLate);
  EXPECT_EQ(through(15, 19), std::pair(std::uint64_t{19}, 3.0));
}

TEST(PulseSchedule, WindowFiresExactlyThePlannedTicks) {
  PulseSchedule schedule;
  schedule.Add(10, 0);
  schedule.Add(12, 1);
  schedule.Add(15, 2);
  const auto window = schedule.Decide(8, 14, kIgnoreArmed, kNoLate);
  EXPECT_EQ(window.first_tick, 8u);
  EXPECT_EQ(window.fire, (std::vector<bool>{0, 0, 1, 0, 1, 0, 0}));
  EXPECT_TRUE(window.gated);
  EXPECT_EQ(schedule.armed_count(), 2u);
}

TEST(PulseSchedule, PointsPlannedForPassedTicksAreLateNotArmed) {
  PulseSchedule schedule;
  schedule.Add(10, 0);
  schedule.Add(12, 1);
  std::vector<std::uint32_t> late;
  const auto window = schedule.Decide(
      11, 12, kIgnoreArmed, [&](std::uint32_t point) { late.push_back(point); });
  EXPECT_EQ(late, std::vector<std::uint32_t>{0});
  EXPECT_EQ(window.fire, (std::vector<bool>{0, 1}));
}

TEST(PulseSchedule, LateReportOutOfOrderSettlesItsPointAlone) {
  PulseSchedule schedule;
  Recorder recorder;
  for (std::uint32_t i = 0; i < 4; ++i) schedule.Add(10 + i, i);
  schedule.Decide(10, 13, kIgnoreArmed, kNoLate);
  schedule.Apply(PulseReport{12, {TickOutcome::kTooLate}}, recorder.sink());
  EXPECT_EQ(recorder.results.at(2).reason, SkipReason::kLate);
  schedule.Apply(PulseReport{10, {TickOutcome::kFiredSeen, TickOutcome::kFiredUnseen}},
                 recorder.sink());
  EXPECT_EQ(recorder.results.at(0).outcome, PointOutcome::kMade);
  EXPECT_EQ(recorder.results.at(1).outcome, PointOutcome::kMissed);
  EXPECT_EQ(schedule.front_tick(), 13u);
}

TEST(PulseSchedule, ReportsOfTicksNobodyArmedChangeNothing) {
  PulseSchedule schedule;
  Recorder recorder;
  schedule.Add(10, 0);
  schedule.Apply(PulseReport{9, {TickOutcome::kFiredSeen, TickOutcome::kFiredSeen}},
                 recorder.sink());
  EXPECT_TRUE(recorder.results.empty()) << "tick 10 was planned, not armed";
}

// Random plans, windows and reports: every armed point gets exactly one result, and it
// is the one that the controller gave to its tick.
TEST(PulseSchedule, EveryArmedPointGetsItsOwnResultOnce) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    PulseSchedule schedule;
    Recorder recorder;
    std::map<std::uint64_t, std::uint32_t> plan;
    std::uint64_t tick = 100;
    for (std::uint32_t i = 0; i < 200; ++i) {
      tick += 1 + random() % 4;
      plan[tick] = i;
      schedule.Add(tick, i);
    }
    std::map<std::uint64_t, TickOutcome> truth;
    for (std::uint64_t first = 100; first <= tick;) {
      const std::uint64_t last = std::min(tick, first + random() % 20);
      const auto window = schedule.Decide(first, last, kIgnoreArmed, kNoLate);
      PulseReport report{first, {}};
      for (std::size_t i = 0; i < window.fire.size(); ++i) {
        EXPECT_EQ(window.fire[i], plan.contains(first + i));
        report.outcome.push_back(window.fire[i]
                                     ? static_cast<TickOutcome>(1 + random() % 6)
                                     : TickOutcome::kNotArmed);
        truth[first + i] = report.outcome.back();
      }
      schedule.Apply(report, recorder.sink());
      first = last + 1;
    }
    EXPECT_TRUE(schedule.empty());
    ASSERT_EQ(recorder.results.size(), plan.size());
    for (const auto& [at, point] : plan) {
      EXPECT_EQ(recorder.results.at(point).tick, at);
      EXPECT_EQ(recorder.results.at(point).outcome == PointOutcome::kMade,
                truth.at(at) == TickOutcome::kFiredSeen);
    }
  }
}

TEST(PulseSchedule, DropUnarmedKeepsTheArmed) {
  PulseSchedule schedule;
  Recorder recorder;
  for (std::uint32_t i = 0; i < 4; ++i) schedule.Add(10 + i, i);
  schedule.Decide(10, 11, kIgnoreArmed, kNoLate);
  schedule.DropUnarmed();
  auto open = schedule.ArmedWithin(0, UINT64_MAX);
  ASSERT_EQ(open.size(), 2u);
  for (auto& result : open) result.outcome = PointOutcome::kSkipped;
  schedule.Settle(open, recorder.sink());
  EXPECT_TRUE(schedule.empty());
  EXPECT_EQ(schedule.armed_count(), 0u);
}

TEST(PulseSchedule, TicksMustGrow) {
  PulseSchedule schedule;
  schedule.Add(10, 0);
  EXPECT_THROW(schedule.Add(10, 1), PreconditionError);
}

}  // namespace
}  // namespace intaglio::synchronizer
