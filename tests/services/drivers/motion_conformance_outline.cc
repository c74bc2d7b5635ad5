#include "tests/services/drivers/motion_conformance_outline.h"

#include <cmath>

#include "services/drivers/interface/laser_controller.h"
#include "tests/services/drivers/controller_fault.h"
#include "tests/services/drivers/motion_bench.h"
#include "tests/services/drivers/outline_watch.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

using Corners = std::vector<Vec2>;

Corners CornersBeside(MotionBench& bench) {
  return OutlineBeside(bench.rig().actual_mm().head<2>());
}

bool DrawsOutlines(MotionBench& bench) {
  const auto drawn = bench.driver().DrawOutline(CornersBeside(bench), kGuideSpeedMmS);
  if (!drawn && drawn.error().code == ErrorCode::kUnsupported) {
    Expect(!drawn.error().message.empty(), "M19: the refusal is without a sentence");
    return false;
  }
  Expect(drawn, "DrawOutline");
  Expect(!bench.state().at_rest, "M19: it is at rest after DrawOutline");
  return true;
}

/// With a laser side that is told again and again to open its shutter.
class Watch {
 public:
  Watch(MotionBench& bench, const Corners& corners)
      : bench_(bench), outline_("M19", corners, bench.rig().tolerance_mm()) {}

  void Step() {
    bench_.Step();
    if (LaserController* const laser = bench_.driver().laser(); laser != nullptr)
      (void)laser->OpenShutters(1);
    Expect(!bench_.rig().may_fire(), "M19: the gate of the laser is open in an outline");
    outline_.Receive(bench_.rig().actual_mm().head<2>(), bench_.rig().guide_is_on());
  }
  void ExpectEachCorner(int visits) const { outline_.ExpectEachCorner(visits); }

 private:
  MotionBench& bench_;
  OutlineWatch outline_;
};

void CloseShutter(MotionBench& bench) {
  if (LaserController* const laser = bench.driver().laser(); laser != nullptr)
    (void)laser->OpenShutters(0);
}

/// The courses of the bench are along x alone.
void ExpectGoodRunFromZero(MotionBench& bench, std::uint32_t run) {
  Expect(bench.driver().Jog(Vec3::Zero(), kGuideSpeedMmS), "Jog");
  Expect(bench.Until([&] { return bench.state().at_rest; }), "M14: the jog does not end");
  bench.positions.clear();
  bench.ExpectGoodRun(run);
}

void AnOutlineIsDrawnUntilItIsHeld(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  const Corners corners = CornersBeside(bench);
  if (!DrawsOutlines(bench)) return;
  Watch watch(bench, corners);
  for (int ms = 0; ms < 2000; ++ms) watch.Step();
  watch.ExpectEachCorner(3);
  Expect(!bench.state().at_rest, "M19: at rest in an outline");
  CloseShutter(bench);
  Expect(bench.driver().Hold(), "Hold");
  bench.StepFor(kReportTime);
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on behind the outline");
  Expect(bench.RestsWithin(100ms), "M15: the outline goes on");
  bench.ExpectStill(500ms, "M15: motion follows");
  Expect(bench.state().at_rest && bench.state().fault == intaglio_MOTION_OK,
         "M15: a hold is a fault");
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on at rest");
  ExpectGoodRunFromZero(bench, 1);
}

void AnOutlineIsRefusedWhereAJogIs(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  const Corners good = CornersBeside(bench);
  if (!DrawsOutlines(bench)) return;
  const auto refuses = [&](const Corners& corners, double speed_mm_s = kGuideSpeedMmS) {
    return !bench.driver().DrawOutline(corners, speed_mm_s);
  };
  Expect(refuses(good) && !bench.driver().Jog(Vec3::Zero(), 1),
         "M14: an outline is not alone");
  Expect(bench.driver().Hold() && bench.Until([&] { return bench.state().at_rest; }),
         "M15: the outline goes on");
  const double end_mm = bench.rig().travel_max_mm().x();
  Expect(refuses({}) && refuses(Corners(kMaxOutlineCorners + 1, good.front())) &&
             refuses({good.front(), Vec2(end_mm + 0.01, 0)}) &&
             refuses({good.front(), Vec2(std::nan(""), 0)}) && refuses(good, 0) &&
             refuses(good, std::nan("")),
         "M19: an outline is taken that cannot be drawn");
  bench.ExpectStill(300ms, "M19: it moves for an outline that was refused");
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on without an outline");
  ExpectGoodRunFromZero(bench, 1);
  bench.MoveALot(2);
  Expect(refuses(good), "M14: an outline in a run is taken");
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on in a run");
  Expect(bench.driver().AbortRun(), "AbortRun");
  Expect(bench.Until([&] { return bench.state().at_rest && !bench.rig().moves(); }),
         "M5: the stage does not brake");
  bench.Begin(3);
  bench.Append({To(bench.x() + 0.25, kSpeed_mm_s, kRampTicks)});  // and no more
  bench.ExpectFault(intaglio_MOTION_STARVED, "M8: motion that ends in mid-run");
  Expect(bench.RestsWithin(kReportTime), "M6: the stage does not brake");
  Expect(refuses(good), "M14: an outline after a fault is taken");
  bench.ClearFault();
  bench.ExpectGoodRun(4);
}

void ARunInAnOutlineIsRefused(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  if (!DrawsOutlines(bench)) return;
  bench.StepFor(500ms);
  bench.Begin(1);
  bench.ExpectFault(intaglio_MOTION_LATE, "M15: a run that begins in an outline");
  Expect(bench.RestsWithin(kReportTime), "M15: the outline goes on");
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on behind the outline");
  bench.ExpectStill(500ms, "M15: motion follows");
  Expect(bench.driver().Hold() && bench.Until([&] { return bench.state().at_rest; }),
         "M15: it does not rest");
  bench.ClearFault();
  ExpectGoodRunFromZero(bench, 2);
}

void AFaultEndsTheOutline(const MotionRigMaker& make, ControllerFault fault) {
  MotionBench bench(make);
  bench.Connect();
  if (!DrawsOutlines(bench)) return;
  bench.StepFor(500ms);
  Expect(bench.rig().guide_is_on(), "M19: the guide laser is not on");
  if (!bench.rig().Inflict(fault)) return;
  Expect(bench.RestsWithin(kSilence + 100ms), "M9, M17: the outline goes on");
  bench.StepFor(kReportTime);
  Expect(fault == ControllerFault::kUnplug || !bench.rig().guide_is_on(),
         "M19: the guide laser is on behind the outline");
  bench.ExpectStill(1s, "M9, M17: motion follows");
  bench.rig().Relieve(fault);
  Expect(bench.Until([&] { return bench.state().link_up; }, 5s),
         "M10: the line does not come back: " + bench.Message());
  bench.ExpectStill(2s, "M10, M17: the outline goes on by itself");
  Expect(!bench.rig().guide_is_on(), "M19: the guide laser is on behind the outline");
  if (LaserController* const laser = bench.driver().laser(); laser != nullptr)
    Expect(laser->Reset(), "Reset");
  Expect(bench.driver().ClearFault(), "ClearFault");
  Expect(bench.Until([&] {
    return bench.state().fault == intaglio_MOTION_OK && bench.state().at_rest;
  }),
         "M17: the fault stays: " + bench.Message());
  // Where the mirrors rest may not be known before they are moved again.
  ExpectGoodRunFromZero(bench, 9);
}

}  // namespace

std::vector<MotionCheck> OutlineChecks() {
  std::vector<MotionCheck> all = {
      {"M19_outline", &AnOutlineIsDrawnUntilItIsHeld},
      {"M19_refusals", &AnOutlineIsRefusedWhereAJogIs},
      {"M19_run", &ARunInAnOutlineIsRefused},
  };
  for (const ControllerFault fault : kControllerFaults) {
    all.push_back(
        {fmt::format("M19_{}", NameOf(fault)),
         [fault](const MotionRigMaker& make) { AFaultEndsTheOutline(make, fault); }});
  }
  return all;
}

}  // namespace intaglio::drivers
