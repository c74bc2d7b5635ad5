#include "tests/services/drivers/motion_conformance_block.h"

#include "tests/services/drivers/motion_bench.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

constexpr double kBlockSpeedMmS = 25;
const Vec2 kBlockGoalMm(20, -5);

/// Whether this controller has such a stage; the bench is connected and at rest.
bool HasBlockStage(MotionBench& bench) {
  if (bench.state().has_block_stage) return true;
  const auto moved = bench.driver().MoveBlock(kBlockGoalMm, kBlockSpeedMmS);
  Expect(!moved && moved.error().code == ErrorCode::kUnsupported,
         "M20: a block is moved without a stage for it");
  const auto required = bench.driver().RequireBlockAt(kBlockGoalMm);
  Expect(!required && required.error().code == ErrorCode::kUnsupported,
         "M20: a place of the block is taken without a stage for it");
  Expect(bench.driver().RequireBlockAt(Vec2::Zero()), "M20: 0 is refused");
  Expect(bench.state().at_rest, "M20: a refused move is not at rest");
  return false;
}

double BlockAway(MotionBench& bench, const Vec2& place_mm) {
  return (bench.rig().block_mm() - place_mm).norm();
}

void ExpectBlockStill(MotionBench& bench, milliseconds time, const std::string& what) {
  const Vec2 place_mm = bench.rig().block_mm();
  for (std::int64_t i = 0; i < time.count(); ++i) {
    bench.Step();
    Expect(bench.rig().block_mm() == place_mm, what);
  }
}

void MoveBlockAQuarter(MotionBench& bench) {
  Expect(bench.driver().MoveBlock(kBlockGoalMm, kBlockSpeedMmS), "MoveBlock");
  Expect(!bench.state().at_rest, "M20: it is at rest after MoveBlock");
  Expect(bench.Until(
             [&] { return BlockAway(bench, Vec2::Zero()) > kBlockGoalMm.norm() / 4; }),
         "M20: the block does not move: " + bench.Message());
}

void TheBlockGoesToItsPlaceAndARunIsOfThere(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  if (!HasBlockStage(bench)) return;
  const Vec3 axes = bench.rig().actual_mm();
  MoveBlockAQuarter(bench);
  Expect(bench.Until([&] { return bench.state().at_rest; }), "M20: it does not end");
  Expect(BlockAway(bench, kBlockGoalMm) <= bench.rig().tolerance_mm() &&
             (bench.state().block_mm - kBlockGoalMm).norm() <= bench.rig().tolerance_mm(),
         "M20: the block, or what is reported of it, is elsewhere");
  Expect(bench.rig().actual_mm() == axes, "M20: the other axes move with it");
  Expect(bench.state().fault == intaglio_MOTION_OK, "M20: the move is a fault");
  Expect(bench.driver().RequireBlockAt(kBlockGoalMm), "RequireBlockAt");
  bench.ExpectGoodRun(1);
}

void NoRunBeginsWithTheBlockElsewhere(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  if (!HasBlockStage(bench)) return;
  Expect(bench.driver().RequireBlockAt(Vec2(0.5, 0)), "RequireBlockAt");
  bench.Begin(1);
  (void)bench.AppendAtOnce(bench.CourseFromHere().Segments());
  bench.ExpectFault(intaglio_MOTION_SAFE_STATE, "M20: a run with the block elsewhere");
  bench.ExpectStill(500ms, "M20: a run begins with the block elsewhere");
  bench.ClearFault();
  Expect(bench.driver().RequireBlockAt(Vec2::Zero()), "RequireBlockAt");
  bench.ExpectGoodRun(2);
  // It moves in a run for nobody.
  bench.MoveALot(3);
  Expect(!bench.driver().MoveBlock(kBlockGoalMm, kBlockSpeedMmS),
         "M20: the block is moved in a run");
  Expect(bench.driver().AbortRun() && bench.RestsWithin(kReportTime), "M5");
  Expect(bench.Until([&] { return bench.state().at_rest; }), "M2: rest is not reported");
  Expect(bench.driver().MoveBlock(Vec2(1e4, 0), kBlockSpeedMmS), "MoveBlock");
  bench.ExpectFault(intaglio_MOTION_LIMIT, "M20: a place of the block out of the travel");
  Expect(BlockAway(bench, Vec2::Zero()) == 0, "M20: the block moves beyond its travel");
}

void HoldEndsAMoveOfTheBlock(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  if (!HasBlockStage(bench)) return;
  MoveBlockAQuarter(bench);
  Expect(bench.driver().Hold(), "Hold");
  Expect(bench.RestsWithin(100ms), "M20: the block does not brake");
  Expect(BlockAway(bench, kBlockGoalMm) > 1, "M20: the move goes on to its end");
  ExpectBlockStill(bench, 500ms, "M20: motion follows");
  Expect(bench.state().at_rest && bench.state().fault == intaglio_MOTION_OK,
         "M20: a hold is a fault");
  Expect(bench.driver().RequireBlockAt(kBlockGoalMm), "RequireBlockAt");
  bench.Begin(1);
  bench.ExpectFault(intaglio_MOTION_SAFE_STATE, "M20: a run short of the place");
}

void ACutLineEndsAMoveOfTheBlock(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  if (!HasBlockStage(bench)) return;
  MoveBlockAQuarter(bench);
  bench.rig().CutLine(true);
  Expect(bench.RestsWithin(kSilence + 100ms), "M20: it goes on without a host");
  Expect(BlockAway(bench, kBlockGoalMm) > 1, "M20: the move goes on to its end");
  bench.rig().CutLine(false);
  Expect(bench.Until([&] { return bench.state().link_up; }, 3s),
         "M10: the line does not come back: " + bench.Message());
  ExpectBlockStill(bench, 500ms, "M20: motion comes back by itself");
}

}  // namespace

std::vector<MotionCheck> BlockChecks() {
  return {{"M20_block", &TheBlockGoesToItsPlaceAndARunIsOfThere},
          {"M20_elsewhere", &NoRunBeginsWithTheBlockElsewhere},
          {"M20_hold", &HoldEndsAMoveOfTheBlock},
          {"M20_cut", &ACutLineEndsAMoveOfTheBlock}};
}

}  // namespace intaglio::drivers
