#include "services/platform/host/process/patience.h"

#include <gtest/gtest.h>

namespace intaglio::host {
namespace {

using namespace std::chrono_literals;

class PatienceTest : public testing::Test {
 protected:
  Patience Of(std::chrono::milliseconds time) {
    return Patience(
        time, [this] { return share_; }, [this] { return now_; });
  }
  double share_ = 1;
  Patience::Clock::time_point now_{1h};
};

TEST_F(PatienceTest, EndsInTimeOnAComputerThatIsNotBusy) {
  Patience patience = Of(1500ms);
  now_ += 1499ms;
  EXPECT_FALSE(patience.IsUp());
  now_ += 1ms;
  EXPECT_TRUE(patience.IsUp());
  EXPECT_DOUBLE_EQ(patience.waited().count(), 1.5);
}

// 20 processes for two cores: a tenth of a core for each.
TEST_F(PatienceTest, LastsLongerWhileTheComputerIsBusy) {
  Patience patience = Of(1500ms);
  share_ = 0.1;
  for (int i = 0; i < 10; ++i) {
    now_ += 1s;
    EXPECT_FALSE(patience.IsUp()) << i;
  }
  share_ = 1;
  now_ += 499ms;
  EXPECT_FALSE(patience.IsUp());
  now_ += 1ms;
  EXPECT_TRUE(patience.IsUp());
}

// Thirty machines that become ready one after the other are awaited as one is.
TEST_F(PatienceTest, BeginsAnewWhenThereIsProgress) {
  Patience patience = Of(1500ms);
  for (int found = 1; found <= 30; ++found) {
    now_ += 1s;
    EXPECT_FALSE(patience.IsUp(found)) << found;
  }
  now_ += 1499ms;
  EXPECT_FALSE(patience.IsUp(30));
  now_ += 1ms;
  EXPECT_TRUE(patience.IsUp(30));
}

// One that falls back and comes again is none.
TEST_F(PatienceTest, CountsProgressOnce) {
  Patience patience = Of(1500ms);
  EXPECT_FALSE(patience.IsUp(2));
  now_ += 1s;
  EXPECT_FALSE(patience.IsUp(1));
  now_ += 500ms;
  EXPECT_TRUE(patience.IsUp(2));
}

TEST_F(PatienceTest, HasAnEndOnAComputerWithoutAnyTime) {
  Patience patience = Of(1500ms);
  share_ = 0;
  now_ += Patience::kLongest - 1ms;
  EXPECT_FALSE(patience.IsUp());
  now_ += 1ms;
  EXPECT_TRUE(patience.IsUp());
  Patience longer = Of(200s);
  now_ += 199s;
  EXPECT_FALSE(longer.IsUp());
}

TEST_F(PatienceTest, TheShareOfThisComputerIsAShare) {
  EXPECT_GT(ShareOfOneProcess(), 0);
  EXPECT_LE(ShareOfOneProcess(), 1);
}

}  // namespace
}  // namespace intaglio::host
