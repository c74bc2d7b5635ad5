#include "services/job_service/queue/job_book.h"

#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

class JobBookTest : public testing::Test {
 protected:
  JobRecord& Add(std::uint32_t number, std::int32_t priority = 0,
                 const std::string& cell = "c") {
    JobRecord job;
    job.number = number;
    job.uid = fmt::format("j{}", number);
    job.cell = cell;
    job.priority = priority;
    return book_.Add(std::move(job));
  }
  std::vector<std::uint32_t> Turn() {
    std::vector<std::uint32_t> numbers;
    for (const JobRecord* job : book_.InTurn()) numbers.push_back(job->number);
    return numbers;
  }

  RecordingActions actions_;
  JobBook book_{actions_};
};

TEST_F(JobBookTest, TheTurnIsByPriorityAndThenBySubmission) {
  Add(1);
  Add(2, 5);
  Add(3);
  Add(4, 5);
  EXPECT_THAT(Turn(), testing::ElementsAre(2, 4, 1, 3));
}

TEST_F(JobBookTest, AChangeOfStateIsKeptAndAMessageIsNot) {
  JobRecord& job = Add(1);
  book_.Change(job, intaglio_JOB_DISCRETIZING, "begins");
  EXPECT_EQ(actions_.kept.at("j1").revision, 1u);
  book_.Publish(job, intaglio_JOB_DISCRETIZING, "goes on");
  EXPECT_EQ(actions_.kept.at("j1").message, "begins");
  EXPECT_EQ(actions_.progress["j1"], 1);
  EXPECT_EQ(job.revision, 2u) << "every publication has its own";
  book_.Publish(job, intaglio_JOB_SORTING, "");
  EXPECT_EQ(actions_.kept.at("j1").state, intaglio_JOB_SORTING);
}

TEST_F(JobBookTest, APauseReasonIsOfAPausedJobAlone) {
  JobRecord& job = Add(1);
  book_.ChangeToPaused(job, intaglio_PAUSE_INTERLOCK, "the door is open");
  EXPECT_EQ(actions_.kept.at("j1").pause_reason, intaglio_PAUSE_INTERLOCK);
  book_.Change(job, intaglio_JOB_PAUSED, "resumed");
  EXPECT_EQ(job.pause_reason, intaglio_PAUSE_INTERLOCK) << "until it runs";
  for (const auto state : {intaglio_JOB_QUEUED, intaglio_JOB_ENGRAVING, intaglio_JOB_DONE,
                           intaglio_JOB_FAILED, intaglio_JOB_CANCELLED}) {
    book_.ChangeToPaused(job, intaglio_PAUSE_OPERATOR, "");
    book_.Publish(job, state, "");
    EXPECT_EQ(actions_.kept.at("j1").pause_reason, intaglio_PAUSE_NONE) << state;
  }
}

TEST_F(JobBookTest, AnActiveJobTakesItsCell) {
  JobRecord& job = Add(1);
  EXPECT_FALSE(book_.CellIsTaken("c")) << "it waits for it";
  book_.ChangeToPaused(job, intaglio_PAUSE_OPERATOR, "");
  EXPECT_TRUE(book_.CellIsTaken("c"));
  EXPECT_FALSE(book_.CellIsTaken("another"));
  book_.End(job, intaglio_JOB_FAILED, "", 100s);
  EXPECT_FALSE(book_.CellIsTaken("c"));
}

TEST_F(JobBookTest, AnEndedJobIsFoundAndIsNotOpen) {
  JobRecord& job = Add(1);
  EXPECT_EQ(book_.FindOpen("j1"), &job);
  book_.End(job, intaglio_JOB_DONE, "", 100s);
  EXPECT_EQ(book_.FindOpen("j1"), nullptr);
  EXPECT_EQ(book_.Find("j1"), &job);
  EXPECT_EQ(book_.Find("j2"), nullptr);
  book_.Forget(100s);
  EXPECT_THAT(Turn(), testing::IsEmpty());
  EXPECT_EQ(book_.Find("j1"), &job);
}

}  // namespace
}  // namespace intaglio::job_service
