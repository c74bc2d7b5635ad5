#include "services/console/arm_holds.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::console {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr char kBlock[] = "50 x 50 x 30 N-BK7, f43";

client::JobView JobWith(const std::string& uid) {
  client::JobView job;
  job.uid = uid;
  job.cell = "els-03";
  job.disarm_count = 7;
  return job;
}

class Holds : public ::testing::Test {
 protected:
  /// What is wrong with the end of a hold that began at 0, `after` it; empty: nothing.
  std::string WhyNot(std::chrono::milliseconds after, const std::string& uid = "7-a",
                     const std::string& block = kBlock) {
    const std::string token = holds_.Begin(JobWith("7-a"), kBlock, start_);
    const auto job = holds_.End(token, uid, block, start_ + after);
    return job ? "" : job.error().message;
  }
  ArmHolds holds_;
  ArmHolds::Clock::time_point start_{};
};

TEST_F(Holds, EndAfterTheHoldAndBeforeTheyAreLate) {
  EXPECT_THAT(WhyNot(0ms), HasSubstr("not held long enough"));
  EXPECT_THAT(WhyNot(ArmHolds::kHoldTime - 1ms), HasSubstr("not held long enough"));
  EXPECT_EQ(WhyNot(ArmHolds::kHoldTime), "");
  EXPECT_EQ(WhyNot(ArmHolds::kHoldTime + ArmHolds::kEndTime), "");
  EXPECT_THAT(WhyNot(ArmHolds::kHoldTime + ArmHolds::kEndTime + 1ms),
              HasSubstr("too long ago"));
}

TEST_F(Holds, AreOfOneJobAndOneBlock) {
  EXPECT_THAT(WhyNot(ArmHolds::kHoldTime, "8-a"), HasSubstr("another job"));
  EXPECT_THAT(WhyNot(ArmHolds::kHoldTime, "7-a", "60 x 30 x 20 N-BK7"),
              HasSubstr("another block"));
}

TEST_F(Holds, CountOnceAlsoWhenTheyWereRefused) {
  const auto end = start_ + ArmHolds::kHoldTime;
  const std::string good = holds_.Begin(JobWith("7-a"), kBlock, start_);
  const auto job = holds_.End(good, "7-a", kBlock, end);
  ASSERT_TRUE(job);
  EXPECT_EQ(job->disarm_count, 7u) << "as it was when the hold began";
  EXPECT_FALSE(holds_.End(good, "7-a", kBlock, end));
  const std::string early = holds_.Begin(JobWith("7-a"), kBlock, start_);
  EXPECT_FALSE(holds_.End(early, "7-a", kBlock, start_));
  EXPECT_FALSE(holds_.End(early, "7-a", kBlock, end));
  EXPECT_FALSE(holds_.End("", "7-a", kBlock, end));
}

TEST_F(Holds, ANewPressEndsTheOneBeforeAndTheyAreFew) {
  const auto end = start_ + ArmHolds::kHoldTime;
  const std::string old = holds_.Begin(JobWith("7-a"), kBlock, start_);
  const std::string young = holds_.Begin(JobWith("7-a"), kBlock, start_);
  EXPECT_FALSE(holds_.End(old, "7-a", kBlock, end));
  for (std::size_t i = 0; i < ArmHolds::kMaxCount; ++i)
    holds_.Begin(JobWith("other-" + std::to_string(i)), kBlock, start_);
  EXPECT_FALSE(holds_.End(young, "7-a", kBlock, end));
}

class ObstacleAt : public ::testing::Test {
 protected:
  ObstacleAt() {
    client::CellSnapshot& machine = shop_.cells["els-03"];
    machine.has_interlock = machine.laser_line_up = true;
    machine.key_on = machine.door_closed = true;
    shop_.mounts["els-03"].parts.piece = "FR4, 1.6 mm";
  }
  std::string Code() const { return ObstacleOf(shop_, "els-03").code; }
  client::ShopSnapshot shop_;
};

TEST_F(ObstacleAt, AReadyMachineIsNone) {
  EXPECT_EQ(Code(), "");
  EXPECT_EQ(BlockIn(shop_, "els-03"), "FR4, 1.6 mm");
}

TEST_F(ObstacleAt, APieceThatIsReportedByTheSameTextIsAnotherReport) {
  const std::string before = ReportIn(shop_, "els-03");
  EXPECT_EQ(ReportIn(shop_, "els-03"), before);
  shop_.mounts["els-03"].mounted_utc = "2026-11-23T07:58:40.031Z";
  EXPECT_NE(ReportIn(shop_, "els-03"), before);
}

TEST_F(ObstacleAt, WhatIsOpenOrNotKnownIsOne) {
  client::CellSnapshot& machine = shop_.cells["els-03"];
  shop_.mounts.clear();
  EXPECT_EQ(Code(), "not_mounted");
  machine.open_input = "the input 'clamp' is off: close the clamp";
  EXPECT_EQ(Code(), "input_open");
  EXPECT_EQ(ObstacleOf(shop_, "els-03").message,
            "els-03: the input 'clamp' is off: close the clamp");
  machine.door_closed = false;
  EXPECT_EQ(Code(), "door_open");
  EXPECT_THAT(ObstacleOf(shop_, "els-03").message, HasSubstr("the door is open"));
  machine.stop_released = machine.key_on = false;
  EXPECT_THAT(ObstacleOf(shop_, "els-03").message, HasSubstr("key, door or stop"));
  machine.stop_released = true;
  EXPECT_EQ(Code(), "key_off");
  machine.stop_pressed = true;
  EXPECT_EQ(Code(), "stop_pressed");
  machine.laser_line_up = false;
  EXPECT_EQ(Code(), "line_down");
  EXPECT_EQ(ObstacleOf(shop_, "els-04").code, "line_down") << "there is no such machine";
}

TEST_F(ObstacleAt, AServiceOfAnotherVersionIsOneWhateverItReports) {
  client::ServiceView job_service, synchronizer;
  job_service.role = intaglio_ROLE_JOB_SERVICE;
  job_service.version = synchronizer.version = "0.1.0+2d4f07c1";
  synchronizer.role = intaglio_ROLE_SYNCHRONIZER;
  synchronizer.cell = "els-03";
  shop_.services = {job_service, synchronizer};
  EXPECT_EQ(Code(), "");
  shop_.services[1].version = "0.1.0+a95349f5";
  EXPECT_EQ(Code(), "other_version");
  EXPECT_THAT(ObstacleOf(shop_, "els-03").message, HasSubstr("els-03"));
  shop_.services[1].cell = "els-04";
  EXPECT_EQ(Code(), "") << "another machine's";
}

}  // namespace
}  // namespace intaglio::console
