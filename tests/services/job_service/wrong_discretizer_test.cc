// The real job service and real discretizers as processes, and a discretizer that makes
// wrong points, played by the test like the client, the sorter and the synchronizer.

#include <gmock/gmock.h>

#include <filesystem>
#include <thread>

#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/stage/flow.h"
#include "tests/integration/run_program.h"
#include "tests/services/job/test_job.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/services/platform/bus/child_program.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

using bus::View;
using intaglio::testing::Ended;
using intaglio::testing::Running;
using test::ChildProgram;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kWrong = "w";

class WrongDiscretizerTest : public ::testing::Test {
 protected:
  WrongDiscretizerTest() : folder_(test::FreshFolder()) {
    service_.emplace(folder_, test::PrivateTag());
  }

  Ended Type(std::vector<std::string> words) {
    words.insert(words.end(), {"--tag", test::PrivateTag()});
    Running run(intaglio::testing::Program("intaglio"), words, folder_ / "typed.txt");
    return run.WaitForEnd(std::chrono::seconds(30));
  }
  static std::unique_ptr<ChildProgram> Discretizer() {
    return std::make_unique<ChildProgram>(
        INTAGLIO_BIN_DIR "/intaglio-discretizer",
        std::vector<std::string>{"--tag", test::PrivateTag(), "--die-with-parent",
                                 "--threads", "1", "--log-level", "error"});
  }
  std::string InstanceOf(ChildProgram& discretizer) {
    std::string instance;
    EXPECT_TRUE(test::Eventually([&] {
      health_.Take([&](const intaglio_ServiceHealth& sample) {
        if (sample.pid == discretizer.pid()) instance = View(sample.instance);
      });
      return !instance.empty();
    }));
    return instance;
  }
  /// One turn of everybody who is played.
  void Play() {
    const auto now = std::chrono::steady_clock::now();
    if (now >= next_sign_) {
      shop_.Health(intaglio_STAGE_DISCRETIZE, kWrong, intaglio_HEALTH_READY);
      shop_.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_READY);
      shop_.Health(intaglio_STAGE_ENGRAVE, "y", intaglio_HEALTH_READY);
      next_sign_ = now + std::chrono::milliseconds(300);
    }
    tasks_.Take([&](const intaglio_StageTask& task) {
      if (View(task.worker) != shop_.FullName(kWrong) || task.revoked) return;
      ++wrong_tasks_;
      TaskCopy copy;
      copy.worker = kWrong;
      copy.job_uid = View(task.job_uid);
      copy.attempt = task.attempt;
      copy.part = task.part;
      copy.part_count = task.part_count;
      copy.part_attempt = task.part_attempt;
      StageOutcome outcome;
      outcome.mutable_discretize()->set_checksum("7-00bad000");
      shop_.Report(copy, intaglio_STAGE_DISCRETIZE, intaglio_TASK_ACCEPTED, 0, 0);
      shop_.Report(copy, intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 7, 7,
                   intaglio_ERROR_NONE, "", outcome);
    });
    whole_ = intake_.Poll();
    shop_.Poll();
  }
  bool PlayUntil(const std::function<bool()>& condition) {
    return test::Eventually([&] { return Play(), condition(); },
                            std::chrono::seconds(30));
  }
  bool Discretizes() {
    const TaskCopy sort = shop_.Task(intaglio_STAGE_SORT);
    return Status().state == intaglio_JOB_DISCRETIZING && sort.job_uid == Status().uid &&
           sort.attempt == Status().attempt && !sort.revoked;
  }
  StatusCopy Status() { return shop_.Status(submission_); }
  bool IsDisputed() {
    return Status().message.find("made differently") != std::string::npos;
  }
  bool OpenIntake() {
    const TaskCopy sort = shop_.Task(intaglio_STAGE_SORT);
    return intake_.Open(sort.job_uid, sort.attempt, sort.input_part_count).has_value();
  }
  void Submit() {
    submission_ = "job " + std::to_string(++number_);
    shop_.Submit(submission_, GoodJob());
    ASSERT_TRUE(PlayUntil([&] { return Discretizes(); })) << Status().message;
    ASSERT_TRUE(OpenIntake());
  }
  void Cancel() {
    shop_.Command(Status(), intaglio_COMMAND_CANCEL, 1, false, submission_);
    ASSERT_TRUE(PlayUntil([&] { return Status().state == intaglio_JOB_CANCELLED; }));
    for (const auto stage : {intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE}) {
      shop_.Report(shop_.Task(stage), stage, intaglio_TASK_FAILED, 0, 0,
                   intaglio_ERROR_CANCELLED, "");
    }
  }

  bus::Bus bus_{test::PrivateBusOptions("", bus::kStageWorkerRole)};
  FakeShop shop_{test::PrivateBusOptions()};
  bus::Reader<intaglio_ServiceHealth> health_{bus_, bus::kServiceHealth};
  bus::Reader<intaglio_StageTask> tasks_{bus_, bus::kDiscretizeTask};
  host::PointIntake intake_{bus_, "s", bus::kPointBatch};
  std::filesystem::path folder_;
  std::optional<ServiceProcess> service_;
  Result<bool> whole_ = false;
  std::chrono::steady_clock::time_point next_sign_{};
  std::string submission_;
  int number_ = 0, wrong_tasks_ = 0;
};

TEST_F(WrongDiscretizerTest, IsSuspectedThenFoundAndItsPartsAreMadeAnew) {
  const auto right = Discretizer();
  const std::string right_name = InstanceOf(*right);
  // 50 parts: in the fourth job of sixteen, or some more until both were seen at once.
  for (int i = 0; i < 8 && !IsDisputed(); ++i) {
    if (i > 0) Cancel();
    ASSERT_NO_FATAL_FAILURE(Submit());
    ASSERT_TRUE(PlayUntil([&] {
      return IsDisputed() || Status().state != intaglio_JOB_DISCRETIZING;
    })) << Status().message;
    const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(1500);
    PlayUntil([&] { return IsDisputed() || std::chrono::steady_clock::now() > end; });
  }
  ASSERT_TRUE(IsDisputed()) << Status().message;
  EXPECT_THAT(Status().message, AllOf(HasSubstr(kWrong), HasSubstr(right_name),
                                      HasSubstr("start another discretizer")));
  EXPECT_TRUE(PlayUntil([&] {
    return shop_.JobServiceHealth().message.find("made differently") != std::string::npos;
  }));
  shop_.Command(Status(), intaglio_COMMAND_ARM, 2, false, submission_);
  EXPECT_EQ(shop_.AnswerTo(2, submission_), intaglio_ANSWER_NOT_YET);

  // The second real one decides, and makes the job with the first.
  const auto second = Discretizer();
  ASSERT_TRUE(PlayUntil([&] { return Status().attempt == 2 && Discretizes(); }))
      << Status().message;
  const int tasks_before = wrong_tasks_;
  const std::string found = shop_.FullName(kWrong) + " made part ";
  EXPECT_TRUE(PlayUntil(
      [&] { return shop_.JobServiceHealth().message.find(found) != std::string::npos; }));
  ASSERT_TRUE(OpenIntake());
  ASSERT_TRUE(PlayUntil([&] { return !whole_ || *whole_; }));
  ASSERT_TRUE(whole_) << whole_.error().message;
  EXPECT_GT(intake_.TakeContent().size(), 100u);
  EXPECT_EQ(wrong_tasks_, tasks_before) << "it is given nothing more";
  shop_.Report(shop_.Task(intaglio_STAGE_SORT), intaglio_STAGE_SORT, intaglio_TASK_DONE,
               100, 100);
  shop_.Report(shop_.Task(intaglio_STAGE_ENGRAVE), intaglio_STAGE_ENGRAVE,
               intaglio_TASK_RUNNING, 0, 100);
  ASSERT_TRUE(PlayUntil([&] { return Status().state == intaglio_JOB_WAITING_FOR_ARM; }));
  shop_.Accept(Status(), 3);
  EXPECT_TRUE(PlayUntil([&] { return shop_.granted(); })) << Status().message;

  // The next life of the job service knows it, too.
  service_.reset();
  service_.emplace(folder_, test::PrivateTag());
  ASSERT_TRUE(PlayUntil([&] { return shop_.JobServiceHealth().message.empty(); }));
  EXPECT_TRUE(PlayUntil(
      [&] { return shop_.JobServiceHealth().message.find(found) != std::string::npos; }));

  // A person lists who is left out, and admits it when its computer was mended.
  const std::string wrong_name = shop_.FullName(kWrong);
  EXPECT_TRUE(test::Eventually([&] {
    const Ended listed = Type({"workers"});
    return listed.output.find("left out") != std::string::npos &&
           listed.output.find(found) != std::string::npos;
  }));
  const Ended nobody = Type({"workers", "admit", "nobody"});
  EXPECT_EQ(nobody.exit_code, 4);
  EXPECT_THAT(nobody.output, AllOf(HasSubstr("not_left_out"), HasSubstr("nobody")));
  const Ended admitted = Type({"workers", "admit", wrong_name});
  EXPECT_EQ(admitted.exit_code, 0) << admitted.output;
  EXPECT_TRUE(PlayUntil([&] { return shop_.JobServiceHealth().message.empty(); }));
  const std::string queue = (folder_ / "jobs.db").string();
  Running history(intaglio::testing::Program("intaglio"),
                  {"history", "--workers", "--database", queue}, folder_ / "typed.txt");
  EXPECT_THAT(history.WaitForEnd(std::chrono::seconds(20)).output,
              AllOf(HasSubstr("suspected"), HasSubstr("wrong"), HasSubstr("admitted"),
                    HasSubstr(wrong_name)));
}

}  // namespace
}  // namespace intaglio::job_service
