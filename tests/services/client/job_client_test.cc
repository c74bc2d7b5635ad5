// Clients of the real job service, whose workers are played by the test.

#include "services/client/job_client.h"

#include <gmock/gmock.h>

#include <optional>
#include <thread>

#include "services/cli/batch/batch_run.h"
#include "services/client/arm_once.h"
#include "services/client/event_lines.h"
#include "services/client/known_jobs.h"
#include "tests/services/client/job_client_rig.h"
#include "tests/services/job/test_job.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;
using job_service::FakeShop;
using job_service::ServiceProcess;
using job_service::TaskCopy;
using ::testing::HasSubstr;

/// Short numbers of the jobs that wait, in their order.
std::vector<std::uint32_t> Waiting(const JobClient& client) {
  std::map<std::uint32_t, std::uint32_t> by_place;
  for (const auto& [uid, job] : client.jobs())
    if (job.queue_place > 0) by_place[job.queue_place] = job.number;
  std::vector<std::uint32_t> numbers;
  for (const auto& [place, number] : by_place) numbers.push_back(number);
  return numbers;
}

TEST_F(JobClientTest, AMovedJobKeepsItsPlaceWhenTheJobServiceIsKilled) {
  Start();
  std::vector<JobView> jobs;
  for (int i = 0; i < 3; ++i) {
    const auto job = ann_.Submit(GoodJob(), 10s);
    ASSERT_TRUE(job.has_value()) << job.error().message;
    jobs.push_back(*job);
  }
  const auto waits = [&](const std::vector<std::uint32_t>& expected) {
    return bob_.PollUntil([&] { return Waiting(bob_) == expected; }, 20s);
  };
  EXPECT_TRUE(waits({1, 2, 3}));
  const JobOrder first{.kind = intaglio_COMMAND_MOVE, .before_job_uid = jobs[0].uid};
  ASSERT_TRUE(ann_.Command(jobs[2], first).has_value());
  EXPECT_TRUE(waits({3, 1, 2}));
  service_.emplace(folder_, test::PrivateTag());  // the one before is killed
  EXPECT_TRUE(waits({3, 1, 2}));
  shop_.ready = true;
  EXPECT_TRUE(waits({1, 2})) << "the first one has its machine";
  EXPECT_NE(bob_.jobs().at(jobs[2].uid).state, intaglio_JOB_QUEUED);
  const auto late =
      ann_.Command(bob_.jobs().at(jobs[1].uid),
                   {.kind = intaglio_COMMAND_MOVE, .before_job_uid = jobs[2].uid});
  ASSERT_FALSE(late.has_value());
  EXPECT_EQ(late.error().value, "out_of_range");
  EXPECT_THAT(late.error().message, HasSubstr("job 3 does not wait for"));
}

TEST_F(JobClientTest, WaitsForTheAnswerToItsOwnCommand) {
  Start();
  const auto job = ann_.Submit(GoodJob(), 10s);
  ASSERT_TRUE(job.has_value());
  const auto early = ann_.Command(*job, {.kind = intaglio_COMMAND_ARM});
  ASSERT_FALSE(early.has_value());
  EXPECT_EQ(early.error().code, ErrorCode::kRefused);
  EXPECT_THAT(early.error().message, HasSubstr("cannot be armed yet"));
  shop_.ready = true;
  OfBob(job->uid);
  const JobView seen = BobAwaits(job->uid, [](const JobView& view) {
    return view.state == intaglio_JOB_WAITING_FOR_ARM;
  });
  // Both act on the same status; bob's command does not take the place of ann's.
  const auto arm = ann_.Send(seen, {.kind = intaglio_COMMAND_ARM});
  const auto pause = bob_.Send(seen, {.kind = intaglio_COMMAND_PAUSE});
  ASSERT_TRUE(arm && pause);
  EXPECT_TRUE(ann_.PollUntil([&] { return ann_.AnswerTo(*arm).has_value(); }, 10s));
  EXPECT_TRUE(bob_.PollUntil([&] { return bob_.AnswerTo(*pause).has_value(); }, 10s));
  EXPECT_TRUE(bob_.AnswerTo(*pause)->taken());
  const JobView paused =
      BobAwaits(job->uid, [](const JobView& view) { return view.disarm_count == 1; });
  EXPECT_FALSE(paused.armed);
  EXPECT_THAT(paused.disarm_reason, HasSubstr("paused by"));
  const auto superseded = ann_.Command(seen, {.kind = intaglio_COMMAND_ARM});
  ASSERT_FALSE(superseded.has_value());
  EXPECT_THAT(superseded.error().message, HasSubstr("was disarmed meanwhile (paused by"));
  EXPECT_TRUE(bob_.Command(paused, {.kind = intaglio_COMMAND_ARM}).has_value());
  EXPECT_TRUE(bob_.Command(paused, {.kind = intaglio_COMMAND_SPEED, .speed_percent = 40})
                  .has_value());
  BobAwaits(job->uid, [](const JobView& view) { return view.speed_percent == 40; });
}

TEST_F(JobClientTest, AClientThatComesLaterKnowsAllJobsAndWaitsNoLonger) {
  Start();
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(ann_.Submit(GoodJob(), 10s).has_value());
  bus::Bus bus(test::PrivateBusOptions());
  JobClient carol(bus);
  EXPECT_TRUE(PollUntilJobsAreKnown(carol, 20s));
  EXPECT_EQ(carol.jobs().size(), 20U);
}

// A job service is on the bus before it has read its queue. The first list that succeeds
// has all of it.
TEST_F(JobClientTest, TheFirstListAfterTheStartOfAJobServiceIsWhole) {
  Start();
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(ann_.Submit(GoodJob(), 10s).has_value());
  for (int start = 0; start < 3; ++start) {
    service_->Kill();
    // Its lease ends, so that the next one is the only one that is seen.
    ASSERT_TRUE(ann_.PollUntil([&] { return ann_.services().empty(); }, 20s));
    bus::Bus bus(test::PrivateBusOptions());
    JobClient carol(bus);
    carol.PollUntil([] { return false; }, 500ms);
    Start();
    EXPECT_TRUE(PollUntilJobsAreKnown(carol, 20s));
    EXPECT_EQ(carol.jobs().size(), 20U);
  }
}

// What came into the glass after the cancel is known when the machine has reported it.
TEST_F(JobClientTest, ACancelledJobHasItsVerdictWhenItsCountsAreSettled) {
  Start();
  FakeShop shop(test::PrivateBusOptions());
  const auto job = ann_.Submit(GoodJob(), 10s);
  ASSERT_TRUE(job.has_value());
  const auto of_job = [&](intaglio_Stage stage) {
    return shop.Task(stage).job_uid == job->uid;
  };
  ASSERT_TRUE(shop.Until([&] {
    shop.Health(intaglio_STAGE_DISCRETIZE, "d", intaglio_HEALTH_READY);
    shop.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_READY);
    shop.Health(intaglio_STAGE_ENGRAVE, "y", intaglio_HEALTH_READY);
    return of_job(intaglio_STAGE_DISCRETIZE) && of_job(intaglio_STAGE_SORT) &&
           of_job(intaglio_STAGE_ENGRAVE);
  }));
  for (const auto stage : {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT})
    shop.Report(shop.Task(stage), stage, intaglio_TASK_DONE, 392, 392);
  const TaskCopy task = shop.Task(intaglio_STAGE_ENGRAVE);
  shop.Report(task, intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, 392);
  ASSERT_TRUE(ann_.PollUntil(
      [&] { return ann_.jobs().at(job->uid).state == intaglio_JOB_WAITING_FOR_ARM; },
      10s));
  ASSERT_TRUE(
      ann_.Command(ann_.jobs().at(job->uid), {.kind = intaglio_COMMAND_ARM}).has_value());
  ASSERT_TRUE(shop.Until([&] { return shop.granted(); }));
  shop.Report(task, intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 20, 392);
  ASSERT_TRUE(ann_.PollUntil(
      [&] { return ann_.jobs().at(job->uid).state == intaglio_JOB_ENGRAVING; }, 10s));
  ASSERT_TRUE(ann_.Command(ann_.jobs().at(job->uid), {.kind = intaglio_COMMAND_CANCEL})
                  .has_value());
  ASSERT_TRUE(ann_.PollUntil([&] { return ann_.jobs().at(job->uid).ended(); }, 10s));
  EXPECT_EQ(ann_.jobs().at(job->uid).verdict, "") << "its machine still fires";
  StageOutcome outcome;
  outcome.mutable_engrave()->set_planned_count(392);
  outcome.mutable_engrave()->set_made_count(69);
  outcome.mutable_engrave()->set_skipped_count(323);
  shop.Report(task, intaglio_STAGE_ENGRAVE, intaglio_TASK_FAILED, 69, 392,
              intaglio_ERROR_CANCELLED, "", outcome);
  const JobEnd end = EndOf(ann_, ann_.jobs().at(job->uid));
  EXPECT_EQ(end.counts.made, 69U);
  EXPECT_EQ(end.verdict.verdict, VerdictKind::kNotGood);
  EXPECT_EQ(end.verdict.reason, "of 392 points 323 skipped");
}

TEST_F(JobClientTest, TheSameKeyWithTheSameJobIsTheSameJob) {
  Start();
  const auto first = ann_.Submit(GoodJob(), 10s, "order-7");
  ASSERT_TRUE(first.has_value());
  const auto again = bob_.Submit(GoodJob(), 10s, "order-7");
  ASSERT_TRUE(again.has_value());
  EXPECT_EQ(again->uid, first->uid);
  JobSpec other = GoodJob();
  other.set_name("another one");
  const auto refused = bob_.Submit(other, 10s, "order-7");
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message, HasSubstr("was used for another job, job 1"));
  EXPECT_EQ(ann_.Submit(GoodJob(), 10s, "order 7").error().code,
            ErrorCode::kInvalidValue);
}

TEST_F(JobClientTest, WithoutAJobServiceNoJobsAreKnown) {
  JobClient carol(bus_);
  const auto known = PollUntilJobsAreKnown(carol, 300ms);
  ASSERT_FALSE(known.has_value());
  EXPECT_EQ(known.error().code, ErrorCode::kTimedOut);
}

TEST_F(JobClientTest, ReportsThatNobodyAnswers) {
  JobView job;
  job.uid = "1-abc";
  job.number = 1;
  const auto armed = ann_.Command(job, {.kind = intaglio_COMMAND_ARM}, 300ms);
  ASSERT_FALSE(armed.has_value());
  EXPECT_EQ(armed.error().code, ErrorCode::kTimedOut);
  EXPECT_THAT(armed.error().message, HasSubstr("did not answer the command for job 1"));
}

TEST_F(JobClientTest, AnArmThatIsSentBeforeTheJobServiceIsThereIsAnswered) {
  JobView job;
  job.uid = "1-abc";
  const auto sent = ann_.Send(job, {.kind = intaglio_COMMAND_ARM});
  ASSERT_TRUE(sent.has_value());
  Start();
  ASSERT_TRUE(ann_.PollUntil([&] { return ann_.AnswerTo(*sent).has_value(); }, 10s));
  EXPECT_EQ(ann_.AnswerTo(*sent)->code, intaglio_ANSWER_UNKNOWN_JOB);
}

TEST_F(JobClientTest, ABatchLeavesWhatAPersonHasPausedToAPerson) {
  Start();
  shop_.ready = true;
  cli::BatchJob job;
  job.id = "cup";
  job.by_cell["els-03"] = GoodJob();
  job.planned.cells = {"els-03"};
  ::testing::internal::CaptureStderr();
  cli::BatchRunOptions options;
  options.arm = true;
  cli::BatchRun run(ann_, {job}, options, nullptr);
  BatchResults results;
  std::jthread batch([&] { results = run.Run(); });
  ASSERT_TRUE(bob_.PollUntil(
      [&] {
        return !bob_.jobs().empty() && bob_.jobs().begin()->second.armed &&
               bob_.jobs().begin()->second.state == intaglio_JOB_WAITING_FOR_ARM;
      },
      20s));
  const std::string uid = bob_.jobs().begin()->first;
  EXPECT_TRUE(bob_.Command(bob_.jobs().at(uid), {.kind = intaglio_COMMAND_PAUSE}));
  shop_.warm = true;
  BobAwaits(uid, [](const JobView& view) { return !view.armed; });
  // Longer than batches once waited before they armed again, 5 s.
  EXPECT_FALSE(bob_.PollUntil([&] { return bob_.jobs().at(uid).armed; }, 6s));
  EXPECT_TRUE(bob_.Command(bob_.jobs().at(uid), {.kind = intaglio_COMMAND_ARM}));
  batch.join();
  const std::string text = ::testing::internal::GetCapturedStderr();
  EXPECT_THAT(text, HasSubstr("cup (job 1, els-03) waits for a person: paused by "));
  EXPECT_THAT(text, HasSubstr("; intaglio arm 1"));
  EXPECT_EQ(results.jobs(0).state(), "done");
}

TEST(StateOf, AnArmedJobNamesWhatItWaitsFor) {
  JobView job;
  job.state = intaglio_JOB_WAITING_FOR_ARM;
  job.message = "the lamp warms up: 17 %";
  EXPECT_EQ(StateOf(job), "waiting for arm");
  job.armed = true;
  EXPECT_EQ(StateOf(job), "armed, the lamp warms up");
  job.message.clear();
  EXPECT_EQ(StateOf(job), "armed");
  job.state = intaglio_JOB_SORTING;
  EXPECT_EQ(StateOf(job), "ordering, armed");
}

}  // namespace
}  // namespace intaglio::client
