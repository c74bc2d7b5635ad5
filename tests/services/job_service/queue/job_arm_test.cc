#include "services/job_service/records/job_arm.h"

#include <gtest/gtest.h>

namespace intaglio::job_service {
namespace {

using namespace std::chrono_literals;

CommandView Command(intaglio_JobCommandKind kind, std::uint64_t number = 1) {
  CommandView command;
  command.sender = "ann@shop-1";
  command.number = number;
  command.kind = kind;
  command.operator_name = "ann@shop";
  return command;
}

JobArm Armed(Nanoseconds now) {
  JobArm arm;
  arm.Note(Command(intaglio_COMMAND_ARM));
  arm.Arm(Command(intaglio_COMMAND_ARM), now);
  return arm;
}

TEST(JobArm, IsDisarmedAtFirst) {
  EXPECT_FALSE(JobArm().armed());
  EXPECT_FALSE(JobArm().MayFire(100s));
}

TEST(JobArm, FiresAtOnceAndAfterAWithdrawalWhenThatWasReceived) {
  JobArm arm = Armed(100s);
  EXPECT_TRUE(arm.MayFire(100s));
  arm.Disarm("the door is open", 101s);
  EXPECT_FALSE(arm.MayFire(200s));
  arm.Arm(Command(intaglio_COMMAND_RESUME), 101s + 100ms);
  EXPECT_TRUE(arm.armed());
  EXPECT_FALSE(arm.MayFire(101s + 299ms));
  EXPECT_TRUE(arm.MayFire(101s + 300ms));
}

// A lease of the permission is 90 ms: a withdrawal that lasts longer is noticed.
static_assert(JobArm::kHold > 90ms);

TEST(JobArm, AFaultShortlyAfterAnArmWasOfTheOneBefore) {
  JobArm arm = Armed(100s);
  EXPECT_TRUE(arm.IsOutdated(100s + 299ms));
  EXPECT_FALSE(arm.IsOutdated(100s + 300ms));
  EXPECT_FALSE(JobArm().IsOutdated(100s)) << "there is no arm that it could be about";
}

TEST(JobArm, EveryDisarmCounts) {
  JobArm arm;
  arm.Disarm("paused", 100s);
  EXPECT_EQ(arm.disarm_count(), 1u);
  EXPECT_EQ(arm.disarm_reason(), "paused");
  arm.Arm(Command(intaglio_COMMAND_ARM), 100s);
  EXPECT_TRUE(arm.MayFire(100s)) << "nothing was withdrawn";
}

TEST(JobArm, EveryCommandButASpeedIsAnotherGrant) {
  JobArm arm;
  std::uint64_t grant = arm.grant(), number = 0;
  EXPECT_GT(grant, 0u);
  for (const auto kind : {intaglio_COMMAND_ARM, intaglio_COMMAND_RESUME,
                          intaglio_COMMAND_PAUSE, intaglio_COMMAND_CANCEL}) {
    arm.Note(Command(kind, ++number));
    EXPECT_GT(arm.grant(), grant);
    grant = arm.grant();
  }
  arm.Note(Command(intaglio_COMMAND_SPEED, ++number));
  EXPECT_EQ(arm.grant(), grant);
  arm.Renew(0, 5, 100s);
  EXPECT_EQ(arm.grant(), grant) << "a renewal is of the same grant";
  EXPECT_EQ(arm.renewal(), 5u);
}

TEST(JobArm, KnowsTheCommandThatItAppliedLast) {
  JobArm arm;
  arm.Note(Command(intaglio_COMMAND_SPEED, 7));
  EXPECT_TRUE(arm.IsRepeated(Command(intaglio_COMMAND_SPEED, 7)));
  EXPECT_FALSE(arm.IsRepeated(Command(intaglio_COMMAND_SPEED, 8)));
}

TEST(JobArm, OnlyAResumeFiresUncertainPointsAndTheNextCommandTakesItBack) {
  JobArm arm;
  CommandView command = Command(intaglio_COMMAND_ARM);
  command.fire_uncertain = true;
  arm.Arm(command, 100s);
  EXPECT_FALSE(arm.kept().fire_uncertain);
  command.kind = intaglio_COMMAND_RESUME;
  arm.Arm(command, 100s);
  EXPECT_TRUE(arm.kept().fire_uncertain);
  arm.Note(Command(intaglio_COMMAND_SPEED, 2));
  EXPECT_TRUE(arm.kept().fire_uncertain);
  arm.Note(Command(intaglio_COMMAND_PAUSE, 3));
  EXPECT_FALSE(arm.kept().fire_uncertain);
}

TEST(JobArm, PointsAreLeftOutForGood) {
  JobArm arm;
  CommandView command = Command(intaglio_COMMAND_RESUME);
  command.from_point = 17;
  arm.Arm(command, 100s);
  arm.Arm(Command(intaglio_COMMAND_RESUME), 100s);
  EXPECT_EQ(arm.kept().first_point, 17u);
}

// 300 ms, then twice as long each time, 3 s at most; together a minute, then no more.
TEST(JobArm, IsRenewedLessAndLessOftenAndNotForEver) {
  JobArm arm = Armed(0s);
  Nanoseconds now = 0s, wait_before = 0s;
  std::uint32_t renewals = 0;
  for (;; ++renewals) {
    arm.Disarm("the line is down", now);
    arm.Renew(12, renewals + 1, now);
    if (!arm.armed()) break;
    Nanoseconds wait = 0s;
    while (!arm.MayFire(now + wait)) wait += 1ms;
    EXPECT_GE(wait, std::max<Nanoseconds>(wait_before, 300ms));
    EXPECT_LE(wait, 3s);
    wait_before = wait;
    now += wait;
    ASSERT_LT(renewals, 100u);
  }
  EXPECT_EQ(renewals, JobArm::kMaxRenewals);
  EXPECT_LE(now, 1min);
  // A person's arm begins anew, and so does a point that was made in between.
  arm.Arm(Command(intaglio_COMMAND_RESUME), now);
  for (std::uint64_t done = 13; done < 100; ++done) {
    arm.Disarm("the line is down", now);
    arm.Renew(done, 100 + done, now);
    EXPECT_TRUE(arm.armed());
  }
}

TEST(JobArm, AJobThatAsksIsNotRenewed) {
  JobArm arm(KeptArm{.asks_before_resume = true});
  arm.Renew(0, 1, 100s);
  EXPECT_FALSE(arm.armed());
}

TEST(JobArm, IsNotKeptDuringAnAbsence) {
  JobArm arm = Armed(100s);
  EXPECT_TRUE(arm.ToKeep().armed);
  arm.BeginAbsence(110s);
  arm.BeginAbsence(120s);
  EXPECT_FALSE(arm.ToKeep().armed);
  EXPECT_TRUE(arm.armed());
  EXPECT_FALSE(arm.IsAbsentForTooLong(140s));
  EXPECT_TRUE(arm.IsAbsentForTooLong(141s)) << "since the first loss";
  arm.Arm(Command(intaglio_COMMAND_RESUME), 150s);
  EXPECT_FALSE(arm.IsAbsentForTooLong(180s)) << "a person armed it meanwhile";
  arm.EndAbsence(180s);
  EXPECT_TRUE(arm.ToKeep().armed);
  EXPECT_FALSE(arm.IsAbsentForTooLong(1000s));
}

TEST(JobArm, AbsencesAreAddedUp) {
  JobArm arm = Armed(100s);
  arm.BeginAbsence(110s);
  arm.EndAbsence(135s);
  arm.BeginAbsence(136s);
  EXPECT_FALSE(arm.IsAbsentForTooLong(141s));
  EXPECT_TRUE(arm.IsAbsentForTooLong(142s)) << "25 s, and more than 5";
  arm.EndAbsence(150s);
  arm.BeginAbsence(180s);
  EXPECT_FALSE(arm.IsAbsentForTooLong(210s)) << "it was there for 30 s meanwhile";
}

TEST(JobArm, WhatSpendsAGrant) {
  EXPECT_FALSE(SpendsTheGrant(intaglio_PAUSE_NONE));
  EXPECT_FALSE(SpendsTheGrant(intaglio_PAUSE_NOT_ARMED));
  for (const auto reason : {intaglio_PAUSE_FAULT, intaglio_PAUSE_EMERGENCY_STOP,
                            intaglio_PAUSE_INTERLOCK, intaglio_PAUSE_MACHINE_CHANGED,
                            intaglio_PAUSE_UNCERTAIN_POINTS, intaglio_PAUSE_LINE_LOST}) {
    EXPECT_TRUE(SpendsTheGrant(reason)) << reason;
  }
}

}  // namespace
}  // namespace intaglio::job_service
