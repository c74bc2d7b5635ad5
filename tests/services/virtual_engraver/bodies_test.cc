// The bodies of the machine: their geometry against that of the services, which shares
// nothing with it, and a whole machine whose lens is driven into the block.

#include "services/virtual_engraver/bodies.h"

#include <gtest/gtest.h>

#include <numbers>
#include <random>

#include "engrave/machine/clearance.h"
#include "tests/services/virtual_engraver/machine_bench.h"

namespace intaglio::virtual_engraver {
namespace {

using namespace std::chrono_literals;

const BlockInMachine kBlock{Vec3(10, 20, 5), Vec3(50, 40, 100), 1.52, 0.06};

std::vector<formats::GlassCollision> Moved(const BodyOptions& options,
                                           const std::vector<Vec3>& places) {
  Bodies bodies(options, kBlock, {});
  std::vector<formats::GlassCollision> found;
  for (const Vec3& place : places)
    bodies.Move(place, found.size(), [&](const auto& met) { found.push_back(met); });
  return found;
}

TEST(Bodies, MeetWhereTheClearanceOfTheServicesFindsIt) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> side(-60, 110), up(0, 120), size(2, 25);
  int met = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 low = Vec3(side(random), side(random), up(random)) - kBlock.origin_mm;
    const Box3 obstacle{low, low + Vec3(size(random), size(random), size(random))};
    const HangingBody lens{30 + size(random), size(random)};
    const Vec3 focus(side(random), side(random), up(random));
    const auto found = Moved({lens, {}, {obstacle}}, {focus});
    const machine::Clearance clearance({{lens.above_focus_mm, lens.radius_mm}},
                                       {{Vec3::Zero(), kBlock.size_mm}, obstacle});
    const auto expected = clearance.At(focus - kBlock.origin_mm);
    double deepest_mm = 0;
    for (const auto& collision : found)
      deepest_mm = std::max(deepest_mm, collision.overlap_mm);
    // A touch of less than 0.1 mm is not recorded.
    if (expected && expected->overlap_mm < 0.1) continue;
    ASSERT_EQ(deepest_mm > 0, expected.has_value()) << i;
    if (!expected) continue;
    ++met;
    EXPECT_NEAR(deepest_mm, expected->overlap_mm, 1e-9);
  }
  EXPECT_GT(met, 300);
}

TEST(Bodies, ARecordIsMadeAtTheBeginAndForEveryTenthDeeper) {
  const HangingBody lens{43, 10};
  const Vec3 over(30, 40, 0);
  const double face_mm = 105 - 43;
  const auto at = [&](double depth_mm) { return over + Vec3(0, 0, face_mm - depth_mm); };
  const auto found = Moved({lens, {}, {}}, {at(-5), at(0.05), at(0.2), at(0.25), at(0.1),
                                            at(3), at(-1), at(0.15)});
  ASSERT_EQ(found.size(), 3u);
  EXPECT_NEAR(found[0].overlap_mm, 0.2, 1e-9);
  EXPECT_NEAR(found[1].overlap_mm, 3, 1e-9);
  EXPECT_NEAR(found[2].overlap_mm, 0.15, 1e-9) << "it was free in between";
  EXPECT_EQ(found[0].body, 0);
  EXPECT_EQ(found[0].solid, 0);
  EXPECT_LT((found[0].focus_mm - (at(0.2) - kBlock.origin_mm)).norm(), 1e-9);
}

TEST(Bodies, TheCarrierMeetsTheObstacleBesideTheBlockAndATurnedBlock) {
  const BodyOptions options{
      HangingBody{60, 5}, HangingBody{80, 40}, {{Vec3(60, 0, 0), Vec3(70, 40, 130)}}};
  const auto found = Moved(options, {Vec3(50, 40, 50)});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].body, 1);
  EXPECT_EQ(found[0].solid, 1);
  EXPECT_NEAR(found[0].overlap_mm, 5, 1e-9);
  const std::vector<StationInMachine> further = {{Vec3::Zero(), std::numbers::pi / 2}};
  Bodies turned({HangingBody{43, 2}, {}, {}}, kBlock, further);
  int met = 0;
  // The block from (10, 20) to (60, 60), turned by a quarter: (-60, 10) to (-20, 60).
  turned.Move(Vec3(-59, 11, 50), 1, [&](const auto&) { ++met; });
  EXPECT_EQ(met, 1);
  turned.Move(Vec3(-59, 7, 50), 2, [&](const auto&) { ++met; });
  EXPECT_EQ(met, 1);
}

class BodiesOfAMachine : public MachineBench {
 protected:
  /// By hand, as a person or a program could.
  void DriveTo(const Vec3& place) {
    const auto nm = [](double mm) {
      return static_cast<std::int32_t>(std::lround(1e6 * mm));
    };
    SendMotion(
        link::MotionFrame::kJogMove,
        Encode(link::JogMove{nm(place.x()), nm(place.y()), nm(place.z()), 50000000}));
    Pass(6000ms);
  }
  std::vector<formats::GlassCollision> Collisions() {
    EXPECT_TRUE(machine->glass().Flush().has_value());
    return formats::ReadGlassRecord(record_file)->collisions;
  }
};

// The published case: f = 43 mm over 100 mm of glass, the focus 95 mm deep.
TEST_F(BodiesOfAMachine, ALensThatIsDrivenIntoTheBlockIsInTheRecord) {
  MachineOptions options = PlainOptions(false);
  options.stage.start_mm = Vec3(0, 0, 150);
  options.bodies.lens = HangingBody{43};
  Start(options);
  Connect();
  DriveTo(Vec3(50, 50, 60));
  EXPECT_TRUE(Collisions().empty());
  const double air_mm = 95 * 0.6577;
  DriveTo(Vec3(50, 50, 100 - air_mm));
  const auto found = Collisions();
  ASSERT_FALSE(found.empty());
  EXPECT_NEAR(found.back().overlap_mm, 19.5, 0.15);
  EXPECT_EQ(found.back().body, 0);
  EXPECT_EQ(found.back().solid, 0);
}

TEST_F(BodiesOfAMachine, AMachineWithoutBodiesMeetsNothing) {
  Start(PlainOptions(false));
  Connect();
  DriveTo(Vec3(50, 50, 1));
  EXPECT_TRUE(Collisions().empty());
}

}  // namespace
}  // namespace intaglio::virtual_engraver
