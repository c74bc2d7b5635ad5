#include "services/client/shop/queue_time.h"

#include <gtest/gtest.h>

namespace intaglio::client {
namespace {

constexpr std::chrono::system_clock::time_point kMidnight{};

JobView Job(const std::string& cell, intaglio_JobState state,
            std::uint64_t estimate_ticks = 0) {
  JobView job;
  job.cell = cell;
  job.state = state;
  job.estimate_ticks = estimate_ticks;
  job.rate_hz = 100;
  return job;
}

JobView Engraved(std::uint64_t done, double elapsed_s, std::uint64_t estimate_ticks) {
  JobView job = Job("left", intaglio_JOB_ENGRAVING, estimate_ticks);
  job.progress = {{intaglio_STAGE_SORT, 400, 400, 1},
                  {intaglio_STAGE_ENGRAVE, done, 400, elapsed_s}};
  return job;
}

TEST(QueueTime, IsTheSumOfWhatIsLeftAndOfTheEstimates) {
  // 100 of 400 in 50 s: 150 s are left at this pace, whatever the plan says.
  const auto queues =
      QueueTimesOf({Engraved(100, 50, 99'900), Job("left", intaglio_JOB_QUEUED, 6'000),
                    Job("left", intaglio_JOB_DONE, 70'000)},
                   kMidnight);
  ASSERT_EQ(queues.size(), 1u);
  EXPECT_EQ(queues[0].cell(), "left");
  EXPECT_EQ(queues[0].jobs(), 2u);
  EXPECT_EQ(queues[0].unknown_jobs(), 0u);
  EXPECT_EQ(queues[0].left_s(), 150 + 60);
  EXPECT_EQ(queues[0].ends_utc(), "1970-01-01T00:03:30.000Z");
}

TEST(QueueTime, AJobWithoutAnEstimateIsCountedAndNotTakenForNothing) {
  const auto queues = QueueTimesOf(
      {Job("left", intaglio_JOB_QUEUED), Job("left", intaglio_JOB_QUEUED, 6'000),
       Job("right", intaglio_JOB_DISCRETIZING)},
      kMidnight);
  ASSERT_EQ(queues.size(), 2u);
  EXPECT_EQ(queues[0].jobs(), 2u);
  EXPECT_EQ(queues[0].unknown_jobs(), 1u);
  EXPECT_EQ(queues[0].left_s(), 60);
  EXPECT_EQ(queues[1].cell(), "right");
  EXPECT_EQ(queues[1].unknown_jobs(), 1u);
  EXPECT_EQ(queues[1].left_s(), 0);
  EXPECT_EQ(queues[1].ends_utc(), "") << "nobody knows";
}

TEST(QueueTime, APauseTakesNoTimeAndItsJobTheRestOfItsPlan) {
  JobView job = Engraved(100, 50, 10'000);
  job.state = intaglio_JOB_PAUSED;
  EXPECT_EQ(MachineSecondsLeft(job), 75) << "three quarters of 100 s";
  job.speed_percent = 50;
  EXPECT_EQ(MachineSecondsLeft(job), 150);
}

TEST(QueueTime, AnAbsurdEstimateOverflowsNoClock) {
  const auto queues =
      QueueTimesOf({Job("left", intaglio_JOB_QUEUED, std::uint64_t(-1))}, kMidnight);
  ASSERT_EQ(queues.size(), 1u);
  EXPECT_EQ(queues[0].left_s(), 1e8);
}

}  // namespace
}  // namespace intaglio::client
