#include "tests/services/drivers/motion_conformance_jog.h"

#include <deque>

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

constexpr double kJogSpeedMmS = 25;

}  // namespace

bool CanJog(MotionBench& bench) {
  const Vec3 here = bench.rig().actual_mm();
  const auto jogged = bench.driver().Jog(here, kJogSpeedMmS);
  if (!jogged && jogged.error().code == ErrorCode::kUnsupported) {
    const auto homed = bench.driver().Home();
    Expect(!homed && homed.error().code == ErrorCode::kUnsupported,
           "M14: it can home and not jog");
    return false;
  }
  Expect(bench.Until([&] { return bench.state().at_rest; }),
         "M14: a jog to where it is does not end");
  return true;
}

void JogAQuarter(MotionBench& bench, const Vec3& target) {
  const double x0 = bench.x();
  Expect(bench.driver().Jog(target, kJogSpeedMmS), "Jog");
  Expect(!bench.state().at_rest, "M14: it is at rest after Jog");
  Expect(bench.Until([&] { return bench.x() - x0 > kJogMm / 4; }),
         "M14: the jog does not begin: " + bench.Message());
}

void AJogGoesToItsPlaceAndRests(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  if (!CanJog(bench)) return;
  const Vec3 target = bench.rig().actual_mm() + Vec3(kJogMm, -3, 2);
  JogAQuarter(bench, target);
  struct Sample {
    double time_ms = 0;
    Vec3 place_mm;
  };
  double fastest = 0;
  std::deque<Sample> newest;  // of the last 100 ms
  Expect(bench.Until([&] {
    newest.push_back({bench.rig().time_ms(), bench.rig().actual_mm()});
    while (newest.back().time_ms - newest.front().time_ms >= 100) {
      const double way_mm = (newest.back().place_mm - newest.front().place_mm).norm();
      fastest = std::max(
          fastest, way_mm / (newest.back().time_ms - newest.front().time_ms) * 1000);
      newest.pop_front();
    }
    return bench.state().at_rest;
  }),
         "M14: the jog does not end");
  Expect((bench.rig().actual_mm() - target).norm() <= bench.rig().tolerance_mm(),
         "M14: the jog ends elsewhere");
  Expect(fastest <= bench.rig().speed_margin() * kJogSpeedMmS &&
             fastest > 0.5 * kJogSpeedMmS,
         fmt::format("M14: a jog at {} mm/s instead of {}", fastest, kJogSpeedMmS));
  Expect(bench.state().fault == intaglio_MOTION_OK, "M14: a jog is a fault");
  bench.ExpectStill(200ms, "M14: motion follows");
  Expect(bench.driver().Jog(target - Vec3(0, -3, 2), kJogSpeedMmS), "Jog");
  Expect(bench.Until([&] { return bench.state().at_rest; }), "M14: it does not end");
  bench.ExpectGoodRun(1);
}

void HoldEndsAJog(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  if (!CanJog(bench)) return;
  const Vec3 target = bench.rig().actual_mm() + Vec3(kJogMm, 0, 0);
  JogAQuarter(bench, target);
  Expect(bench.driver().Hold(), "Hold");
  Expect(bench.RestsWithin(100ms), "M15: the stage does not brake");
  Expect(bench.x() < target.x() - 1, "M15: the jog goes on to its end");
  bench.ExpectStill(500ms, "M15: motion follows");
  Expect(bench.state().at_rest && bench.state().fault == intaglio_MOTION_OK,
         "M15: a hold is a fault");
  bench.ExpectGoodRun(1);
}

void AJogIsRefusedDuringARunAndAfterAFault(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  if (!CanJog(bench)) return;
  bench.MoveALot(1);
  Expect(!bench.driver().Jog(Vec3::Zero(), kJogSpeedMmS) && !bench.driver().Home(),
         "M14: a jog in a run is taken");
  Expect(bench.driver().AbortRun(), "AbortRun");
  Expect(bench.RestsWithin(kReportTime), "M5: the stage does not brake");
  Expect(bench.Until([&] { return bench.state().at_rest; }), "M2: rest is not reported");
  bench.Begin(2);
  bench.Append({To(bench.x() + 0.25, kSpeed_mm_s, kRampTicks)});  // and no more
  bench.ExpectFault(intaglio_MOTION_STARVED, "M8: motion that ends in mid-run");
  Expect(bench.RestsWithin(kReportTime), "M6: the stage does not brake");
  bench.StepFor(kReportTime);
  Expect(!bench.driver().Jog(Vec3::Zero(), kJogSpeedMmS) && !bench.driver().Home(),
         "M14: a jog after a fault is taken");
  bench.ExpectStill(300ms, "M14: it moves after a fault");
  bench.ClearFault();
  bench.ExpectGoodRun(3);
}

void ACutLineEndsAJog(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  if (!CanJog(bench)) return;
  JogAQuarter(bench, bench.rig().actual_mm() + Vec3(kJogMm, 0, 0));
  bench.rig().CutLine(true);
  Expect(bench.RestsWithin(kSilence + 100ms), "M9: a jog goes on without a host");
  bench.ExpectStill(500ms, "M9: motion follows");
  bench.rig().CutLine(false);
  Expect(bench.Until([&] { return bench.state().link_up; }, 3s),
         "M10: the line does not come back: " + bench.Message());
  bench.ExpectStill(500ms, "M10: motion comes back by itself");
}

}  // namespace intaglio::drivers
