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

}  // namespace
}  // namespace intaglio::replayer
