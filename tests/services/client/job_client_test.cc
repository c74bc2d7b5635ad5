// Clients of the real job service, whose workers are played by the test.

#include "services/client/job_client.h"

#include <gmock/gmock.h>

#include <atomic>
#include <optional>
#include <thread>

#include "services/cli/batch/batch_run.h"
#include "services/client/arm_once.h"
#include "services/client/known_jobs.h"
#include "tests/services/job/test_job.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;
using job_service::FakeShop;
using job_service::ServiceProcess;
using job_service::TaskCopy;
using ::testing::HasSubstr;

/// A discretizer, a sorter and a synchronizer that are quick. The lamp warms up until the
/// test lets it fire.
class PlayedShop {
 public:
  PlayedShop() : playing_([this](const std::stop_token& stop) { Play(stop); }) {}
  std::atomic<bool> ready = false;  ///< the workers are there
  std::atomic<bool> warm = false;   ///< what is permitted is fired

 private:
  void Play(const std::stop_token& stop) {
    FakeShop shop(test::PrivateBusOptions());
    std::string done;
    while (!stop.stop_requested()) {
      std::this_thread::sleep_for(20ms);
      shop.Poll();
      if (!ready) continue;
      const TaskCopy task = shop.Task(intaglio_STAGE_ENGRAVE);
      const bool at_work = !task.job_uid.empty() && !task.revoked && task.job_uid != done;
      const auto health = at_work ? intaglio_HEALTH_BUSY : intaglio_HEALTH_READY;
      shop.Health(intaglio_STAGE_DISCRETIZE, "d", health);
      shop.Health(intaglio_STAGE_SORT, "s", health);
      shop.Health(intaglio_STAGE_ENGRAVE, "y", health);
      if (!at_work) continue;
      for (const auto stage : {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT}) {
        if (shop.Task(stage).job_uid == task.job_uid) {
          shop.Report(shop.Task(stage), stage, intaglio_TASK_DONE, 100, 100);
        }
      }
      const bool fires = warm && shop.granted();
      if (fires) done = task.job_uid;
      shop.Report(task, intaglio_STAGE_ENGRAVE,
                  fires ? intaglio_TASK_DONE : intaglio_TASK_RUNNING, fires ? 100 : 0,
                  100);
    }
  }
  std::jthread playing_;
};

class JobClientTest : public ::testing::Test {
 protected:
  JobClientTest() : folder_(test::FreshFolder()) {}
  void Start() { service_.emplace(folder_, test::PrivateTag()); }
  /// Bob sees what ann submitted.
  JobView OfBob(const std::string& uid) {
    EXPECT_TRUE(bob_.PollUntil([&] { return bob_.jobs().contains(uid); }, 10s));
    return bob_.jobs().at(uid);
  }
  JobView BobAwaits(const std::string& uid,
                    const std::function<bool(const JobView&)>& condition) {
    EXPECT_TRUE(bob_.PollUntil([&] { return condition(bob_.jobs().at(uid)); }, 10s));
    return bob_.jobs().at(uid);
  }

  std::filesystem::path folder_;
  bus::Bus bus_{test::PrivateBusOptions()};
  JobClient ann_{bus_}, bob_{bus_};
  PlayedShop shop_;
  std::optional<ServiceProcess> service_;
};

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
  // A patient quiet time, for the computer may be busy with other tests.
  EXPECT_TRUE(PollUntilJobsAreKnown(carol, 1s, 20s));
  EXPECT_EQ(carol.jobs().size(), 20U);
}

TEST_F(JobClientTest, WithoutAJobServiceNoJobsAreKnown) {
  JobClient carol(bus_);
  EXPECT_FALSE(PollUntilJobsAreKnown(carol, 10ms, 300ms));
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

TEST_F(JobClientTest, ArmsWhenTheMachineHasTheJobAndElseLeavesItQueued) {
  Start();
  const auto job = ann_.Submit(GoodJob(), 10s);
  ASSERT_TRUE(job.has_value());
  const auto late = ArmWhenTaken(ann_, *job, false, 500ms);
  ASSERT_FALSE(late.has_value());
  EXPECT_THAT(late.error().message, HasSubstr("job 1 stays queued and is not armed"));
  EXPECT_THAT(late.error().message, HasSubstr("intaglio arm 1"));
  shop_.ready = true;
  EXPECT_TRUE(ArmWhenTaken(ann_, *job, false, 10s).has_value());
  OfBob(job->uid);
  EXPECT_EQ(StateOf(BobAwaits(job->uid,
                              [](const JobView& view) {
                                return view.armed &&
                                       view.state == intaglio_JOB_WAITING_FOR_ARM;
                              })),
            "armed");
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
