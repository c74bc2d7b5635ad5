#include "services/history/day_sums.h"

#include <gtest/gtest.h>

namespace intaglio::history {
namespace {

JobStatistics Job(const std::string& cell, const std::string& ended_utc,
                  const std::string& verdict) {
  JobStatistics job;
  job.set_cell(cell);
  job.set_ended_utc(ended_utc);
  job.set_verdict(verdict);
  return job;
}

TEST(DaySums, CountPiecesByDayMachineAndVerdict) {
  DaySums sums;
  sums.Add(Job("right", "2026-11-21T08:00:00.000Z", "good"));
  sums.Add(Job("left", "2026-11-21T23:59:59.999Z", "good"));
  sums.Add(Job("left", "2026-11-22T00:00:00.000Z", "good"));
  sums.Add(Job("left", "2026-11-22T10:00:00.000Z", "good_with_warnings"));
  sums.Add(Job("left", "2026-11-22T11:00:00.000Z", "not_good"));
  sums.Add(Job("left", "2026-11-22T12:00:00.000Z", "none"));
  sums.Add(Job("left", "2026-11-22T13:00:00.000Z", "unknown"));
  sums.Add(Job("left", "", ""));
  const auto rows = sums.Rows();
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].day() + rows[0].cell(), "2026-11-21left");
  EXPECT_EQ(rows[1].day() + rows[1].cell(), "2026-11-21right");
  EXPECT_EQ(rows[2].day(), "2026-11-22");
  EXPECT_EQ(rows[2].pieces(), 5u) << "an open job is no piece";
  for (const auto count : {rows[2].good(), rows[2].good_with_warnings(),
                           rows[2].not_good(), rows[2].none(), rows[2].unknown()})
    EXPECT_EQ(count, 1u);
}

TEST(DaySums, DivideTheTimeOfAJob) {
  DaySums sums;
  JobStatistics job = Job("left", "2026-11-21T08:30:00.000Z", "good");
  job.set_started_utc("2026-11-21T08:00:00.000Z");
  job.set_engraving_utc("2026-11-21T08:10:00.000Z");
  job.set_machining_s(15 * 60);
  job.set_planned(200);
  job.set_made(199);
  sums.Add(job);
  // One that was cancelled before it fired.
  job.clear_engraving_utc();
  job.clear_machining_s();
  sums.Add(job);
  const auto rows = sums.Rows();
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].preparing_s(), (10 + 30) * 60);
  EXPECT_EQ(rows[0].engraving_s(), 15 * 60);
  EXPECT_EQ(rows[0].interrupted_s(), 5 * 60);
  EXPECT_EQ(rows[0].planned(), 400u);
  EXPECT_EQ(rows[0].made(), 398u);
}

}  // namespace
}  // namespace intaglio::history
