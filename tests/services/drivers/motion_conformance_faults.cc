// M17: what happens at a motion controller.

#include "services/drivers/interface/laser_controller.h"
#include "tests/services/drivers/motion_bench.h"
#include "tests/services/drivers/motion_conformance.h"
#include "tests/services/drivers/motion_conformance_jog.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

/// What a host compares, so that no grant of before counts any more; of a controller that
/// switches the laser.
struct KnownOfLaser {
  std::uint32_t power_up = 0, openings = 0;
  bool operator==(const KnownOfLaser&) const = default;
};
/// Null: it has no laser side, or one that is not up while the motion side alone is used.
LaserController* UsedLaser(MotionBench& bench) {
  LaserController* const laser = bench.driver().laser();
  return laser != nullptr && laser->up() ? laser : nullptr;
}
KnownOfLaser KnownOf(MotionBench& bench) {
  LaserController* const laser = UsedLaser(bench);
  if (laser == nullptr) return {};
  return {laser->identity().power_up, laser->status().openings};
}

bool IsOfTheLine(intaglio_MotionFault fault) {
  return fault == intaglio_MOTION_LINK_LOST || fault == intaglio_MOTION_STARVED ||
         fault == intaglio_MOTION_LATE;
}

void ExpectReported(MotionBench& bench, ControllerFault fault,
                    const KnownOfLaser& known) {
  const intaglio_MotionFault reported = bench.state().fault;
  const bool in_order = reported == intaglio_MOTION_OK;
  if (fault == ControllerFault::kUnplug) {
    Expect(KnownOf(bench) == known && (in_order || IsOfTheLine(reported)),
           "M17: a lost line is reported as a stop of the controller");
  } else if (UsedLaser(bench) != nullptr) {
    Expect(KnownOf(bench) != known, "M17: a stop of the controller is not counted");
    Expect(in_order || !IsOfTheLine(reported),
           "M17: a stop of the controller is reported as a lost line");
  } else {
    Expect(fault == ControllerFault::kPowerCycle ? bench.state().run == 0
                                                 : !in_order && !IsOfTheLine(reported),
           "M17: a stop of the controller is not reported");
  }
}

// Not only at its place: within the time of a lost line it is at rest, on its way.
void ExpectJogEnds(MotionBench& bench, double target_x_mm) {
  Expect(bench.RestsWithin(kSilence + 100ms), "M17: the jog goes on behind it");
  Expect(bench.x() < target_x_mm - 1, "M17: the jog goes on to its end");
  bench.StepFor(kReportTime);
  bench.ExpectStill(1s, "M17: the jog goes on behind it");
}

void AFaultEndsTheMotion(const MotionRigMaker& make, ControllerFault fault,
                         FaultInstant instant) {
  MotionBench bench(make);
  bench.Connect();
  const Vec3 jog_end_mm = bench.rig().actual_mm() + Vec3(kJogMm, 0, 0);
  if (instant == FaultInstant::kInAJog) {
    if (!CanJog(bench)) return;
    JogAQuarter(bench, jog_end_mm);
  }
  if (instant == FaultInstant::kInTheRun) bench.MoveALot(1);
  if (instant == FaultInstant::kBehindTheRun) bench.ExpectGoodRun(1);
  const KnownOfLaser known = KnownOf(bench);
  if (!bench.rig().Inflict(fault)) return;
  if (instant == FaultInstant::kInAJog) ExpectJogEnds(bench, jog_end_mm.x());
  bench.StepFor(1s);
  const Vec3 rests_mm = bench.rig().actual_mm();
  bench.rig().Relieve(fault);
  Expect(bench.Until([&] { return bench.state().link_up; }, 5s),
         "M17: the line does not come back: " + bench.Message());
  bench.StepFor(500ms);
  Expect(bench.rig().actual_mm() == rests_mm, "M17: it goes on when the cause is gone");
  bench.ExpectStill(2s, "M17: it goes on by itself");
  ExpectReported(bench, fault, known);
  if (UsedLaser(bench) != nullptr) Expect(UsedLaser(bench)->Reset(), "Reset");
  Expect(bench.driver().ClearFault(), "ClearFault");
  Expect(bench.Until([&] {
    return bench.state().fault == intaglio_MOTION_OK && bench.state().at_rest;
  }),
         "M17: the fault stays: " + bench.Message());
  bench.ExpectStill(500ms, "M17: ClearFault moves the stage");
  bench.positions.clear();
  bench.StatePlace(8);
  bench.ExpectGoodRun(9);
}

// At the instant when the place goes, the axes may be anywhere: rest, and the next motion
// by a person's will alone.
void ExpectEndWhereThePlaceIsLost(MotionBench& bench, const KnownOfLaser& known) {
  bench.ExpectFault(intaglio_MOTION_SAFE_STATE, "M18: a place that is lost in motion");
  Expect(FindHindrance(bench.state()).fault == intaglio_MOTION_PLACE_LOST,
         "M18: the place is not what keeps the next run from beginning");
  bench.StepFor(100ms + bench.rig().braking_time());
  bench.ExpectStill(300ms, "M18: the motion goes on where the place is lost");
  Expect(UsedLaser(bench) == nullptr || KnownOf(bench) != known,
         "M18: a place that is lost is not counted");
  Expect(bench.rig().FindPlace(), "M18: a person cannot state the place");
  bench.ExpectStill(1s, "M18: it goes on by itself when the place is known again");
  Expect(bench.state().fault == intaglio_MOTION_SAFE_STATE, "M18: the fault ends itself");
  if (UsedLaser(bench) != nullptr) Expect(UsedLaser(bench)->Reset(), "Reset");
  Expect(bench.driver().ClearFault(), "ClearFault");
  Expect(bench.Until([&] {
    return bench.state().fault == intaglio_MOTION_OK && bench.state().at_rest;
  }),
         "M18: the fault stays: " + bench.Message());
  bench.positions.clear();
  bench.ExpectGoodRun(9);
}

void APlaceThatIsLostEndsTheRun(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  bench.MoveALot(1);
  const KnownOfLaser known = KnownOf(bench);
  if (!bench.rig().LosePlaceInMotion()) return;
  ExpectEndWhereThePlaceIsLost(bench, known);
}

void APlaceThatIsLostEndsTheJog(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  if (!CanJog(bench)) return;
  const Vec3 target = bench.rig().actual_mm() + Vec3(kJogMm, 0, 0);
  JogAQuarter(bench, target);
  const KnownOfLaser known = KnownOf(bench);
  if (!bench.rig().LosePlaceInMotion()) return;
  ExpectEndWhereThePlaceIsLost(bench, known);
}

}  // namespace

std::vector<MotionCheck> MotionFaultChecks() {
  std::vector<MotionCheck> all = {{"M18_lost_in_a_run", &APlaceThatIsLostEndsTheRun},
                                  {"M18_lost_in_a_jog", &APlaceThatIsLostEndsTheJog}};
  for (const ControllerFault fault : kControllerFaults) {
    for (const FaultInstant instant : kMotionFaultInstants) {
      all.push_back({fmt::format("M17_{}_{}", NameOf(fault), NameOf(instant)),
                     [fault, instant](const MotionRigMaker& make) {
                       AFaultEndsTheMotion(make, fault, instant);
                     }});
    }
  }
  return all;
}

}  // namespace intaglio::drivers
