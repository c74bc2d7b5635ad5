#include "tests/services/drivers/marks/mark_conformance_outline.h"

#include <cmath>

#include "tests/services/drivers/marks/mark_bench.h"
#include "tests/services/drivers/outline_watch.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

using Corners = std::vector<Vec2>;

Corners CornersAt(MarkBench& bench) { return OutlineBeside(bench.rig().guide_at_mm()); }

/// An outline is begun. False: the machine has no guide laser, and says so.
bool DrawsOutlines(MarkBench& bench) {
  HandMotion* const hand = bench.driver().hand();
  if (hand == nullptr) return false;
  const auto drawn = hand->DrawOutline(CornersAt(bench), kGuideSpeedMmS);
  if (!drawn && drawn.error().code == ErrorCode::kUnsupported) {
    Expect(!drawn.error().message.empty(), "K12: the refusal is without a sentence");
    return false;
  }
  Expect(drawn, "DrawOutline");
  Expect(!hand->state().at_rest, "K12: it is at rest after DrawOutline");
  bench.outline_ms = 0;
  return true;
}

/// What was permitted in the outline opens the gate behind it.
void WithdrawPermission(MarkBench& bench) {
  bench.rig().permits = false;
  bench.StepFor(kSilence + kReportTime);
}

/// Held, at rest, and dark from then on.
void EndOutline(MarkBench& bench) {
  HandMotion& hand = *bench.driver().hand();
  WithdrawPermission(bench);
  Expect(hand.Hold(), "Hold");
  bench.StepFor(kReportTime);
  Expect(!bench.rig().guide_is_on(), "K12: the guide laser is on behind the outline");
  Expect(bench.Until([&] { return hand.state().at_rest; }, 300ms),
         "K12: the outline goes on");
  bench.outline_ms.reset();
  bench.rig().permits = true;
  bench.StepFor(kReportTime);
}

void AnOutlineIsDrawnUntilItIsHeld(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.Connect();
  const Corners corners = CornersAt(bench);
  if (!DrawsOutlines(bench)) return;
  OutlineWatch watch("K12", corners, bench.rig().place_tolerance_mm());
  for (int ms = 0; ms < 2000; ++ms) {
    bench.Step();
    watch.Receive(bench.rig().guide_at_mm(), bench.rig().guide_is_on());
  }
  watch.ExpectEachCorner(3);
  Expect(!bench.state().settled, "K12: the state is settled in an outline");
  EndOutline(bench);
  Expect(bench.driver().hand()->state().fault == intaglio_MOTION_OK,
         "K12: a hold is a fault");
  bench.ExpectStill(500ms, "K12: behind the outline");
  bench.ExpectGoodRun(1);
}

void AnOutlineIsRefusedWhereItCannotBe(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.Connect();
  const Corners good = CornersAt(bench);
  if (!DrawsOutlines(bench)) return;
  HandMotion& hand = *bench.driver().hand();
  const auto refuses = [&](const Corners& corners, double speed_mm_s = kGuideSpeedMmS) {
    return !hand.DrawOutline(corners, speed_mm_s);
  };
  Expect(refuses(good), "K12: an outline is not alone");
  EndOutline(bench);
  Expect(refuses({}) && refuses(Corners(kMaxOutlineCorners + 1, good.front())) &&
             refuses({good.front(), Vec2(1e6, 0)}) &&
             refuses({good.front(), Vec2(0, std::nan(""))}) && refuses(good, 0) &&
             refuses(good, std::nan("")),
         "K12: an outline is taken that cannot be drawn");
  bench.ExpectStill(300ms, "K12: an outline that was refused");
  bench.RunIntoTheSecond(1);
  Expect(refuses(good), "K12: an outline in a run is taken");
  bench.StepFor(100ms);
  bench.rig().SetDoor(false);
  bench.StepFor(bench.rig().stop_time() + kReportTime);
  Expect(refuses(good), "K12: an outline with an open door is taken");
  bench.rig().SetDoor(true);
  bench.StepFor(300ms);
  Expect(refuses(good), "K12: an outline after a fault is taken");
  Expect(hand.ClearFault(), "ClearFault");
  bench.StepFor(300ms);
  bench.ExpectGoodRun(2);
}

void ARunInAnOutlineIsRefused(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.Connect();
  if (!DrawsOutlines(bench)) return;
  const mark::MarkSet set = bench.rig().MarksFor(1);
  Expect(!bench.driver().Begin(1, set.pens), "K12: a run begins in an outline");
  bench.StepFor(500ms);
  Expect(!bench.driver().Begin(1, set.pens), "K12: a run begins in an outline");
  EndOutline(bench);
  bench.ExpectGoodRun(2);
}

void AFaultEndsTheOutline(const MarkRigMaker& make, ControllerFault fault) {
  MarkBench bench(make);
  bench.Connect();
  if (!DrawsOutlines(bench)) return;
  bench.StepFor(500ms);
  Expect(bench.rig().guide_is_on(), "K12: the guide laser is not on");
  WithdrawPermission(bench);
  if (!bench.rig().Inflict(fault)) return;
  bench.StepFor(kSilence + 100ms);
  const std::uint64_t work = bench.rig().work_count();
  bench.StepFor(1s);
  Expect(bench.rig().work_count() == work, "K12: the outline goes on");
  Expect(fault == ControllerFault::kUnplug || !bench.rig().guide_is_on(),
         "K12: the guide laser is on behind the outline");
  bench.rig().Relieve(fault);
  Expect(bench.Until([&] { return bench.state().link_up; }),
         "K9: the line does not come back: " + bench.state().message);
  bench.outline_ms.reset();
  bench.rig().permits = true;
  bench.StepFor(bench.rig().stop_time() + 100ms);
  bench.ExpectStill(2s, "K12: the outline goes on by itself");
  Expect(bench.driver().hand()->ClearFault(), "ClearFault");
  Expect(bench.Until([&] { return bench.driver().hand()->state().at_rest; }),
         "K12: it does not rest");
  bench.StepFor(300ms);
  bench.ExpectGoodRun(1);
}

}  // namespace

std::vector<MarkCheck> MarkOutlineChecks() {
  std::vector<MarkCheck> all = {
      {"K12_outline", &AnOutlineIsDrawnUntilItIsHeld},
      {"K12_refusals", &AnOutlineIsRefusedWhereItCannotBe},
      {"K12_run", &ARunInAnOutlineIsRefused},
  };
  for (const ControllerFault fault : kControllerFaults) {
    all.push_back(
        {fmt::format("K12_{}", NameOf(fault)),
         [fault](const MarkRigMaker& make) { AFaultEndsTheOutline(make, fault); }});
  }
  return all;
}

}  // namespace intaglio::drivers
