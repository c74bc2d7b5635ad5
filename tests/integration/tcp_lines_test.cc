// A cell whose machine hangs on two TCP lines, through the real processes: a whole job,
// and lines that are cut in mid-job. The glass is the judge.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <iostream>
#include <thread>

#include "tests/integration/shop_floor.h"
#include "tests/integration/tcp_relay.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using namespace intaglio::testing;
using ::testing::StartsWith;

constexpr int kRateHz = 100;
const std::vector<std::string> kLines = {"laser", "motion"};

class TcpLines : public ::testing::TestWithParam<std::string> {
 protected:
  static ShopFloor::Options OverTcp() {
    ShopFloor::Options options;
    options.bus = {"--domain", "57", "--tag", "tcp" + std::to_string(getpid())};
    options.lines_over_tcp = true;
    return options;
  }
  void SetUp() override { ASSERT_FALSE(UndisturbedPoints().empty()); }

  bool Begin(std::int64_t cracks) {
    return floor_.Engrave() && floor_.AwaitCracks(cracks, 40s);
  }
  void ExpectGood() {
    EXPECT_TRUE(floor_.Reaches("done", 60s)) << floor_.Logs();
    EXPECT_EQ(DifferenceOf(floor_.Cracks()), "") << floor_.Logs();
  }

  ShopFloor floor_{test::FreshFolder(), OverTcp()};
};

TEST_F(TcpLines, CarryAWholeJob) {
  floor_.StartAll();
  for (const std::string& line : kLines) {
    ASSERT_THAT(floor_.DeviceOf(line), StartsWith("tcp:127.0.0.1:"));
    EXPECT_FALSE(std::filesystem::exists(floor_.folder() / line)) << "no pseudo-terminal";
  }
  ASSERT_TRUE(Begin(1)) << floor_.Logs();
  ExpectGood();
}

class ATcpLine : public TcpLines {};
INSTANTIATE_TEST_SUITE_P(Of, ATcpLine, ::testing::ValuesIn(kLines),
                         [](const auto& line) { return line.param; });

// Its connection ends and its port is closed for a while.
TEST_P(ATcpLine, ThatIsPulledOutHaltsTheJobWhichGoesOn) {
  floor_.StartAll();
  ASSERT_TRUE(Begin(60)) << floor_.Logs();
  ASSERT_EQ(AskPanel(floor_.folder(), "unplug " + GetParam()), "ok\n");
  std::this_thread::sleep_for(500ms);
  const std::int64_t cracks = floor_.Panel("cracks");
  std::this_thread::sleep_for(1500ms);
  EXPECT_EQ(floor_.Panel("cracks"), cracks) << "nothing fires without both lines";
  EXPECT_EQ(floor_.Panel("shutters"), 0);
  ASSERT_EQ(AskPanel(floor_.folder(), "plug " + GetParam()), "ok\n");
  ExpectGood();
}

// Both ends stay open and nothing passes; what was sent before comes late, all at once.
TEST_P(ATcpLine, ThatIsSilentClosesTheShuttersAndItsLateBytesFireNothing) {
  floor_.StartMachine();
  TcpRelay laser(floor_.DeviceOf("laser")), motion(floor_.DeviceOf("motion"));
  floor_.Lead("laser", laser.device());
  floor_.Lead("motion", motion.device());
  floor_.StartServices();
  ASSERT_TRUE(Begin(60)) << floor_.Logs();
  TcpRelay& held = GetParam() == "laser" ? laser : motion;
  held.Hold(true);
  const std::int64_t cut_tick = floor_.Panel("tick");
  std::this_thread::sleep_for(1500ms);
  const std::int64_t cracks = floor_.Panel("cracks"), end_tick = floor_.Panel("tick");
  std::int64_t last_tick = 0;
  for (const auto& crack : floor_.Cracks())
    last_tick = std::max(last_tick, static_cast<std::int64_t>(crack.tick));
  std::cout << "  last crack " << last_tick - cut_tick << " ticks after the cut\n";
  // 250 ms of silence, in ticks; the same again for what a loaded computer adds.
  EXPECT_LT(last_tick - cut_tick, kRateHz / 2);
  EXPECT_GT(end_tick, cut_tick + kRateHz) << "the machine itself went on";
  EXPECT_LT(cracks, static_cast<std::int64_t>(UndisturbedPoints().size()));
  held.Hold(false);
  ExpectGood();
}

}  // namespace
}  // namespace intaglio
