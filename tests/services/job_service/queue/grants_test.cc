// The grant that a permission carries, and the emergency stop that takes it away.

#include "tests/services/job_service/queue/queue_bench.h"

namespace intaglio::job_service {
namespace {

using testing::HasSubstr;

class JobGrantTest : public JobQueueTest {};

// By this the synchronizer recognises a new arm.
TEST_F(JobGrantTest, EveryArmIsAGreaterGrantAndNothingElseIs) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  const auto grant = [this] { return queue_.Permissions(now_).at(0).grant; };
  const std::uint64_t first = grant();
  EXPECT_GT(first, 0u);
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_RUNNING, 12, 100);
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_FAULT,
       "the door");
  now_ += 1s;
  EXPECT_EQ(grant(), first);
  EXPECT_TRUE(Command(intaglio_COMMAND_RESUME));
  const std::uint64_t second = grant();
  EXPECT_GT(second, first);
  // Resumed before the report of another fault was here: a person has asked for it all
  // the same.
  EXPECT_TRUE(Command(intaglio_COMMAND_RESUME));
  EXPECT_TRUE(Granted());
  EXPECT_GT(grant(), second);
}

TEST_F(JobGrantTest, ALostLineRenewsTheGrantAndAnArmDoesNotNeedTo) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  const PermissionView before = queue_.Permissions(now_).at(0);
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_LINE_LOST,
       "the line");
  now_ += 5s;
  const PermissionView after = queue_.Permissions(now_).at(0);
  EXPECT_TRUE(after.granted);
  EXPECT_EQ(after.grant, before.grant);
  EXPECT_GT(after.renewal, before.renewal);
}

TEST_F(JobGrantTest, AnEmergencyStopDisarmsItsCellAndKeepsItSo) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  queue_.SetStop("another cell", true, now_);
  EXPECT_TRUE(Granted());
  queue_.SetStop("c", true, now_);
  EXPECT_FALSE(Granted());
  // Nor by itself: the line was lost at the same time.
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_LINE_LOST,
       "the line");
  const CommandAnswer pressed = Send(Order(intaglio_COMMAND_RESUME));
  EXPECT_EQ(pressed.code, intaglio_ANSWER_STOP_PRESSED);
  EXPECT_THAT(pressed.message, HasSubstr("intaglio stop c --reset"));
  now_ += 5s;
  EXPECT_FALSE(Granted());
  queue_.SetStop("c", false, now_);
  EXPECT_FALSE(Granted()) << "a reset is no arm";
  EXPECT_TRUE(Command(intaglio_COMMAND_RESUME));
  EXPECT_TRUE(Granted());
}

TEST_F(JobGrantTest, FiringUncertainPointsIsAllowedByItsOwnGrantAlone) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  const auto permission = [this] { return queue_.Permissions(now_).at(0); };
  EXPECT_FALSE(permission().fire_uncertain);
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_FAULT,
       "look");
  EXPECT_TRUE(ResumeFiringUncertain().taken());
  now_ += 1s;
  const PermissionView asked = permission();
  EXPECT_TRUE(asked.granted);
  EXPECT_TRUE(asked.fire_uncertain);
  EXPECT_THAT(job().message, HasSubstr("uncertain points are fired"));
  // Gone on with by itself, it is the same grant.
  Task(intaglio_STAGE_ENGRAVE, intaglio_TASK_PAUSED, 12, 100, intaglio_PAUSE_LINE_LOST,
       "the line");
  now_ += 5s;
  EXPECT_EQ(permission().grant, asked.grant);
  EXPECT_TRUE(permission().fire_uncertain);
  EXPECT_TRUE(Command(intaglio_COMMAND_RESUME));
  EXPECT_GT(permission().grant, asked.grant);
  EXPECT_FALSE(permission().fire_uncertain);
}

// Every command is another grant, whatever becomes of it.
TEST_F(JobGrantTest, TheNextCommandTakesThatBack) {
  ReadyAll();
  Add(1);
  LoadPath();
  Engrave();
  const auto allows = [this] { return queue_.Permissions(now_).at(0).fire_uncertain; };
  EXPECT_TRUE(ResumeFiringUncertain().taken());
  EXPECT_TRUE(allows());
  EXPECT_TRUE(Command(intaglio_COMMAND_PAUSE));
  EXPECT_FALSE(allows());
  EXPECT_TRUE(ResumeFiringUncertain().taken());
  queue_.SetStop("c", true, now_);
  EXPECT_FALSE(allows());
  EXPECT_FALSE(ResumeFiringUncertain().taken()) << "the stop is pressed";
  EXPECT_FALSE(allows());
}

}  // namespace
}  // namespace intaglio::job_service
