// The real process, over DDS, with its workers played by the test.

#include <gmock/gmock.h>

#include <fstream>
#include <optional>

#include "tests/services/job/test_job.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class JobServiceTest : public testing::Test {
 protected:
  JobServiceTest() : folder_(test::FreshFolder()) { Start(); }
  void Start() { service_.emplace(folder_, test::PrivateTag()); }

  void ReadyAll() {
    shop_.Health(intaglio_STAGE_DISCRETIZE, "d", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_ENGRAVE, "y", intaglio_HEALTH_READY);
  }
  bool Reaches(intaglio_JobState state, const std::string& submission = "one") {
    const bool reached = shop_.Until([&] { return Job(submission).state == state; });
    EXPECT_EQ(Job(submission).state, state) << Job(submission).message;
    return reached;
  }
  StatusCopy Job(const std::string& submission = "one") {
    return shop_.Status(submission);
  }
  TaskCopy Discretize() { return shop_.Task(intaglio_STAGE_DISCRETIZE); }
  bool HasTasks(std::uint32_t attempt) {
    return shop_.Until([&] {
      for (const auto stage :
           {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE}) {
        const TaskCopy task = shop_.Task(stage);
        if (task.attempt != attempt || task.revoked) return false;
      }
      return true;
    });
  }
  void Report(intaglio_Stage stage, intaglio_TaskState state, std::uint64_t done,
              const std::string& message = "") {
    shop_.Report(shop_.Task(stage), stage, state, done, 100, intaglio_ERROR_NONE,
                 message);
  }
  // From submission to the path in the synchronizer.
  void RunToArm(const JobSpec& job = GoodJob()) {
    shop_.Submit("one", job);
    ReadyAll();
    ASSERT_TRUE(HasTasks(1));
    Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100);
    ASSERT_TRUE(Reaches(intaglio_JOB_SORTING));
    Report(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100);
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, "waits for the arm");
    ASSERT_TRUE(Reaches(intaglio_JOB_WAITING_FOR_ARM));
  }
  void RunToEngraving(const JobSpec& job = GoodJob()) {
    RunToArm(job);
    shop_.Command(Job(), intaglio_COMMAND_ARM, 1);
    ASSERT_TRUE(shop_.Until([&] { return shop_.granted(); }));
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 10);
    ASSERT_TRUE(Reaches(intaglio_JOB_ENGRAVING));
  }

  fs::path folder_;
  FakeShop shop_{test::PrivateBusOptions()};
  std::optional<ServiceProcess> service_;
};

TEST_F(JobServiceTest, HappyPath) {
  shop_.Submit("one", GoodJob());
  ASSERT_TRUE(Reaches(intaglio_JOB_QUEUED));
  ASSERT_TRUE(shop_.Until([&] {
    return Job().message.find("waits for a synchronizer of els-03 (none runs)") !=
           std::string::npos;
  }));
  EXPECT_EQ(Job().cell, "els-03");
  ReadyAll();
  ASSERT_TRUE(HasTasks(1));
  EXPECT_TRUE(Reaches(intaglio_JOB_DISCRETIZING));
  const TaskCopy discretize = shop_.Task(intaglio_STAGE_DISCRETIZE);
  EXPECT_EQ(discretize.worker, "d");
  EXPECT_EQ(discretize.consumer, "s");
  EXPECT_EQ(shop_.Task(intaglio_STAGE_SORT).consumer, "y");
  EXPECT_EQ(shop_.Task(intaglio_STAGE_ENGRAVE).consumer, "");
  EXPECT_EQ(discretize.frozen.job_uid(), Job().uid);
  EXPECT_EQ(discretize.frozen.epoch(), Job().epoch);
  EXPECT_EQ(discretize.frozen.result_directory(), folder_ / "results" / Job().uid);
  // Published index at 532 nm, to the five digits given.
  EXPECT_NEAR(discretize.frozen.optics().refractive_index(), 1.51947, 5e-6);

  ASSERT_TRUE(shop_.Until([&] { return shop_.ReceiveModels(discretize); }));
  std::ifstream file(GoodJob().models(0).file(), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  ASSERT_GT(bytes.size(), 65536u) << "more than one chunk";
  ASSERT_EQ(shop_.models().size(), 1u);
  EXPECT_EQ(shop_.models()[0], bytes);

  Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100);
  ASSERT_TRUE(Reaches(intaglio_JOB_SORTING));
  Report(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100);
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0);
  ASSERT_TRUE(Reaches(intaglio_JOB_WAITING_FOR_ARM));
  EXPECT_EQ(Job().estimate_ticks, 4321u);
  // A permission is published, and it is not granted.
  const int before = shop_.permissions_seen();
  ASSERT_TRUE(shop_.Until([&] { return shop_.permissions_seen() >= before + 3; }));
  EXPECT_FALSE(shop_.granted());
  shop_.Command(Job(), intaglio_COMMAND_ARM, 1);
  ASSERT_TRUE(shop_.Until([&] { return shop_.granted(); }));
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 50);
  ASSERT_TRUE(Reaches(intaglio_JOB_ENGRAVING));
  // Firing what is uncertain goes with the permission that it came with, and with no
  // other.
  EXPECT_FALSE(shop_.fire_uncertain());
  shop_.Command(Job(), intaglio_COMMAND_RESUME, 2, true);
  EXPECT_TRUE(shop_.Until([&] { return shop_.fire_uncertain(); }));
  shop_.Command(Job(), intaglio_COMMAND_RESUME, 3);
  EXPECT_TRUE(shop_.Until([&] { return !shop_.fire_uncertain(); }));
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_DONE, 100);
  ASSERT_TRUE(Reaches(intaglio_JOB_DONE));
  ASSERT_TRUE(shop_.Until([&] { return !shop_.granted(); }));
  EXPECT_EQ(service_->Stop(), 0);
}

TEST_F(JobServiceTest, AMachineOfAnotherVersionIsGivenNothingUntilItIsRestarted) {
  shop_.Submit("one", GoodJob());
  ASSERT_TRUE(Reaches(intaglio_JOB_QUEUED));
  shop_.SetVersion("0.0.9");
  ReadyAll();
  ASSERT_TRUE(shop_.Until([&] {
    return Job().message.find("y has version 0.0.9, the job service ") !=
           std::string::npos;
  }));
  EXPECT_EQ(Job().state, intaglio_JOB_QUEUED);
  EXPECT_TRUE(shop_.Task(intaglio_STAGE_ENGRAVE).worker.empty());
  shop_.SetVersion(host::WireVersion());
  ReadyAll();
  EXPECT_TRUE(HasTasks(1));
}

TEST_F(JobServiceTest, ARefusalNamesEveryMistake) {
  JobSpec job = GoodJob();
  job.set_glass("unobtainium");
  job.mutable_block()->set_margin_mm(-1);
  job.mutable_models(0)->set_file("/nowhere/cube.stl");
  job.mutable_discretization()->set_min_spacing_mm(50);
  job.mutable_laser()->set_rate_hz(60);
  job.mutable_lens()->set_focal_length_mm(50);
  shop_.Submit("one", job);
  ASSERT_TRUE(Reaches(intaglio_JOB_FAILED));
  EXPECT_EQ(Job().uid, "");
  for (const char* path :
       {"glass: ", "block.margin_mm: -1", "models[0].file: /nowhere/cube.stl",
        "discretization.min_spacing_mm: 50", "laser.rate_hz: 60",
        "lens.focal_length_mm: 50"}) {
    EXPECT_THAT(Job().message, HasSubstr(path));
  }
  shop_.Submit("two", JobSpec());
  ASSERT_TRUE(Reaches(intaglio_JOB_FAILED, "two"));
  EXPECT_THAT(Job("two").message, HasSubstr("machine_file: is missing"));
  shop_.Submit("three", GoodJob(), 42);
  ASSERT_TRUE(Reaches(intaglio_JOB_FAILED, "three"));
  EXPECT_THAT(Job("three").message, HasSubstr("another run"));
}

TEST_F(JobServiceTest, ADeadWorkersJobIsHandedOutAnew) {
  shop_.Submit("one", GoodJob());
  ReadyAll();
  ASSERT_TRUE(HasTasks(1));
  const TaskCopy first = shop_.Task(intaglio_STAGE_DISCRETIZE);
  shop_.Die(intaglio_STAGE_SORT, "s");
  ASSERT_TRUE(shop_.Until([&] { return shop_.Task(intaglio_STAGE_DISCRETIZE).revoked; }));
  EXPECT_TRUE(Reaches(intaglio_JOB_QUEUED));
  EXPECT_THAT(Job().message, HasSubstr("s was lost"));
  shop_.Report(first, intaglio_STAGE_DISCRETIZE, intaglio_TASK_FAILED, 0, 0,
               intaglio_ERROR_CANCELLED, "");
  shop_.Report(shop_.Task(intaglio_STAGE_ENGRAVE), intaglio_STAGE_ENGRAVE,
               intaglio_TASK_FAILED, 0, 0, intaglio_ERROR_CANCELLED, "");
  shop_.Health(intaglio_STAGE_SORT, "s2", intaglio_HEALTH_READY);
  ASSERT_TRUE(HasTasks(2));
  EXPECT_EQ(shop_.Task(intaglio_STAGE_SORT).worker, "s2");
  // A report of the old attempt is ignored.
  shop_.Report(first, intaglio_STAGE_DISCRETIZE, intaglio_TASK_FAILED, 0, 0,
               intaglio_ERROR_UNREADABLE, "old");
  const TaskCopy second = shop_.Task(intaglio_STAGE_DISCRETIZE);
  ASSERT_TRUE(shop_.Until([&] { return shop_.ReceiveModels(second); }));
  Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100);
  EXPECT_TRUE(Reaches(intaglio_JOB_SORTING));
}

TEST_F(JobServiceTest, ADeadDiscretizersPartIsHandedOutAgainAndTheOthersGoOn) {
  shop_.Submit("one", GoodJob());
  shop_.Health(intaglio_STAGE_DISCRETIZE, "d2", intaglio_HEALTH_READY);
  ReadyAll();
  ASSERT_TRUE(HasTasks(1));
  const TaskCopy sort = shop_.Task(intaglio_STAGE_SORT);
  EXPECT_EQ(sort.input_part_count, 16u);
  EXPECT_EQ(sort.part_count, 1u);
  // The fake shop sees the newest task alone: the one of the second by name.
  ASSERT_TRUE(shop_.Until([&] { return Discretize().worker == "d2"; }));
  EXPECT_EQ(Discretize().part, 1u);
  EXPECT_EQ(Discretize().part_count, 16u);
  EXPECT_EQ(Discretize().consumer, "s");
  shop_.Die(intaglio_STAGE_DISCRETIZE, "d2");
  ASSERT_TRUE(shop_.Until([&] { return Discretize().revoked; }));
  EXPECT_EQ(Discretize().part, 1u);
  ASSERT_TRUE(shop_.Until([&] { return !Job().message.empty(); }));
  EXPECT_EQ(Job().message, "part 2 of 16 starts again: d2 was lost");
  shop_.Health(intaglio_STAGE_DISCRETIZE, "d3", intaglio_HEALTH_READY);
  ASSERT_TRUE(shop_.Until([&] { return Discretize().worker == "d3"; }));
  EXPECT_EQ(Discretize().part, 1u);
  EXPECT_EQ(Discretize().part_attempt, 1u);
  EXPECT_EQ(Discretize().attempt, 1u);
  const TaskCopy again = Discretize();
  ASSERT_TRUE(shop_.Until([&] { return shop_.ReceiveModels(again); }));
  // It finishes one part after another, and may ask for the models with each.
  for (std::uint32_t part = 2; part < 16; ++part) {
    Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100);
    ASSERT_TRUE(shop_.Until([&] { return Discretize().part == part; }));
    EXPECT_EQ(Discretize().part_attempt, 0u);
  }
  EXPECT_EQ(Job().state, intaglio_JOB_DISCRETIZING);
  const TaskCopy last = Discretize();
  ASSERT_TRUE(shop_.Until([&] { return shop_.ReceiveModels(last); }));
  Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100);
  TaskCopy of_first = last;
  of_first.worker = "d";
  of_first.part = 0;
  shop_.Report(of_first, intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100, 100);
  EXPECT_TRUE(Reaches(intaglio_JOB_SORTING));
  EXPECT_EQ(Job().attempt, 1u);
}

TEST_F(JobServiceTest, CancelWithdrawsEverything) {
  RunToEngraving();
  shop_.Command(Job(), intaglio_COMMAND_CANCEL, 2);
  ASSERT_TRUE(Reaches(intaglio_JOB_CANCELLED));
  EXPECT_EQ(Job().message, "cancelled by ann@shop");
  EXPECT_TRUE(shop_.Until([&] { return shop_.Task(intaglio_STAGE_ENGRAVE).revoked; }));
  EXPECT_TRUE(shop_.Until([&] { return !shop_.granted(); }));
}

TEST_F(JobServiceTest, StaleCommandsAndRepeatedSubmissionsDoNothing) {
  RunToArm();
  StatusCopy stale = Job();
  --stale.epoch;
  shop_.Command(stale, intaglio_COMMAND_ARM, 5);
  const int before = shop_.permissions_seen();
  // Ten periods of the permission: the command was taken long before.
  ASSERT_TRUE(shop_.Until([&] { return shop_.permissions_seen() >= before + 10; }));
  EXPECT_FALSE(shop_.granted());
  EXPECT_EQ(shop_.AnswerTo(5), intaglio_ANSWER_WRONG_EPOCH);
  const std::string uid = Job().uid;
  shop_.Submit("one", GoodJob());
  shop_.Command(Job(), intaglio_COMMAND_ARM, 6);
  ASSERT_TRUE(shop_.Until([&] { return shop_.granted(); }));
  EXPECT_EQ(Job().uid, uid);
}

TEST_F(JobServiceTest, PauseAndResume) {
  RunToEngraving();
  shop_.Command(Job(), intaglio_COMMAND_PAUSE, 2);
  ASSERT_TRUE(Reaches(intaglio_JOB_PAUSED));
  ASSERT_TRUE(shop_.Until([&] { return !shop_.granted(); }));
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, "no permission");
  shop_.Command(Job(), intaglio_COMMAND_RESUME, 3);
  ASSERT_TRUE(shop_.Until([&] { return shop_.granted(); }));
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 13);
  EXPECT_TRUE(Reaches(intaglio_JOB_ENGRAVING));
}

// Each has seen the same status; none takes the other's place, in whatever order they
// come.
TEST_F(JobServiceTest, CommandsOfTwoClientsSentAtOnceAreBothAnswered) {
  RunToArm();
  for (std::uint64_t number = 1; number <= 10; ++number) {
    const StatusCopy seen = Job();
    shop_.Command(seen, intaglio_COMMAND_ARM, number, false, "ann");
    shop_.Command(seen, intaglio_COMMAND_PAUSE, number, false, "bob");
    EXPECT_EQ(shop_.AnswerTo(number, "bob"), intaglio_ANSWER_TAKEN);
    EXPECT_THAT(shop_.AnswerTo(number, "ann"),
                testing::AnyOf(intaglio_ANSWER_TAKEN, intaglio_ANSWER_SUPERSEDED));
    EXPECT_TRUE(shop_.Until([&] { return Job().disarm_count == number; }));
    EXPECT_FALSE(Job().armed) << "the pause wins";
  }
}

// All are delivered to the next life again, because their client lives.
TEST_F(JobServiceTest, NoCommandIsAppliedASecondTimeAfterAKill) {
  RunToEngraving();
  ASSERT_EQ(shop_.AnswerTo(1), intaglio_ANSWER_TAKEN);
  const StatusCopy engraving = Job();
  shop_.Command(engraving, intaglio_COMMAND_PAUSE, 2);
  ASSERT_EQ(shop_.AnswerTo(2), intaglio_ANSWER_TAKEN);
  ASSERT_TRUE(Reaches(intaglio_JOB_PAUSED));
  shop_.Command(engraving, intaglio_COMMAND_RESUME, 3);
  ASSERT_EQ(shop_.AnswerTo(3), intaglio_ANSWER_SUPERSEDED);
  service_->Kill();
  Start();
  for (const std::uint64_t number : {1, 2, 3}) {
    EXPECT_TRUE(shop_.Until([&] { return shop_.answers(number) >= 2; })) << number;
  }
  EXPECT_EQ(shop_.AnswerTo(1), intaglio_ANSWER_TAKEN) << "as it was answered before";
  EXPECT_EQ(shop_.AnswerTo(3), intaglio_ANSWER_SUPERSEDED);
  const int before = shop_.permissions_seen();
  ASSERT_TRUE(shop_.Until([&] { return shop_.permissions_seen() >= before + 10; }));
  EXPECT_FALSE(shop_.granted());
  EXPECT_EQ(Job().state, intaglio_JOB_PAUSED);
  shop_.Command(Job(), intaglio_COMMAND_RESUME, 4);
  ASSERT_TRUE(shop_.Until([&] { return shop_.granted(); }));
}

TEST_F(JobServiceTest, AJobThatWaitsForItsMachineCannotBeArmed) {
  shop_.Submit("one", GoodJob());
  ASSERT_TRUE(shop_.Until([&] { return !Job().uid.empty(); }));
  shop_.Command(Job(), intaglio_COMMAND_ARM, 1);
  EXPECT_EQ(shop_.AnswerTo(1), intaglio_ANSWER_NOT_YET);
  ReadyAll();
  ASSERT_TRUE(HasTasks(1));
  shop_.Command(Job(), intaglio_COMMAND_ARM, 2);
  EXPECT_EQ(shop_.AnswerTo(2), intaglio_ANSWER_TAKEN);
  EXPECT_TRUE(shop_.Until([&] { return Job().armed; }));
}

// It was armed for its block; the one in the machine is by then another job's.
TEST_F(JobServiceTest, AnArmedJobThatIsOvertakenIsNotPermittedToFire) {
  shop_.Submit("one", GoodJob());
  ReadyAll();
  ASSERT_TRUE(HasTasks(1));
  shop_.Command(Job(), intaglio_COMMAND_ARM, 1);
  ASSERT_EQ(shop_.AnswerTo(1), intaglio_ANSWER_TAKEN);
  JobSpec urgent = GoodJob();
  urgent.set_priority(1);
  shop_.Submit("two", urgent);
  ASSERT_TRUE(shop_.Until([&] { return !Job("two").uid.empty(); }));
  shop_.Die(intaglio_STAGE_SORT, "s");
  ASSERT_TRUE(Reaches(intaglio_JOB_QUEUED));
  EXPECT_FALSE(Job().armed);
  // A worker that has a task of another job ends it.
  const auto is_of = [&](const std::string& submission) {
    bool all = true;
    for (const auto stage :
         {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE}) {
      const TaskCopy task = shop_.Task(stage);
      if (task.revoked) {
        shop_.Report(task, stage, intaglio_TASK_FAILED, 0, 0, intaglio_ERROR_CANCELLED,
                     "");
      }
      all = all && !task.revoked && task.job_uid == Job(submission).uid;
    }
    return all;
  };
  shop_.Health(intaglio_STAGE_SORT, "s2", intaglio_HEALTH_READY);
  ASSERT_TRUE(shop_.Until([&] { return is_of("two"); }));
  EXPECT_THAT(Job().message, HasSubstr("it is no longer armed"));
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_DONE, 100);
  ASSERT_TRUE(Reaches(intaglio_JOB_DONE, "two"));
  ASSERT_TRUE(shop_.Until([&] { return is_of("one"); }));
  Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100);
  Report(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100);
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, "waits for the arm");
  ASSERT_TRUE(Reaches(intaglio_JOB_WAITING_FOR_ARM));
  const int before = shop_.permissions_seen();
  ASSERT_TRUE(shop_.Until([&] { return shop_.permissions_seen() >= before + 10; }));
  EXPECT_FALSE(shop_.granted());
  shop_.Command(Job(), intaglio_COMMAND_ARM, 2);
  EXPECT_TRUE(shop_.Until([&] { return shop_.granted(); }));
}

TEST_F(JobServiceTest, TheQueueSurvivesAKill) {
  shop_.Submit("one", GoodJob());
  ASSERT_TRUE(shop_.Until([&] { return !Job().message.empty(); }));
  const StatusCopy before = Job();
  service_->Kill();
  Start();
  ASSERT_TRUE(shop_.Until([&] { return Job().revision > before.revision + 1; }));
  EXPECT_EQ(Job().uid, before.uid);
  EXPECT_EQ(Job().epoch, before.epoch);
  ReadyAll();
  EXPECT_TRUE(HasTasks(1));
  shop_.Submit("two", GoodJob());
  ASSERT_TRUE(shop_.Until([&] { return !Job("two").uid.empty(); }));
  EXPECT_GT(Job("two").epoch, before.epoch);
}

TEST_F(JobServiceTest, AKillWhileEngravingPausesAndTheSameSynchronizerGoesOn) {
  JobSpec job = GoodJob();
  job.set_ask_before_resume(true);  // else it goes on by itself before long
  RunToEngraving(job);
  service_->Kill();
  ASSERT_TRUE(shop_.Until([&] { return !shop_.granted(); }))
      << "silence is no permission";
  // As a synchronizer does; its report may come before or after that on the restart is
  // read.
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 10, "waits for the arm");
  Start();
  ASSERT_TRUE(Reaches(intaglio_JOB_PAUSED));
  EXPECT_THAT(Job().message, testing::AnyOf(HasSubstr("the job service was restarted"),
                                            HasSubstr("waits for the arm")));
  // An arm of before the restart, repeated, is stale.
  shop_.Command(Job(), intaglio_COMMAND_RESUME, 1);
  const int before = shop_.permissions_seen();
  ASSERT_TRUE(shop_.Until([&] { return shop_.permissions_seen() >= before + 10; }));
  EXPECT_FALSE(shop_.granted());
  shop_.Command(Job(), intaglio_COMMAND_RESUME, 2);
  ASSERT_TRUE(shop_.Until([&] { return shop_.granted(); }));
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_DONE, 100);
  EXPECT_TRUE(Reaches(intaglio_JOB_DONE));
}

TEST_F(JobServiceTest, WrongOptionsAndDatabasesEndTheProcess) {
  service_->Kill();
  fs::remove(folder_ / "jobs.db");
  fs::create_directory(folder_ / "jobs.db");
  Start();
  int status = -1;
  ASSERT_TRUE(test::Eventually([&] { return service_->Exited(status); }));
  EXPECT_EQ(status, 1);
}

}  // namespace
}  // namespace intaglio::job_service
