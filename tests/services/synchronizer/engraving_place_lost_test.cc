// A stage that does not know where its axes are: no shutter opens, not even for the
// instant until a run is refused, and only a person's arm behind the home goes on.

#include <gmock/gmock.h>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using ::testing::IsEmpty;
using namespace std::chrono_literals;

constexpr char kHomeIt[] =
    "the following error of the stage is too large; the controller does not know where "
    "its axes are: home it (intaglio teach home), then resume";

class PlaceLost : public testing::Test {
 protected:
  void LosePlace() { cell_.stage.Fail(intaglio_MOTION_PLACE_LOST, kHomeIt); }
  void Home() { cell_.stage.Fail(intaglio_MOTION_OK, ""); }
  void ExpectDark(std::size_t cracks, int shutters_asked) {
    EXPECT_EQ(cell_.laser.cracks().size(), cracks);
    EXPECT_EQ(cell_.laser.shutters_asked_count(), shutters_asked);
    EXPECT_EQ(cell_.laser.shutters(), 0);
    EXPECT_TRUE(cell_.engraving->faulted());
    EXPECT_TRUE(cell_.engraving->waits());
    EXPECT_FALSE(cell_.engraving->lost_a_line()) << "it would go on by itself";
    EXPECT_EQ(cell_.engraving->message(), kHomeIt);
  }
  void GoOnToTheEnd() {
    cell_.GrantAnew();
    ASSERT_TRUE(cell_.StepUntilDone()) << cell_.Description();
    EXPECT_THAT(cell_.Disagreements(), IsEmpty());
    EXPECT_EQ(cell_.made(), cell_.points_mm.size());
  }

  FakeCell cell_{{.points = 160}};
};

TEST_F(PlaceLost, OpensNoShutterOfAJobThatIsResumed) {
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  LosePlace();
  cell_.StepFor(2s);
  const std::size_t cracks = cell_.laser.cracks().size();
  ASSERT_LT(cracks, cell_.points_mm.size());
  const int shutters_asked = cell_.laser.shutters_asked_count();
  ASSERT_GT(shutters_asked, 0);
  ExpectDark(cracks, shutters_asked);
  for (int resumed = 0; resumed < 3; ++resumed) {
    cell_.GrantAnew();
    cell_.StepFor(3s);
    ExpectDark(cracks, shutters_asked);
  }
  Home();
  cell_.RenewGrant();
  cell_.StepFor(3s);
  ExpectDark(cracks, shutters_asked);
  GoOnToTheEnd();
}

TEST_F(PlaceLost, OpensNoShutterOfAJobThatIsArmed) {
  LosePlace();
  cell_.Grant();
  cell_.StepFor(5s);
  ExpectDark(0, 0);
  Home();
  GoOnToTheEnd();
}

// The newest state of the stage may be older than the run.
TEST_F(PlaceLost, BetweenTheShutterAndTheRunEndsIt) {
  cell_.stage.silent = true;
  cell_.Grant();
  ASSERT_FALSE(cell_.StepUntilMade(1)) << "no run begins without a state";
  cell_.stage.silent = false;
  cell_.stage.deaf = true;
  cell_.GrantAnew();
  ASSERT_TRUE(cell_.StepUntil([&] { return cell_.laser.shutters_asked_count() > 0; }));
  LosePlace();
  cell_.StepFor(1s);
  ExpectDark(0, cell_.laser.shutters_asked_count());
  cell_.stage.deaf = false;
  Home();
  GoOnToTheEnd();
}

}  // namespace
}  // namespace intaglio::synchronizer
