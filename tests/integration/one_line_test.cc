// A cell whose controller moves the stage and switches the laser over one line, through
// the real processes: the synchronizer's laser is what the motion bridge serves. Each of
// the two is killed in mid-job. The glass is the judge.

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <iostream>
#include <thread>

#include "tests/integration/shop_floor.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using namespace intaglio::testing;

constexpr int kRateHz = 100;

class OneLine : public ::testing::TestWithParam<std::string> {
 protected:
  static ShopFloor::Options WithOneLine() {
    ShopFloor::Options options;
    options.bus = {"--domain", "58", "--tag", "one" + std::to_string(getpid())};
    options.one_line = true;
    return options;
  }
  void SetUp() override {
    ASSERT_FALSE(UndisturbedPoints().empty());
    floor_.StartAll();
  }
  bool Begin(std::int64_t cracks) {
    return floor_.Engrave() && floor_.AwaitCracks(cracks, 40s);
  }
  void ExpectGood() {
    EXPECT_TRUE(floor_.Reaches("done", 60s)) << floor_.Logs();
    EXPECT_EQ(DifferenceOf(floor_.Cracks()), "") << floor_.Logs();
  }
  std::int64_t NewestCrack() {
    std::int64_t newest = 0;
    for (const auto& crack : floor_.Cracks())
      newest = std::max(newest, static_cast<std::int64_t>(crack.tick));
    return newest;
  }

  ShopFloor floor_{test::FreshFolder(), WithOneLine()};
};

TEST_F(OneLine, CarriesAWholeJob) {
  ASSERT_TRUE(Begin(1)) << floor_.Logs();
  ExpectGood();
}

class OneLineWithout : public OneLine {};
INSTANTIATE_TEST_SUITE_P(The, OneLineWithout, ::testing::Values(kBridge, kSynchronizer),
                         [](const auto& service) {
                           return std::string(service.param == kBridge ? "Bridge"
                                                                       : "Synchronizer");
                         });

TEST_P(OneLineWithout, ThatIsKilledFiresNothingMoreAndTheJobGoesOnWithTheNext) {
  ASSERT_TRUE(Begin(60)) << floor_.Logs();
  const std::int64_t killed_tick = floor_.Panel("tick");
  floor_.at(GetParam()).Signal(SIGKILL);
  std::this_thread::sleep_for(1s);
  EXPECT_EQ(floor_.Panel("shutters"), 0);
  const std::int64_t newest = NewestCrack(), cracks = floor_.Panel("cracks");
  std::cout << "  last crack " << newest - killed_tick << " ticks after the kill\n";
  // 250 ms of silence, in ticks; the same again for what a loaded computer adds.
  EXPECT_LT(newest - killed_tick, kRateHz / 2);
  std::this_thread::sleep_for(1s);
  EXPECT_EQ(floor_.Panel("cracks"), cracks);
  EXPECT_LT(cracks, static_cast<std::int64_t>(UndisturbedPoints().size()));
  floor_.Start(GetParam());
  ExpectGood();
}

}  // namespace
}  // namespace intaglio
