// When a client arms, and when it leaves that to a person.

#include "services/client/arm_once.h"

#include <gmock/gmock.h>

#include <sstream>
#include <thread>

#include "services/cli/status/command_effect.h"
#include "services/client/exit_codes.h"
#include "tests/services/client/job_client_rig.h"
#include "tests/services/job/test_job.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ArmOnceTest = JobClientTest;

TEST_F(ArmOnceTest, ArmsWhenTheMachineHasTheJobAndElseLeavesItQueued) {
  Start();
  const auto job = ann_.Submit(GoodJob(), 10s);
  ASSERT_TRUE(job.has_value());
  const auto late = ArmWhenTaken(ann_, *job, {}, 500ms);
  ASSERT_FALSE(late.has_value());
  EXPECT_THAT(late.error().message, HasSubstr("job 1 stays queued and is not armed"));
  EXPECT_THAT(late.error().message, HasSubstr("intaglio arm 1"));
  shop_.ready = true;
  EXPECT_TRUE(ArmWhenTaken(ann_, *job, {}, 10s).has_value());
  OfBob(job->uid);
  EXPECT_EQ(StateOf(BobAwaits(job->uid,
                              [](const JobView& view) {
                                // The machine's report may come before the sorter's.
                                return view.armed && view.message.empty() &&
                                       view.state == intaglio_JOB_WAITING_FOR_ARM;
                              })),
            "armed");
}

// As by a machine that refuses the run when it is at work already.
TEST_F(ArmOnceTest, AnArmThatIsLostJustBehindTheBeginOfTheWorkHasNoEffect) {
  Start();
  shop_.ready = shop_.slow = true;
  const auto job = ann_.Submit(GoodJob(), 10s);
  ASSERT_TRUE(job.has_value());
  OfBob(job->uid);
  std::jthread pauses([&] {
    const auto works = [](const JobView& view) {
      return view.state == intaglio_JOB_ENGRAVING;
    };
    (void)bob_.Command(BobAwaits(job->uid, works), {.kind = intaglio_COMMAND_PAUSE});
  });
  ASSERT_TRUE(ArmWhenTaken(ann_, *job, {.basis = intaglio_ARM_BY_PERSON}, 10s));
  std::ostringstream out;
  ::testing::internal::CaptureStderr();
  EXPECT_EQ(cli::AwaitEffect(ann_, *job, intaglio_COMMAND_ARM, out), kExitMachine);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(),
              HasSubstr("was armed and is disarmed again, operator: paused by"));
}

// Two people at one machine: what one has put in is not what the other has armed.
TEST_F(ArmOnceTest, AnArmThatWaitsForItsMachineIsNotForWhatIsMountedAfterIt) {
  Start();
  const MountedParts first{.piece = "plate A"}, second{.piece = "plate B"};
  ASSERT_TRUE(ann_.Mount("els-03", first, intaglio_ARM_BY_PERSON));
  ASSERT_TRUE(ann_.PollUntil([&] { return ann_.mounts().contains("els-03"); }, 10s));
  const auto job = ann_.Submit(GoodJob(), 10s);
  ASSERT_TRUE(job.has_value());
  ArmOnce arm(ann_, *job, {.basis = intaglio_ARM_BY_PERSON});
  EXPECT_EQ(arm.Follow(*job), ArmOnce::State::kWaits);
  OfBob(job->uid);
  ASSERT_TRUE(bob_.Mount("els-03", second, intaglio_ARM_BY_PERSON));
  shop_.ready = true;
  const auto settled = [&] {
    return arm.Follow(ann_.jobs().at(job->uid)) != ArmOnce::State::kWaits;
  };
  ASSERT_TRUE(ann_.PollUntil(settled, 20s));
  EXPECT_EQ(arm.state(), ArmOnce::State::kLeft);
  EXPECT_THAT(arm.reason(), HasSubstr("has reported what is mounted, plate B"));
}

// A piece of another job that came in between is in the machine then.
TEST_F(ArmOnceTest, AnArmThatWaitsIsAProgramsWhenAnotherJobGetsTheMachineFirst) {
  Start();
  const auto job = ann_.Submit(GoodJob(), 10s);
  const auto other = bob_.Submit(GoodJob(), 10s);
  ASSERT_TRUE(job && other);
  ArmOnce arm(ann_, *job, {.basis = intaglio_ARM_BY_PERSON});
  const auto follow = [&] { return arm.Follow(ann_.jobs().at(job->uid)); };
  ASSERT_TRUE(
      bob_.Command(*other, {.kind = intaglio_COMMAND_MOVE, .before_job_uid = job->uid}));
  shop_.ready = true;
  const auto waits_for_arm = [&](const JobView& view) {
    return view.state == intaglio_JOB_WAITING_FOR_ARM;
  };
  const JobView first = BobAwaits(other->uid, waits_for_arm);
  ASSERT_TRUE(ann_.PollUntil(
      [&] {
        (void)follow();
        return ann_.jobs().contains(other->uid) &&
               waits_for_arm(ann_.jobs().at(other->uid));
      },
      10s));
  ASSERT_TRUE(bob_.Command(
      first, {.kind = intaglio_COMMAND_ARM, .basis = intaglio_ARM_BY_PERSON}));
  ann_.Poll(1s);
  ASSERT_TRUE(
      bob_.Command(bob_.jobs().at(other->uid), {.kind = intaglio_COMMAND_CANCEL}));
  const auto awaits = [&] {
    (void)follow();
    return ann_.jobs().at(job->uid).awaits_block &&
           waits_for_arm(ann_.jobs().at(job->uid));
  };
  ASSERT_TRUE(ann_.PollUntil(awaits, 20s));
  EXPECT_EQ(follow(), ArmOnce::State::kWaits);
  EXPECT_THAT(arm.WhatBlockItAwaits(ann_.jobs().at(job->uid)),
              HasSubstr("neither key nor door"));
}
}  // namespace
}  // namespace intaglio::client
