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
    return book_.AddNew(std::move(job));
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

TEST_F(JobBookTest, AMovedJobPrecedesTheNamedOneAndIsKept) {
  for (std::uint32_t number : {1, 2, 3, 4}) Add(number);
  book_.Move(*book_.Find("j4"), "j2");
  EXPECT_THAT(Turn(), testing::ElementsAre(1, 4, 2, 3));
  book_.Move(*book_.Find("j3"), "j1");
  EXPECT_THAT(Turn(), testing::ElementsAre(3, 1, 4, 2));
  book_.Move(*book_.Find("j3"), "");
  EXPECT_THAT(Turn(), testing::ElementsAre(1, 4, 2, 3));
  Add(5);
  EXPECT_THAT(Turn(), testing::ElementsAre(1, 4, 2, 3, 5)) << "behind what was moved";
  // The order outlasts the process.
  EXPECT_EQ(actions_.kept.at("j4").turn, book_.Find("j4")->turn);
  JobBook restored(actions_);
  for (const auto& [uid, job] : book_.jobs()) restored.Add(job);
  std::vector<std::uint32_t> numbers;
  for (const JobRecord* job : restored.InTurn()) numbers.push_back(job->number);
  EXPECT_EQ(numbers, Turn());
}

// However often the same two jobs get another one between them.
TEST_F(JobBookTest, ThereIsAlwaysRoomBetweenTwoJobs) {
  constexpr std::uint32_t kCount = 200;
  for (std::uint32_t number = 1; number <= kCount; ++number) Add(number);
  std::vector<std::uint32_t> expected = {1};
  for (std::uint32_t number = 3; number <= kCount; ++number) {
    book_.Move(*book_.Find(fmt::format("j{}", number)), "j2");
    expected.push_back(number);
  }
  expected.push_back(2);
  EXPECT_EQ(Turn(), expected);
  for (std::uint32_t number = 2; number <= kCount; ++number)
    book_.Move(*book_.Find(fmt::format("j{}", number)), fmt::format("j{}", Turn()[0]));
  for (std::uint32_t i = 0; i < kCount; ++i) expected[i] = kCount - i;
  EXPECT_EQ(Turn(), expected);
}

TEST_F(JobBookTest, AMovedJobTakesThePriorityOfItsNeighbour) {
  Add(1, 5);
  Add(2);
  Add(3, -5);
  book_.Move(*book_.Find("j3"), "j1");
  EXPECT_THAT(Turn(), testing::ElementsAre(3, 1, 2));
  EXPECT_EQ(book_.Find("j3")->priority, 5);
  book_.Move(*book_.Find("j1"), "");
  EXPECT_THAT(Turn(), testing::ElementsAre(3, 2, 1));
  EXPECT_EQ(book_.Find("j1")->priority, 0);
}

TEST_F(JobBookTest, OnlyWhatWaitsForTheSameMachineIsMoved) {
  using testing::HasSubstr;
  JobRecord& first = Add(1);
  JobRecord& second = Add(2);
  Add(3, 0, "another");
  EXPECT_EQ(book_.WhyNotMoved(second, "j1"), "");
  EXPECT_THAT(book_.WhyNotMoved(second, "j3"), HasSubstr("job 3 does not wait for c"));
  EXPECT_THAT(book_.WhyNotMoved(second, "j2"), HasSubstr("before itself"));
  EXPECT_THAT(book_.WhyNotMoved(second, "j9"), HasSubstr("no job j9"));
  book_.Change(first, intaglio_JOB_DISCRETIZING, "");
  EXPECT_THAT(book_.WhyNotMoved(first, ""), HasSubstr("has its machine already"));
  EXPECT_THAT(book_.WhyNotMoved(second, "j1"), HasSubstr("job 1 does not wait for c"));
  book_.Move(second, "");
  EXPECT_THAT(Turn(), testing::ElementsAre(1, 2, 3)) << "nobody else waits for c";
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
