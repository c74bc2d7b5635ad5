#include "services/replayer/cell/cell_comparison.h"

#include <gtest/gtest.h>

#include <cmath>

namespace intaglio::replayer {
namespace {

/// Two points, a tick apart, from this tick on.
CellMessages Sent(std::uint32_t run, std::uint64_t start_tick) {
  CellListener listener("job");
  SegmentMessages segments;
  segments.job_uid = "job";
  segments.run = run;
  segments.start_tick = start_tick;
  segments.last = true;
  for (auto& column : segments.columns) column = {1, 2};
  segments.duration_subticks = {65536, 65536};
  segments.pulse = {1, 1};
  listener.Receive(segments, 10);
  listener.Receive(PulseMessages{"job",
                                 {start_tick + 1, start_tick + 2},
                                 {0, 1},
                                 {intaglio_PULSE_MADE, intaglio_PULSE_MADE},
                                 {0, 0}},
                   20);
  StatusMessage done;
  done.job_uid = "job";
  done.stage = "STAGE_ENGRAVE";
  done.state = "TASK_DONE";
  listener.Receive(done);
  return listener.Messages();
}

TEST(CellComparison, WhenItBeganAndHowOftenDoesNotCount) {
  TaskComparison counts;
  EXPECT_FALSE(CompareCells(Sent(1, 100), Sent(3, 8196), counts));
  EXPECT_EQ(counts.run_count(), 1u);
  EXPECT_EQ(counts.segment_count(), 2u);
  EXPECT_EQ(counts.pulse_count(), 2u);
}

TEST(CellComparison, APauseThatNoPointKnowsOfIsTheHosts) {
  CellMessages then = Sent(1, 100), now = then;
  then.states = {"TASK_ACCEPTED", "TASK_RUNNING", "TASK_DONE"};
  now.states = {"TASK_ACCEPTED", "TASK_RUNNING", "TASK_PAUSED", "TASK_RUNNING",
                "TASK_DONE"};
  TaskComparison counts;
  EXPECT_FALSE(CompareCells(then, now, counts));
  EXPECT_FALSE(CompareCells(now, then, counts));
}

// A newer state takes the place of one that a busy host has not received yet.
TEST(CellComparison, AStateThatWasNotReceivedIsNoDifference) {
  CellMessages then = Sent(1, 100), now = then;
  then.states = {"TASK_ACCEPTED", "TASK_RUNNING", "TASK_DONE"};
  now.states = {"TASK_RUNNING", "TASK_DONE"};
  TaskComparison counts;
  EXPECT_FALSE(CompareCells(then, now, counts));
  EXPECT_FALSE(CompareCells(now, then, counts));
  now.states = {"TASK_RUNNING", "TASK_ACCEPTED", "TASK_DONE"};
  const auto found = CompareCells(then, now, counts);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->member(), "states");
}

// What was made before it counts: another code may hang, too, after it did something
// else.
TEST(CellComparison, OfASynchronizerThatHangsTheRunsBeforeAreCompared) {
  CellMessages then = Sent(1, 100), now = Sent(1, 100);
  then.runs.push_back(Sent(2, 300).runs[0]);
  now.runs.push_back(Sent(2, 300).runs[0]);
  now.runs[1].pulses.pop_back();
  now.end.reset();
  TaskComparison counts;
  CellMessages whole = then, hung = now;
  EXPECT_TRUE(CompareCells(whole, hung, counts)) << "as if it had given another result";
  KeepRunsBefore(1, whole, hung);
  EXPECT_FALSE(CompareCells(whole, hung, counts));
  whole = then, hung = now;
  ++hung.runs[0].pulses[1].tick;
  KeepRunsBefore(1, whole, hung);
  EXPECT_TRUE(CompareCells(whole, hung, counts));
}

TEST(CellComparison, TheLastBitOfAPlaceCounts) {
  const CellMessages then = Sent(1, 100);
  CellMessages now = then;
  now.runs[0].columns[2][1] = std::nextafter(2.0, 3.0);
  TaskComparison counts;
  const auto found = CompareCells(then, now, counts);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->topic(), "MotionSegmentBatch");
  EXPECT_EQ(found->member(), "z_mm");
  EXPECT_EQ(found->index(), 1u);
  EXPECT_EQ(found->run(), 1u);
}

TEST(CellComparison, ATickMoreBetweenPointsCounts) {
  const CellMessages then = Sent(1, 100);
  CellMessages now = Sent(1, 200);
  ++now.runs[0].pulses[1].tick;
  TaskComparison counts;
  const auto found = CompareCells(then, now, counts);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->topic(), "PulseEventBatch");
  EXPECT_EQ(found->member(), "tick");
  EXPECT_EQ(found->then(), "2");
  EXPECT_EQ(found->now(), "3");
  EXPECT_EQ(found->point(), 1u);
}

TEST(CellComparison, AnotherEndAndAMissingRunCount) {
  const CellMessages then = Sent(1, 100);
  CellMessages failed = then, empty = then;
  failed.end->state = "TASK_FAILED";
  empty.runs.clear();
  TaskComparison counts;
  EXPECT_EQ(CompareCells(then, failed, counts)->member(), "state");
  EXPECT_EQ(CompareCells(then, empty, counts)->now(), "none");
}

// How far motion is planned ahead when a person opens the door depends on chance.
TEST(CellComparison, ABrokenRunIsComparedAsFarAsBothPlanned) {
  CellMessages then = Sent(1, 100), now = then;
  for (CellMessages* messages : {&then, &now}) {
    messages->runs[0].whole = false;
    messages->runs[0].aborted = true;
  }
  now.runs[0].duration_subticks.pop_back();
  now.runs[0].pulse.pop_back();
  for (auto& column : now.runs[0].columns) column.pop_back();
  TaskComparison counts;
  EXPECT_FALSE(CompareCells(then, now, counts));
  now.runs[0].pulses.pop_back();  // but not how far it came
  EXPECT_EQ(CompareCells(then, now, counts)->member(), "points");
}

TEST(CellListener, RunsOfWhichNothingWasDecidedAreNotCompared) {
  CellListener listener("job");
  SegmentMessages late;
  late.job_uid = "job";
  late.run = 1;
  late.start_tick = 50;
  EXPECT_TRUE(listener.Receive(late, 5));
  late.abort = true;
  EXPECT_FALSE(listener.Receive(late, 6));
  SegmentMessages again = late;
  again.abort = false;
  again.run = 2;
  again.start_tick = 90;
  EXPECT_TRUE(listener.Receive(again, 7));
  // Taken back of the first run, though its tick lies in the second.
  listener.Receive(
      PulseMessages{
          "job", {95}, {0}, {intaglio_PULSE_SKIPPED}, {intaglio_SKIP_NO_PERMISSION}},
      8);
  listener.Receive(PulseMessages{"job", {91}, {0}, {intaglio_PULSE_MADE}, {0}}, 9);
  const CellMessages messages = listener.Messages();
  ASSERT_EQ(messages.runs.size(), 1u);
  EXPECT_EQ(messages.given_up_count, 1u);
  EXPECT_EQ(messages.runs[0].number, 2u);
  EXPECT_EQ(messages.runs[0].pulses.size(), 1u);
}

// The ticks begin again, and the uncertain points are fired by a person's consent:
// reports from before stay where they were.
TEST(CellListener, RunsBeforeTheUncertainKeepTheirPulses) {
  CellListener listener("job");
  SegmentMessages run;
  run.job_uid = "job";
  const auto begin = [&](std::uint32_t number, std::uint64_t start_tick,
                         std::uint64_t at_ns) {
    run.run = number;
    run.start_tick = start_tick;
    EXPECT_TRUE(listener.Receive(run, at_ns));
  };
  const auto report = [&](std::uint64_t tick, std::uint32_t point, std::uint8_t outcome,
                          std::uint64_t at_ns) {
    listener.Receive(PulseMessages{"job", {tick}, {point}, {outcome}, {0}}, at_ns);
  };
  begin(1, 500, 10);
  report(510, 0, intaglio_PULSE_MADE, 20);
  begin(2, 600, 30);
  report(610, 1, intaglio_PULSE_MADE, 40);
  report(611, 2, intaglio_PULSE_UNCERTAIN, 300'000'000);
  begin(3, 50, 400'000'000);
  report(60, 2, intaglio_PULSE_MADE, 400'000'010);
  const CellMessages messages = listener.Messages();
  ASSERT_EQ(messages.runs.size(), 3u);
  EXPECT_EQ(messages.uncertain_run, 2u);
  for (const CellRun& received : messages.runs) {
    ASSERT_EQ(received.pulses.size(), 1u) << "run " << received.number;
    EXPECT_EQ(received.pulses[0].point, received.number - 1);
  }
}

}  // namespace
}  // namespace intaglio::replayer
