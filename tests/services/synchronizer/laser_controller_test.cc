#include "services/synchronizer/laser_controller.h"

#include <gtest/gtest.h>

#include "tests/services/link/faulty_line.h"
#include "tests/services/synchronizer/fake_laser.h"

namespace intaglio::synchronizer {
namespace {

using link::TickOutcome;
using std::chrono::milliseconds;

/// A laser whose host may die: the line stays in.
class LaserAndHosts : public ::testing::Test {
 protected:
  LaserAndHosts() {
    laser.Plug(End(to_laser, to_host));
    NewHost();
  }
  std::unique_ptr<link::ByteStream> End(std::shared_ptr<link::FaultyPipe> in,
                                        std::shared_ptr<link::FaultyPipe> out) {
    return std::make_unique<link::FaultyEnd>(std::move(in), std::move(out), random,
                                             [this] { return now; });
  }
  void NewHost() {
    host = std::make_unique<LaserController>(
        [this]() -> Result<std::unique_ptr<link::ByteStream>> {
          return End(to_host, to_laser);
        },
        [this] { return now; });
    StepFor(milliseconds(600));
    ASSERT_TRUE(host->up());
  }
  void StepFor(milliseconds time) {
    for (const auto end = now + time; now < end;) {
      now += milliseconds(1);
      laser.Poll();
      host->Poll([this](const link::PulseReport& r) { reports.push_back(r); },
                 [this](const link::PastReport& r) { pasts.push_back(r); });
    }
  }
  void PassTicks(int count) {
    for (int i = 0; i < count; ++i) laser.AdvanceTick(true, Vec3::Zero());
  }

  std::chrono::nanoseconds now = std::chrono::seconds(1);
  std::shared_ptr<std::mt19937_64> random = std::make_shared<std::mt19937_64>(1);
  std::shared_ptr<link::FaultyPipe> to_laser = std::make_shared<link::FaultyPipe>();
  std::shared_ptr<link::FaultyPipe> to_host = std::make_shared<link::FaultyPipe>();
  FakeLaser laser{[this] { return now; }, false};
  std::unique_ptr<LaserController> host;
  std::vector<link::PulseReport> reports;
  std::vector<link::PastReport> pasts;
};

TEST_F(LaserAndHosts, WhatADeadHostArmedIsToldToTheNextWhenItAsks) {
  ASSERT_TRUE(host->Lamp(true, FakeLaser::kRateHz));
  StepFor(milliseconds(10));
  PassTicks(30);  // warm
  ASSERT_TRUE(host->OpenShutters(1));
  ASSERT_TRUE(host->Arm({31, true, {true, false, true, true}}));
  StepFor(milliseconds(10));
  host.reset();
  PassTicks(3);  // ticks 31..33; nobody hears of them
  reports.clear();
  NewHost();  // 34 is armed no longer
  PassTicks(1);
  ASSERT_TRUE(host->RequestPast(30, 6));
  ASSERT_TRUE(host->RequestPast(33, 1));
  StepFor(milliseconds(10));
  EXPECT_TRUE(reports.empty());
  ASSERT_EQ(pasts.size(), 2u);
  EXPECT_EQ(pasts[0].first_tick, 30u);
  EXPECT_EQ(pasts[0].outcome,
            (std::vector{TickOutcome::kNotArmed, TickOutcome::kFiredSeen,
                         TickOutcome::kNotArmed, TickOutcome::kFiredSeen,
                         TickOutcome::kNotArmed, TickOutcome::kNotArmed}));
  EXPECT_EQ(pasts[1].outcome, std::vector{TickOutcome::kFiredSeen});
}

TEST_F(LaserAndHosts, AQuestionThatTheLineDoesNotTakeIsNotAsked) {
  to_laser->cut = to_host->cut = true;
  StepFor(milliseconds(300));
  EXPECT_FALSE(host->RequestPast(1, 1));
  to_laser->cut = to_host->cut = false;
  StepFor(milliseconds(300));
  EXPECT_TRUE(host->RequestPast(1, 1));
  StepFor(milliseconds(10));
  EXPECT_EQ(pasts.size(), 1u);
}

}  // namespace
}  // namespace intaglio::synchronizer
