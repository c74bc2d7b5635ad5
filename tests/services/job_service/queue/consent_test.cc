// A warning that a person has to accept before the arm.

#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

class ConsentTest : public JobQueueTest {
 protected:
  static Warnings MayBreak() {
    return {MakeWarning(WarningCode::kOddRays, "3 of 9 rays"),
            MakeWarning(WarningCode::kBreakage, "the glass may break at (1, 2, 3) mm")};
  }
  void SortEnds(const Warnings& warnings) {
    TaskView end = SortStatus(job().attempt, intaglio_TASK_DONE);
    end.warnings = warnings;
    Report(end);
  }
  void Load(const Warnings& warnings) {
    DiscretizeAll();
    SortEnds(warnings);
    Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, 100, {}, "waits for the arm");
  }
  CommandAnswer Accept() {
    CommandView command = Order(intaglio_COMMAND_ARM);
    command.accept_breakage = true;
    return Send(command);
  }
};

TEST_F(ConsentTest, AnArmWithoutItIsRefusedWithPlaceAndRemedy) {
  ReadyAll();
  Add(1);
  Load(MayBreak());
  EXPECT_EQ(job().state, intaglio_JOB_WAITING_FOR_ARM);
  EXPECT_THAT(job().message, HasSubstr("(1, 2, 3) mm"));
  EXPECT_THAT(job().message, HasSubstr("--accept breakage"));
  for (const auto kind : {intaglio_COMMAND_ARM, intaglio_COMMAND_RESUME}) {
    const CommandAnswer refused = Send(Order(kind));
    EXPECT_EQ(refused.code, intaglio_ANSWER_NEEDS_CONSENT);
    EXPECT_THAT(refused.message, HasSubstr("(1, 2, 3) mm"));
    EXPECT_THAT(refused.message, HasSubstr("intaglio arm 1 --accept breakage"));
  }
  now_ += 5s;
  EXPECT_FALSE(job().arm.armed());
  EXPECT_FALSE(Granted());
  EXPECT_TRUE(Accept().taken());
  now_ += 1s;
  EXPECT_TRUE(Granted());
  EXPECT_EQ(job().message, "");
  EXPECT_EQ(actions_.kept.at("j1").arm.kept().breakage_accepted_by, "ann@shop");
}

TEST_F(ConsentTest, AnArmFromBeforeTheWarningEndsWithIt) {
  ReadyAll();
  Add(1);
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
  const std::uint64_t before = job().arm.disarm_count();
  DiscretizeAll();
  // The machine has the path, and the sorter's report is still on its way.
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, 100, {}, "waits");
  now_ += 5s;
  EXPECT_EQ(job().state, intaglio_JOB_WAITING_FOR_ARM);
  EXPECT_TRUE(job().arm.armed());
  EXPECT_FALSE(Granted()) << "nothing fires before all warnings are known";
  SortEnds(MayBreak());
  now_ += 5s;
  EXPECT_FALSE(job().arm.armed());
  EXPECT_GT(job().arm.disarm_count(), before) << "an arm that is on its way is too late";
  EXPECT_THAT(job().arm.disarm_reason(), HasSubstr("(1, 2, 3) mm"));
  EXPECT_FALSE(Granted());
}

// A small job may reach the machine before the discretizer's report reaches the queue.
TEST_F(ConsentTest, NothingIsGrantedBeforeTheReportOfThePoints) {
  ReadyAll();
  Add(1);
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
  SortEnds({});
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, 100, {}, "waits");
  now_ += 1s;
  EXPECT_EQ(job().state, intaglio_JOB_WAITING_FOR_ARM);
  EXPECT_FALSE(Granted());
  TaskView points = PartReport(0, intaglio_TASK_DONE);
  points.warnings = MayBreak();
  Report(points);
  now_ += 1s;
  EXPECT_THAT(job().warnings, SizeIs(2)) << "the report counts, though it comes last";
  EXPECT_FALSE(job().arm.armed());
  EXPECT_FALSE(Granted());
  EXPECT_TRUE(Accept().taken());
  now_ += 1s;
  EXPECT_TRUE(Granted());
}

TEST_F(ConsentTest, ConsentThatIsGivenAheadCountsAndOutlastsADisarming) {
  ReadyAll();
  Add(1);
  EXPECT_TRUE(Accept().taken());
  Load(MayBreak());
  now_ += 1s;
  EXPECT_TRUE(Granted());
  EXPECT_TRUE(Command(intaglio_COMMAND_PAUSE));
  EXPECT_FALSE(Granted());
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM)) << "it belongs to the job";
}

TEST_F(ConsentTest, OtherWarningsNeedNone) {
  ReadyAll();
  Add(1);
  EXPECT_TRUE(Command(intaglio_COMMAND_ARM));
  Load({MakeWarning(WarningCode::kOddRays, "3 of 9 rays")});
  now_ += 1s;
  EXPECT_TRUE(Granted());
  EXPECT_THAT(job().warnings, SizeIs(1));
}

TEST_F(ConsentTest, ASorterThatIsLostBeforeItsReportCostsTheAttempt) {
  ReadyAll();
  Add(1);
  DiscretizeAll();
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 0, 100, {}, "waits");
  Lose("s");
  EXPECT_EQ(job().state, intaglio_JOB_QUEUED);
}

TEST_F(ConsentTest, AnotherAttemptHasItsOwnWarnings) {
  ReadyAll();
  Add(1);
  DiscretizeAll();
  SortEnds(MayBreak());
  Lose("y");
  ASSERT_EQ(job().state, intaglio_JOB_QUEUED);
  Ready("y2", intaglio_ROLE_SYNCHRONIZER);
  queue_.Turn(now_);
  ASSERT_EQ(job().state, intaglio_JOB_DISCRETIZING);
  EXPECT_THAT(job().warnings, SizeIs(0));
}

}  // namespace
}  // namespace intaglio::job_service
