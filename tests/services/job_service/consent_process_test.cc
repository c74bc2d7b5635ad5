// The real job service: it refuses an arm without a consent, whatever the client, and
// keeps warnings and consent over a restart.

#include <SQLiteCpp/SQLiteCpp.h>
#include <gmock/gmock.h>

#include <optional>

#include "services/job/verdict/warnings.h"
#include "tests/services/job/test_job.h"
#include "tests/services/job_service/fake_shop.h"
#include "tests/test_folder.h"

namespace intaglio::job_service {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class ConsentProcessTest : public testing::Test {
 protected:
  void Start() { service_.emplace(folder_, test::PrivateTag()); }
  StatusCopy Job() { return shop_.Status("one"); }
  bool Reaches(intaglio_JobState state) {
    const bool reached = shop_.Until([&] { return Job().state == state; });
    EXPECT_TRUE(reached) << Job().state << ": " << Job().message;
    return reached;
  }
  void Report(intaglio_Stage stage, intaglio_TaskState state, std::uint64_t done,
              const StageOutcome& outcome = {}) {
    shop_.Report(shop_.Task(stage), stage, state, done, 100, intaglio_ERROR_NONE, "",
                 outcome);
  }
  void ReadyAll() {
    shop_.Health(intaglio_STAGE_DISCRETIZE, "d", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_SORT, "s", intaglio_HEALTH_READY);
    shop_.Health(intaglio_STAGE_ENGRAVE, "y", intaglio_HEALTH_READY);
  }
  /// A path whose glass may break, in the synchronizer.
  void LoadPath(std::uint32_t attempt) {
    ReadyAll();
    ASSERT_TRUE(shop_.Until([&] {
      for (const auto stage :
           {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE}) {
        const TaskCopy task = shop_.Task(stage);
        if (task.attempt != attempt || task.revoked) return false;
      }
      return true;
    }));
    StageOutcome points, path;
    points.mutable_discretize()->add_methods()->set_odd_ray_count(3);
    *path.mutable_sort()->add_warnings() = RecordOf(
        MakeWarning(WarningCode::kBreakage, "the glass may break at (1, 2, 3) mm"));
    Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100, points);
    ASSERT_TRUE(Reaches(intaglio_JOB_SORTING));
    Report(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100, path);
    Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0);
    ASSERT_TRUE(Reaches(intaglio_JOB_WAITING_FOR_ARM));
    ASSERT_TRUE(shop_.Until([&] { return Job().warnings.size() == 2; }));
  }

  fs::path folder_ = test::FreshFolder();
  FakeShop shop_{test::PrivateBusOptions()};
  std::optional<ServiceProcess> service_;
};

TEST_F(ConsentProcessTest, AnArmWithoutConsentIsRefusedAndOneWithItFires) {
  Start();
  shop_.Submit("one", GoodJob());
  LoadPath(1);
  EXPECT_EQ(Job().warnings[0].code, WarningCode::kOddRays);
  EXPECT_EQ(Job().warnings[1].weight, WarningWeight::kConsent);
  EXPECT_THAT(Job().message, HasSubstr("(1, 2, 3) mm"));
  EXPECT_THAT(Job().message, HasSubstr("intaglio arm 1 --accept breakage"));
  shop_.Command(Job(), intaglio_COMMAND_ARM, 1);
  EXPECT_EQ(shop_.AnswerTo(1), intaglio_ANSWER_NEEDS_CONSENT);
  shop_.Command(Job(), intaglio_COMMAND_RESUME, 2);
  EXPECT_EQ(shop_.AnswerTo(2), intaglio_ANSWER_NEEDS_CONSENT);
  EXPECT_FALSE(shop_.granted());
  shop_.Accept(Job(), 3);
  EXPECT_EQ(shop_.AnswerTo(3), intaglio_ANSWER_TAKEN);
  EXPECT_TRUE(shop_.Until([&] { return shop_.granted(); }));
  EXPECT_EQ(Job().breakage_accepted_by, "ann@shop");
}

// Discretizer, sorter and machine are processes of their own, whose reports come in any
// order: a small job's points may be in the machine before the report about them.
TEST_F(ConsentProcessTest, NothingIsGrantedBeforeTheReportOfThePoints) {
  Start();
  shop_.Submit("one", GoodJob());
  ReadyAll();
  ASSERT_TRUE(shop_.Until([&] { return shop_.Task(intaglio_STAGE_SORT).attempt == 1; }));
  Report(intaglio_STAGE_SORT, intaglio_TASK_DONE, 100);
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0);
  ASSERT_TRUE(Reaches(intaglio_JOB_WAITING_FOR_ARM));
  EXPECT_THAT(Job().message, HasSubstr("waits for the report about part 1 of 1"));
  shop_.Command(Job(), intaglio_COMMAND_ARM, 1);
  EXPECT_EQ(shop_.AnswerTo(1), intaglio_ANSWER_TAKEN);
  EXPECT_FALSE(shop_.granted());
  StageOutcome points;
  points.mutable_discretize()->add_methods()->set_odd_ray_count(3);
  Report(intaglio_STAGE_DISCRETIZE, intaglio_TASK_DONE, 100, points);
  EXPECT_TRUE(shop_.Until([&] { return shop_.granted(); }));
  ASSERT_EQ(Job().warnings.size(), 1u);
  EXPECT_EQ(Job().warnings[0].code, WarningCode::kOddRays);
}

TEST_F(ConsentProcessTest, BothOutlastTheProcess) {
  Start();
  shop_.Submit("one", GoodJob());
  LoadPath(1);
  const Warnings warnings = Job().warnings;
  shop_.Accept(Job(), 1);
  ASSERT_TRUE(shop_.Until([&] { return shop_.granted(); }));
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 10);
  ASSERT_TRUE(Reaches(intaglio_JOB_ENGRAVING));
  service_->Kill();
  Start();
  ASSERT_TRUE(Reaches(intaglio_JOB_PAUSED));
  EXPECT_EQ(Job().warnings, warnings);
  EXPECT_EQ(Job().breakage_accepted_by, "ann@shop");
  StageOutcome glass;
  glass.mutable_engrave()->set_planned_count(100);
  glass.mutable_engrave()->set_made_count(100);
  Report(intaglio_STAGE_ENGRAVE, intaglio_TASK_DONE, 100, glass);
  ASSERT_TRUE(Reaches(intaglio_JOB_DONE));
  EXPECT_EQ(service_->Stop(), 0);
  const SQLite::Database database((folder_ / "jobs.db").string(), SQLite::OPEN_READONLY);
  SQLite::Statement select(database, "SELECT verdict FROM jobs");
  ASSERT_TRUE(select.executeStep());
  EXPECT_EQ(select.getColumn(0).getString(), "good_with_warnings");
}

}  // namespace
}  // namespace intaglio::job_service
