// The real job service, honest workers played by the test, and a forger beside them: what
// it writes has no effect, whatever name it uses. On this bus the partitions of the roles
// are not enforced, so the forger writes in those of others as well.

#include <gmock/gmock.h>

#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/version/wire_version.h"
#include "tests/services/job/test_job.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

using bus::Borrow;
using testing::HasSubstr;

const std::string kStage = bus::RolePartition(bus::kStageWorkerRole);
const std::string kCell = bus::RolePartition(bus::CellRole("els-03"));

class Forger {
 public:
  explicit Forger(const std::string& partition)
      : health_(bus_, bus::kServiceHealth, partition),
        tasks_(bus_, bus::kTaskStatus, partition) {}

  intaglio_ServiceHealth HealthOf(const std::string& instance, intaglio_ServiceRole role,
                                  intaglio_HealthState state) {
    instance_ = instance;
    cell_ = role == intaglio_ROLE_SYNCHRONIZER ? "els-03" : "";
    intaglio_ServiceHealth sample{};
    sample.instance = Borrow(instance_);
    sample.role = role;
    sample.state = state;
    sample.cell = Borrow(cell_);
    sample.version = Borrow(version_);
    sample.host = sample.job_uid = sample.message = Borrow(empty_);
    return sample;
  }
  void Health(const std::string& instance, intaglio_ServiceRole role,
              intaglio_HealthState state) {
    EXPECT_TRUE(health_.Write(HealthOf(instance, role, state)));
  }
  void Dispose(const std::string& instance, intaglio_ServiceRole role) {
    EXPECT_TRUE(health_.Dispose(HealthOf(instance, role, intaglio_HEALTH_STOPPING)));
  }
  void Report(const TaskCopy& task, const std::string& worker, intaglio_Stage stage,
              intaglio_TaskState state) {
    const std::string message = "forged";
    intaglio_TaskStatus sample{};
    sample.job_uid = Borrow(task.job_uid);
    sample.stage = stage;
    sample.worker = Borrow(worker);
    sample.part = task.part;
    sample.part_count = task.part_count;
    sample.attempt = task.attempt;
    sample.part_attempt = task.part_attempt;
    sample.state = state;
    sample.done_count = sample.total_count = 100;
    if (state == intaglio_TASK_FAILED) sample.error_code = intaglio_ERROR_FAULT;
    sample.message = Borrow(message);
    EXPECT_TRUE(tasks_.Write(sample));
  }
  std::string OwnName() const { return "forger-" + bus_.participant_name(); }
  bool IsSeen() const {
    return tasks_.matched_count() > 0 && health_.matched_count() > 0;
  }

 private:
  bus::Bus bus_{test::PrivateBusOptions()};
  bus::Writer<intaglio_ServiceHealth> health_;
  bus::Writer<intaglio_TaskStatus> tasks_;
  std::string instance_, cell_;
  const std::string empty_, version_ = host::WireVersion();
};

class ForgedReports : public testing::Test {
 protected:
  ForgedReports() : service_(folder_, test::PrivateTag()) {}

  void ReadyAll() {
    shop_.Health(intaglio_STAGE_DISCRETIZE, "d", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_ENGRAVE, "y", intaglio_HEALTH_READY);
  }
  bool Reaches(intaglio_JobState state) {
    return shop_.Until([&] { return shop_.Status("one").state == state; });
  }
  void Report(intaglio_Stage stage, intaglio_TaskState state, std::uint64_t done) {
    shop_.Report(shop_.Task(stage), stage, state, done, 100);
  }
  void RunToEngraving() {
    shop_.Submit("one", GoodJob());
    ReadyAll();
    ASSERT_TRUE(shop_.Until(
        [&] { return !shop_.Task(intaglio_STAGE_DISCRETIZE).job_uid.empty(); }));
    ASSERT_TRUE(shop_.Until([&] { return forger_in_stage_.IsSeen(); }));
    ASSERT_TRUE(shop_.Until([&] { return forger_in_cell_.IsSeen(); }));
    Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100);
    ASSERT_TRUE(Reaches(intaglio_JOB_SORTING));
    Report(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100);
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0);
    ASSERT_TRUE(Reaches(intaglio_JOB_WAITING_FOR_ARM));
    shop_.Command(shop_.Status("one"), intaglio_COMMAND_ARM, 1);
    ASSERT_TRUE(shop_.Until([&] { return shop_.granted(); }));
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 10);
    ASSERT_TRUE(Reaches(intaglio_JOB_ENGRAVING));
  }
  /// What was written before has been taken by now: the answer to an honest report, and
  /// thirty permissions, which is more than half a second of turns.
  void ExpectUndisturbed(std::uint64_t done) {
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, done);
    const int before = shop_.permissions_seen();
    ASSERT_TRUE(shop_.Until([&] {
      EXPECT_TRUE(shop_.granted());
      return shop_.permissions_seen() >= before + 30;
    }));
    EXPECT_EQ(shop_.Status("one").state, intaglio_JOB_ENGRAVING)
        << shop_.Status("one").message;
    EXPECT_EQ(shop_.Status("one").attempt, 1u);
    EXPECT_FALSE(shop_.Task(intaglio_STAGE_ENGRAVE).revoked);
  }
  void ExpectGoodEnd() {
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_DONE, 100);
    EXPECT_TRUE(Reaches(intaglio_JOB_DONE));
    EXPECT_EQ(shop_.Status("one").message, "");
  }

  std::filesystem::path folder_ = test::FreshFolder();
  FakeShop shop_{test::PrivateBusOptions()};
  Forger forger_in_stage_{kStage}, forger_in_cell_{kCell};
  ServiceProcess service_;
};

TEST_F(ForgedReports, ATaskThatOneWasNotGivenIsNeitherDoneNorFailed) {
  RunToEngraving();
  const TaskCopy engrave = shop_.Task(intaglio_STAGE_ENGRAVE);
  const std::string y = shop_.FullName("y");
  std::uint64_t done = 20;
  for (const auto state :
       {intaglio_TASK_DONE, intaglio_TASK_FAILED, intaglio_TASK_PAUSED}) {
    // As a stage worker, in the synchronizer's name and in its own.
    forger_in_stage_.Report(engrave, y, intaglio_STAGE_ENGRAVE, state);
    const std::string own = forger_in_stage_.OwnName();
    forger_in_stage_.Report(engrave, own, intaglio_STAGE_ENGRAVE, state);
    // As another process of the cell.
    forger_in_cell_.Report(engrave, y, intaglio_STAGE_ENGRAVE, state);
    ExpectUndisturbed(done += 10);
  }
  ExpectGoodEnd();
}

TEST_F(ForgedReports, AStageThatAnotherMakesIsNotDone) {
  shop_.Submit("one", GoodJob());
  ReadyAll();
  ASSERT_TRUE(
      shop_.Until([&] { return !shop_.Task(intaglio_STAGE_SORT).job_uid.empty(); }));
  ASSERT_TRUE(shop_.Until([&] { return forger_in_stage_.IsSeen(); }));
  const TaskCopy part = shop_.Task(intaglio_STAGE_DISCRETIZE);
  forger_in_stage_.Report(part, shop_.FullName("d"), intaglio_STAGE_DISCRETIZE,
                          intaglio_TASK_DONE);
  forger_in_stage_.Report(part, forger_in_stage_.OwnName(), intaglio_STAGE_DISCRETIZE,
                          intaglio_TASK_DONE);
  forger_in_cell_.Report(part, shop_.FullName("d"), intaglio_STAGE_DISCRETIZE,
                         intaglio_TASK_DONE);
  // The honest one's progress comes after it, and the job still discretizes.
  Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_RUNNING, 50);
  const auto end = std::chrono::steady_clock::now() + std::chrono::milliseconds(500);
  ASSERT_TRUE(shop_.Until([&] { return std::chrono::steady_clock::now() > end; }));
  EXPECT_EQ(shop_.Status("one").state, intaglio_JOB_DISCRETIZING);
  Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100);
  EXPECT_TRUE(Reaches(intaglio_JOB_SORTING));
}

TEST_F(ForgedReports, HealthOfAnotherEndsAndOffersNothing) {
  RunToEngraving();
  const std::string y = shop_.FullName("y");
  for (Forger* forger : {&forger_in_stage_, &forger_in_cell_}) {
    forger->Health(y, intaglio_ROLE_SYNCHRONIZER, intaglio_HEALTH_FAULT);
    forger->Health(y, intaglio_ROLE_SORTER, intaglio_HEALTH_READY);
    forger->Dispose(y, intaglio_ROLE_SYNCHRONIZER);
  }
  ExpectUndisturbed(30);
  // A stage worker cannot offer itself as a synchronizer either.
  forger_in_stage_.Health(forger_in_stage_.OwnName(), intaglio_ROLE_SYNCHRONIZER,
                          intaglio_HEALTH_READY);
  ExpectUndisturbed(40);
  ExpectGoodEnd();
}

}  // namespace
}  // namespace intaglio::job_service
