#include "services/replayer/cell/cell_messages.h"

#include <gtest/gtest.h>

namespace intaglio::replayer {
namespace {

recording::Value Status(const std::string& error_code) {
  recording::ValueObject members;
  const auto add = [&members](const char* name, auto value) {
    members.push_back({name, recording::Value{value}});
  };
  add("job_uid", std::string("7-abc"));
  add("attempt", std::uint64_t{2});
  add("stage", std::string("STAGE_ENGRAVE"));
  add("state", std::string("TASK_FAILED"));
  add("error_code", error_code);
  add("message", std::string("a sentence"));
  for (const char* count : {"done_count", "total_count", "estimate_ticks"}) {
    add(count, std::uint64_t{0});
  }
  add("outcome", std::vector<std::uint64_t>{});
  return {members};
}

// Recordings of before have the name of the code, today's the enumerator's.
TEST(CellMessages, AnErrorCodeIsTheSameInRecordingsOfBefore) {
  constexpr std::pair<const char*, const char*> kBeforeAndNow[] = {
      {"", "ERROR_NONE"},
      {"invalid_value", "ERROR_INVALID_VALUE"},
      {"link_lost", "ERROR_LINK_LOST"},
      {"cancelled", "ERROR_CANCELLED"}};
  for (const auto& [before, now] : kBeforeAndNow) {
    const auto then = ReadStatus(Status(before));
    const auto today = ReadStatus(Status(now));
    ASSERT_TRUE(then && today);
    EXPECT_EQ(then->error_code, before);
    EXPECT_EQ(today->error_code, before);
  }
}

TEST(CellMessages, AnErrorCodeOfTheBusIsAsInARecording) {
  intaglio_TaskStatus sample{};
  std::string empty;
  sample.job_uid = sample.worker = sample.message = empty.data();
  sample.error_code = intaglio_ERROR_OUTSIDE_BLOCK;
  EXPECT_EQ(MessageOf(sample).error_code,
            ReadStatus(Status("outside_block"))->error_code);
}

SegmentMessages Segments(std::uint32_t run, std::uint64_t number, bool last = false) {
  SegmentMessages messages;
  messages.job_uid = "7-abc";
  messages.run = run;
  messages.number = number;
  messages.last = last;
  return messages;
}

PulseMessages Pulses(std::uint64_t number) {
  PulseMessages messages;
  messages.job_uid = "7-abc";
  messages.number = number;
  return messages;
}

TEST(CellListener, HasNoGapWhereTheNumbersFollowEachOther) {
  CellListener listener("7-abc");
  listener.Receive(Segments(1, 0), 10);
  listener.Receive(Segments(1, 1, true), 20);
  listener.Receive(Segments(2, 0, true), 30);
  listener.Receive(Pulses(0), 25);
  listener.Receive(Pulses(1), 35);
  EXPECT_EQ(listener.Messages().incomplete_run, 0u);
}

TEST(CellListener, FindsTheRunOfWhichMotionIsMissing) {
  CellListener begin("7-abc"), middle("7-abc"), end("7-abc");
  begin.Receive(Segments(3, 2), 10);  // a recording that was cut in it
  EXPECT_EQ(begin.Messages().incomplete_run, 3u);
  middle.Receive(Segments(1, 0, true), 10);
  middle.Receive(Segments(2, 0), 20);
  middle.Receive(Segments(2, 2, true), 30);
  EXPECT_EQ(middle.Messages().incomplete_run, 2u);
  end.Receive(Segments(1, 0), 10);  // neither its last segment nor an abort
  end.Receive(Segments(2, 0, true), 20);
  EXPECT_EQ(end.Messages().incomplete_run, 1u);
}

TEST(CellListener, FindsTheRunOfWhichPulsesAreMissing) {
  CellListener listener("7-abc");
  listener.Receive(Segments(1, 0, true), 10);
  listener.Receive(Segments(2, 0, true), 30);
  listener.Receive(Pulses(0), 15);
  listener.Receive(Pulses(2), 40);
  EXPECT_EQ(listener.Messages().incomplete_run, 2u);
}

// A run that has not ended yet is no gap: the recording ends in it.
TEST(CellListener, ARecordingMayEndInARun) {
  CellListener listener("7-abc");
  listener.Receive(Segments(1, 0), 10);
  EXPECT_EQ(listener.Messages().incomplete_run, 0u);
}

}  // namespace
}  // namespace intaglio::replayer
