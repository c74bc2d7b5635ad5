// An arm is a person's statement about the block that is in the machine now: what ends
// it, through the real processes. The glass is the judge.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include "tests/integration/shop_floor.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using namespace intaglio::testing;
using ::testing::HasSubstr;

class Arm : public ::testing::Test {
 protected:
  static ShopFloor::Options OnABusOfItsOwn() {
    ShopFloor::Options options;
    options.bus = {"--domain", "49", "--tag", "arm" + std::to_string(getpid())};
    return options;
  }

  /// In mid-job, at a rate that leaves seconds of it.
  void EngraveSome() {
    floor_.StartAll();
    job_ = floor_.Engrave({"--height", "4.2", "--spacing", "0.5", "--rate", "25"});
    ASSERT_TRUE(job_);
    ASSERT_TRUE(floor_.AwaitCracks(20, 40s)) << floor_.Logs();
  }
  /// Longer than lamp, services and every renewal of a permission take.
  void ExpectNothingFires() {
    const std::int64_t cracks = floor_.Panel("cracks");
    ASSERT_GE(cracks, 0);
    std::this_thread::sleep_for(5s);
    EXPECT_EQ(floor_.Panel("cracks"), cracks) << floor_.Logs();
  }
  void ExpectAnArmLetsItFire() {
    const std::int64_t cracks = floor_.Panel("cracks");
    const Ended resumed = floor_.Type({"resume", *job_});
    EXPECT_EQ(resumed.exit_code, 0) << resumed.output;
    EXPECT_TRUE(floor_.AwaitCracks(cracks + 5, 20s)) << floor_.Logs();
  }

  ShopFloor floor_{test::FreshFolder(), OnABusOfItsOwn()};
  std::optional<std::string> job_;
};

// Host and laser of the cell lose their power, a person changes the block, and the power
// comes back. The job service runs on another host.
TEST_F(Arm, IsEndedByAPowerCycleOfTheMachine) {
  EngraveSome();
  for (const char* gone : {kSynchronizer, kBridge, "machine"}) {
    floor_.at(gone).Signal(SIGKILL);
    floor_.at(gone).WaitForEnd(5s);
  }
  floor_.StartMachine();
  floor_.Start(kBridge);
  floor_.Start(kSynchronizer);
  ASSERT_TRUE(
      Eventually([&] { return floor_.Newest("pause_reason") == "machine_changed"; }, 20s))
      << floor_.Logs();
  ExpectNothingFires();
  EXPECT_EQ(floor_.Panel("cracks"), 0) << "the new block";
  EXPECT_EQ(floor_.Newest("state"), "paused");
  ExpectAnArmLetsItFire();
}

TEST_F(Arm, IsEndedByClosingTheShop) {
  EngraveSome();
  floor_.at(kJobService).Signal(SIGTERM);
  EXPECT_EQ(floor_.at(kJobService).WaitForEnd(10s).exit_code, 0);
  floor_.Start(kJobService);
  ASSERT_TRUE(floor_.Opens());
  ExpectNothingFires();
  EXPECT_THAT(floor_.Type({"show", *job_}).output, HasSubstr("the shop was closed"));
  ExpectAnArmLetsItFire();
}

TEST_F(Arm, IsEndedByClosingTheCell) {
  EngraveSome();
  floor_.at(kSynchronizer).Signal(SIGTERM);
  EXPECT_EQ(floor_.at(kSynchronizer).WaitForEnd(10s).exit_code, 0);
  floor_.Start(kSynchronizer);
  ASSERT_TRUE(Eventually(
      [&] {
        return floor_.Newest("message").find("continues the job") != std::string::npos;
      },
      20s))
      << floor_.Logs();
  ExpectNothingFires();
  ExpectAnArmLetsItFire();
}

// The points are sorted for some seconds meanwhile.
TEST_F(Arm, IsEndedByADoorThatOpensBeforeThePathIsThere) {
  floor_.StartAll();
  job_ = floor_.Engrave({"--height", "4.2", "--spacing", "0.5", "--order-time", "8"});
  ASSERT_TRUE(job_);
  ASSERT_TRUE(floor_.Reaches("ordering", 10s)) << floor_.Logs();
  AskPanel(floor_.folder(), "door open");
  ASSERT_TRUE(Eventually(
      [&] { return floor_.Newest("message").find("door is open") != std::string::npos; },
      10s))
      << floor_.Logs();
  AskPanel(floor_.folder(), "door close");
  EXPECT_EQ(floor_.Newest("state"), "ordering") << "or the test tests nothing";
  ASSERT_TRUE(Eventually(
      [&] {
        const std::string state = floor_.Newest("state");
        return state == "waiting_for_arm" || state == "paused";
      },
      20s))
      << floor_.Logs();
  ExpectNothingFires();
  EXPECT_EQ(floor_.Panel("cracks"), 0);
  EXPECT_THAT(floor_.Newest("message"), HasSubstr("door"));
  ExpectAnArmLetsItFire();
}

}  // namespace
}  // namespace intaglio
