#include "services/client/shop/job_record.h"

#include <gtest/gtest.h>

namespace intaglio::client {
namespace {

JobView Engraving() {
  JobView job;
  job.uid = "7-abc";
  job.number = 7;
  job.name = "cup";
  job.cell = "left";
  job.state = intaglio_JOB_ENGRAVING;
  job.armed = true;
  job.progress = {{intaglio_STAGE_DISCRETIZE, 1000, 1000, 2},
                  {intaglio_STAGE_SORT, 400, 400, 1},
                  {intaglio_STAGE_ENGRAVE, 100, 400, 0.5}};
  job.estimate_ticks = 420;
  job.rate_hz = 200;
  job.speed_percent = 80;
  job.result_directory = "/jobs/7";
  job.warnings = {MakeWarning(WarningCode::kBreakage, "may break at (1, 2, 3) mm")};
  job.breakage_accepted_by = "anna@shop";
  job.counts = {400, 98, 2, 0, 0, 297, 3};
  job.alarm = "no progress";
  return job;
}

TEST(JobRecord, HasWhatTheShopReportsOfAJob) {
  const JobRecord record = JobRecordOf(Engraving());
  EXPECT_EQ(record.job(), 7u);
  EXPECT_EQ(record.state(), "engraving");
  EXPECT_TRUE(record.armed());
  ASSERT_EQ(record.stages_size(), 3);
  EXPECT_EQ(record.stages(2).stage(), "engrave");
  EXPECT_EQ(record.stages(2).done(), 100u);
  EXPECT_EQ(record.stages(2).rate(), 200);
  EXPECT_EQ(record.estimated_s(), 2.1);
  EXPECT_EQ(record.speed_percent(), 80u);
  EXPECT_EQ(record.result_directory(), "/jobs/7");
  ASSERT_EQ(record.warnings_size(), 1);
  EXPECT_EQ(record.warnings(0).weight(), "consent");
  EXPECT_EQ(record.breakage_accepted_by(), "anna@shop");
  EXPECT_EQ(record.planned(), 400u);
  EXPECT_EQ(record.made(), 98u);
  EXPECT_EQ(record.missed(), 2u);
  EXPECT_EQ(record.verdict(), "") << "it has not ended";
  EXPECT_EQ(record.alarm(), "no progress");
}

TEST(JobRecord, OfAJobThatHasNotBegunHasNoStages) {
  JobView job;
  job.progress = {{intaglio_STAGE_DISCRETIZE, 0, 0, 0}};
  const JobRecord record = JobRecordOf(job);
  EXPECT_EQ(record.stages_size(), 0);
  EXPECT_EQ(record.estimated_s(), 0) << "not known";
}

TEST(JobRecord, JobsAreListedByNumber) {
  JobView early = Engraving(), late = Engraving();
  early.number = 9;
  late.number = 10;
  const JobList list = JobListOf({{"10-a", late}, {"9-b", early}}, {});
  ASSERT_EQ(list.jobs_size(), 2);
  EXPECT_EQ(list.jobs(0).job(), 9u);
}

}  // namespace
}  // namespace intaglio::client
