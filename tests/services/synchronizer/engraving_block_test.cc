// A stage that carries the block: nothing is armed unless its controller reports it at
// the job's place, and what takes it away costs the arm.

#include <gmock/gmock.h>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using namespace std::chrono_literals;

const Vec2 kJobsPlaceMm(-50, 12);

class CarriedBlock : public testing::Test {
 protected:
  void ExpectNoMoreCracks(std::size_t cracks) {
    cell_.RenewGrant();
    cell_.StepFor(3s);
    EXPECT_EQ(cell_.laser.cracks().size(), cracks);
    EXPECT_EQ(cell_.laser.shutters(), 0);
  }
  void GoOnToTheEnd() {
    cell_.GrantAnew();
    ASSERT_TRUE(cell_.StepUntilDone()) << cell_.Description();
    EXPECT_THAT(cell_.Disagreements(), IsEmpty());
    EXPECT_EQ(cell_.made(), cell_.points_mm.size());
  }

  FakeCell cell_{{.points = 160, .block_stage_mm = kJobsPlaceMm}};
};

TEST_F(CarriedBlock, IsFiredIntoAtTheJobsPlaceAlone) {
  cell_.Grant();
  cell_.block_drives = true;
  for (const Vec2& place_mm : {Vec2(0, 0), Vec2(-50, 12.04), Vec2(-49.96, 12)}) {
    cell_.block_mm = place_mm;
    cell_.StepFor(2s);
    EXPECT_EQ(cell_.laser.newest_arm_at(), 0ns) << place_mm.transpose();
    EXPECT_THAT(cell_.engraving->message(), HasSubstr("moves the block to the job's"));
  }
  cell_.reports_block = false;
  cell_.block_mm = kJobsPlaceMm;
  cell_.StepFor(2s);
  EXPECT_EQ(cell_.laser.newest_arm_at(), 0ns) << "nobody reports where it is";
  cell_.reports_block = true;
  cell_.StepFor(2s);
  EXPECT_EQ(cell_.laser.newest_arm_at(), 0ns) << "its drive goes on";
  cell_.block_drives = false;
  ASSERT_TRUE(cell_.StepUntilDone()) << cell_.Description();
  EXPECT_EQ(cell_.made(), cell_.points_mm.size());
}

TEST_F(CarriedBlock, ThatLeavesItsPlaceInARunCostsTheArm) {
  cell_.block_mm = kJobsPlaceMm + Vec2(0, 0.02);  // within the tolerance of 30 um
  cell_.Grant();
  ASSERT_TRUE(cell_.StepUntilMade(20));
  cell_.block_mm.x() += 0.1;
  cell_.StepFor(1s);
  const std::size_t cracks = cell_.laser.cracks().size();
  ASSERT_LT(cracks, cell_.points_mm.size());
  EXPECT_THAT(cell_.engraving->message(), HasSubstr("is not at the job's place"));
  EXPECT_FALSE(cell_.engraving->lost_a_line()) << "it would go on by itself";
  cell_.block_mm = kJobsPlaceMm;
  ExpectNoMoreCracks(cracks);
  GoOnToTheEnd();
}

TEST_F(CarriedBlock, ThatIsNotBroughtToItsPlaceCostsTheArm) {
  cell_.Grant();
  cell_.block_drives = true;
  cell_.StepFor(1s);
  cell_.block_drives = false;
  cell_.block_failure = "the block did not come to the job's place: the bridge was lost";
  cell_.block_mm = kJobsPlaceMm;  // whoever brought it there since
  cell_.StepFor(1s);
  EXPECT_THAT(cell_.engraving->message(), HasSubstr("did not come to the job's place"));
  EXPECT_TRUE(cell_.engraving->faulted());
  ExpectNoMoreCracks(0);
  GoOnToTheEnd();
}

}  // namespace
}  // namespace intaglio::synchronizer
