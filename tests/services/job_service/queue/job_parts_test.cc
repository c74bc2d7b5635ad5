#include "services/job_service/records/job_parts.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "services/platform/host/stage/task_part.h"

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

JobParts CutFor(std::size_t discretizers) {
  JobParts parts;
  parts.Cut(discretizers, 100s);
  return parts;
}

TEST(JobParts, AsManyAsTheDiscretizersNeed) {
  EXPECT_EQ(CutFor(0).size(), 1u);
  EXPECT_EQ(CutFor(1).size(), 1u);
  EXPECT_EQ(CutFor(2).size(), 16u);
  EXPECT_EQ(CutFor(1000).size(), host::kMaxParts);
  EXPECT_THROW((void)CutFor(1).at(1), std::out_of_range);
}

TEST(JobParts, AreGivenInTheirOrder) {
  JobParts parts = CutFor(2);
  EXPECT_EQ(parts.NextOpen(100s), 0u);
  parts.Give(0, "a");
  parts.Give(1, "b");
  EXPECT_EQ(parts.NextOpen(100s), 2u);
  parts.Finish(0);
  EXPECT_EQ(parts.NextOpen(100s), 2u) << "a done part stays done";
}

TEST(JobParts, AReportCountsOfTheWorkerAndTheNewestAttemptAlone) {
  JobParts parts = CutFor(2);
  parts.Give(0, "a");
  EXPECT_TRUE(parts.IsCurrent("a", 0, 0));
  EXPECT_FALSE(parts.IsCurrent("b", 0, 0));
  EXPECT_FALSE(parts.IsCurrent("a", 0, 1));
  EXPECT_FALSE(parts.IsCurrent("a", 1, 0));
  EXPECT_FALSE(parts.IsCurrent("a", 16, 0)) << "there is no such part";
  parts.Lose(0, "a was lost", 100s);
  EXPECT_FALSE(parts.IsCurrent("a", 0, 0));
  parts.Give(0, "a");
  EXPECT_FALSE(parts.IsCurrent("a", 0, 0)) << "about the lost attempt";
  EXPECT_TRUE(parts.IsCurrent("a", 0, 1));
  parts.Finish(0);
  EXPECT_FALSE(parts.IsCurrent("a", 0, 1));
}

TEST(JobParts, ALostOneWaitsAndCountsItsLossesUnlessItWasGivenAhead) {
  JobParts parts = CutFor(2);
  parts.Give(0, "a");
  parts.Give(1, "a");
  parts.Lose(0, "a was lost", 102s);
  parts.LoseAhead(1);
  EXPECT_EQ(parts[0].losses, 1u);
  EXPECT_EQ(parts[1].losses, 0u);
  EXPECT_EQ(parts[0].attempt, 1u);
  EXPECT_EQ(parts[1].attempt, 1u) << "its number is used up";
  EXPECT_EQ(parts.last_loss(), "part 1 of 16 starts again: a was lost");
  EXPECT_EQ(parts.NextOpen(101s), 1u);
  EXPECT_EQ(parts.NextOpen(102s), 0u);
}

// k of n open parts stay for k workers, for when each has ended what it has.
TEST(JobParts, NoneIsGivenAheadTowardsTheEnd) {
  JobParts parts = CutFor(2);
  parts.Give(0, "a");
  parts.Give(1, "b");
  std::uint32_t ahead = 0;
  while (const auto next = parts.NextAhead()) {
    parts.Give(*next, "a");
    ++ahead;
  }
  EXPECT_EQ(ahead, 16u - 2u - 2u);
}

TEST(JobParts, ALostOneIsNotGivenAhead) {
  JobParts parts = CutFor(2);
  parts.Give(0, "a");
  parts.Lose(0, "a was lost", 100s);
  EXPECT_EQ(parts.NextAhead(), 1u);
}

TEST(JobParts, LessThanAllIsDoneUntilTheLastIs) {
  JobParts parts = CutFor(2);
  for (std::uint32_t i = 0; i < 16; ++i) {
    parts.Give(i, "a");
    parts.SetProgress(i, 7, 7);
    const auto progress = parts.ProgressAt(103s);
    EXPECT_LT(progress.done_count, progress.total_count) << i;
    EXPECT_EQ(progress.elapsed_s, 3.0);
    EXPECT_FALSE(parts.all_done());
    if (i < 15) parts.Finish(i);
  }
  parts.Finish(15);
  EXPECT_TRUE(parts.all_done());
  EXPECT_EQ(parts.ProgressAt(103s).done_count, 16u * 7u) << "of points, now";
  EXPECT_EQ(parts.ProgressAt(103s).total_count, 16u * 7u);
}

// By hand: three of sixteen parts done, one half done.
TEST(JobParts, ProgressIsTheShareOfTheWork) {
  JobParts parts = CutFor(2);
  for (std::uint32_t i = 0; i < 3; ++i) parts.Finish(i);
  parts.SetProgress(3, 50, 100);
  const auto progress = parts.ProgressAt(100s);
  EXPECT_DOUBLE_EQ(static_cast<double>(progress.done_count) /
                       static_cast<double>(progress.total_count),
                   3.5 / 16);
}

TEST(JobParts, OfAnEarlierRunAreAtWork) {
  JobParts parts;
  parts.Restore(2, 4, "a");
  EXPECT_EQ(parts.size(), 3u);
  EXPECT_TRUE(parts.any_at_work());
  EXPECT_TRUE(parts.IsCurrent("a", 2, 4));
  EXPECT_EQ(parts.NextOpen(0s), 0u);
}

}  // namespace
}  // namespace intaglio::job_service
