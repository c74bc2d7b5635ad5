// Jobs under random schedules of faults. Whatever comes when: every point has exactly one
// state, none is fired twice, and glass, ledger and journal agree.

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <random>

#include "tests/services/synchronizer/fake_cell.h"

namespace intaglio::synchronizer {
namespace {

using testing::IsEmpty;
using namespace std::chrono_literals;

constexpr std::uint32_t kCampaignPoints = 120;

class Campaign : public testing::TestWithParam<std::uint64_t> {
 protected:
  std::chrono::milliseconds Milliseconds(int from, int to) {
    return std::chrono::milliseconds(
        std::uniform_int_distribution<int>(from, to)(random_));
  }

  /// One fault that comes, lasts and goes.
  void Strike() {
    const int kind = std::uniform_int_distribution<int>(0, 15)(random_);
    faults_ += fmt::format(" {}@{}", kind, cell_.now / 1ms);
    Toggle(kind, true);
    cell_.StepFor(Milliseconds(1, 900));
    Toggle(kind, false);
  }

  void Toggle(int kind, bool on) {
    switch (kind) {
      case 0:
        return on ? cell_.Withdraw() : cell_.Grant();
      case 1:
        cell_.permission_fresh = !on;
        return;
      case 2:
        cell_.stop_pressed = on;
        return;
      case 3:
        return cell_.CutLine(on);
      case 4:  // one direction only
        cell_.to_host->cut = on;
        return;
      case 5:
        cell_.laser.mute = on;
        return;
      case 6:
        cell_.laser.key_on = !on;
        return;
      case 7:
        cell_.laser.door_closed = !on;
        return;
      case 8:
        return cell_.laser.PressStop(on);
      case 9:
        if (on) cell_.laser.EnterSafeState();
        return;
      case 10:
        cell_.laser.lamp_dead = on;
        return;
      case 11:
        cell_.laser.shutter_stuck = on;
        return;
      case 12:
        cell_.stage.silent = on;
        return;
      case 13:
        if (on) cell_.stage.Fail(intaglio_MOTION_FOLLOWING_ERROR, "it is stuck");
        return;
      case 14:
        cell_.stage.behind = on;
        return;
      default:
        if (on) {
          cell_.PowerCycle(Milliseconds(1, 800));
          cell_.StepFor(1000ms);
        }
        return;
    }
  }

  void SpoilTheLine() {
    // One byte in 500 is lost or damaged at the worst.
    const double ratio = std::uniform_real_distribution<double>(0, 0.002)(random_);
    cell_.to_laser->drop_ratio = cell_.to_host->damage_ratio = ratio;
  }

  std::mt19937_64 random_{GetParam()};
  // In every fifth, shutters change in mid job.
  FakeCell cell_{{.points = kCampaignPoints,
                  .lockstep = GetParam() % 4 == 0,
                  .masks = GetParam() % 5 == 0 ? MasksInStretches(kCampaignPoints)
                                               : std::vector<ChannelMask>{}}};
  std::string faults_;
};

TEST_P(Campaign, EveryPointIsAccountedForAndNoneFiredTwice) {
  cell_.lockstep_ticks_a_step = 2;
  if (GetParam() % 3 == 0) SpoilTheLine();
  cell_.Grant();
  for (int i = 0; i < 12 && !cell_.done(); ++i) {
    cell_.StepFor(Milliseconds(0, 1200));
    Strike();
    ASSERT_THAT(cell_.Disagreements(), IsEmpty()) << faults_;
    if (random_() % 2 == 0) cell_.GrantAnew();
  }
  // Whatever latched is resumed until nothing is left.
  for (int i = 0; i < 60 && !cell_.done(); ++i) {
    cell_.GrantAnew();
    cell_.StepFor(3s);
  }
  ASSERT_TRUE(cell_.done()) << cell_.Description() << faults_;
  EXPECT_EQ(cell_.made() + cell_.Count(PointState::kMissed) +
                cell_.Count(PointState::kUncertain),
            kCampaignPoints)
      << faults_;
  EXPECT_THAT(cell_.Disagreements(), IsEmpty()) << faults_;
}

INSTANTIATE_TEST_SUITE_P(Engraving, Campaign, testing::Range<std::uint64_t>(1, 61));

}  // namespace
}  // namespace intaglio::synchronizer
