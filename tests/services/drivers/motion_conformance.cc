#include "tests/services/drivers/motion_conformance.h"

#include <cmath>

#include "tests/services/drivers/motion_bench.h"
#include "tests/services/drivers/motion_conformance_block.h"
#include "tests/services/drivers/motion_conformance_jog.h"
#include "tests/services/drivers/motion_conformance_outline.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

void RunsFollowTheirSegments(const MotionRigMaker& make) {
  MotionBench bench(make);
  Expect(!bench.state().link_up, "M2: the line is up before it was opened");
  Expect(!bench.driver().BeginRun(1, 100, 0), "M2: a run begins before the line is up");
  bench.Connect();
  for (const std::uint32_t run : {1, 2, 7}) bench.ExpectGoodRun(run);
}

// More than a queue holds, or the line takes at once.
void NoSegmentIsLostWhereThereIsNoRoom(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  Course course = bench.CourseFromHere();
  course.cruise_ticks = 300;
  bench.Begin(1);
  bench.Append(course.Segments());
  Expect(bench.Until([&] { return bench.state().at_rest && !bench.rig().moves(); }, 5s),
         "M4: the run does not end");
  Expect(bench.state().fault == intaglio_MOTION_OK, "M4: " + bench.Message());
  Expect(std::abs(bench.x() - course.end_mm()) <= bench.rig().tolerance_mm(),
         fmt::format("M4: the run ends at {}, not {}", bench.x(), course.end_mm()));
}

void AnAbortEndsTheRun(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  bench.MoveALot(1);
  Expect(bench.driver().AbortRun(), "AbortRun");
  Expect(bench.RestsWithin(kReportTime), "M5: the stage does not brake");
  bench.ExpectStill(1s, "M5: motion of an aborted run follows");
  Expect(bench.state().at_rest, "M2, M5: rest is not reported");
  Expect(bench.state().fault == intaglio_MOTION_OK, "M5: an abort is a fault");
  bench.ExpectGoodRun(2);
}

void ARunThatIsLateDoesNotBegin(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  bench.StepFor(200ms);
  Expect(bench.BeginAt(1, bench.state().tick - 5), "BeginRun");
  bench.ExpectFault(intaglio_MOTION_LATE, "M3: a run in the past");
  bench.ExpectStill(300ms, "M3: the stage moves");
  const std::uint64_t number = bench.state().number;
  bench.StepFor(kReportTime);
  Expect(bench.state().number > number, "M2: state().number does not grow");
  bench.ClearFault();
  bench.ExpectGoodRun(2);
}

void ARunIntoAnotherStopsBoth(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  bench.MoveALot(1);
  bench.Begin(2);
  Expect(bench.RestsWithin(kReportTime), "M3: the stage goes on");
  bench.ExpectFault(intaglio_MOTION_LATE, "M3: a run that begins in another");
  bench.ExpectStill(500ms, "M3: motion follows");
  bench.ClearFault();
  bench.ExpectGoodRun(3);
}

void AFaultLastsUntilItIsCleared(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  bench.Begin(1);
  bench.Append({To(0.25, kSpeed_mm_s, kRampTicks)});  // and no more
  bench.ExpectFault(intaglio_MOTION_STARVED, "M8: motion that ends in mid-run");
  Expect(bench.RestsWithin(kReportTime), "M6, M8: the stage does not brake");
  bench.StepFor(500ms);
  Expect(bench.state().fault == intaglio_MOTION_STARVED || !bench.state().link_up,
         "M6: the fault goes by itself");
  if (bench.BeginAt(2, bench.state().tick + 20)) {
    (void)bench.AppendAtOnce(Course().Segments());
  }
  bench.ExpectStill(500ms, "M6: a run begins before ClearFault");
  bench.ClearFault();
  bench.ExpectGoodRun(3);
}

void ATargetOutsideTheTravelIsNotDrivenTo(const MotionRigMaker& make) {
  for (const double side : {-1.0, 1.0}) {
    for (const double beyond_mm : {1e-5, 1.0, 1e4, 1e300, std::nan("")}) {
      MotionBench bench(make);
      bench.Connect();
      const double end =
          side > 0 ? bench.rig().travel_max_mm().x() : bench.rig().travel_min_mm().x();
      bench.Begin(1);
      bench.Append({To(end + side * beyond_mm, 0, 2000, true)});
      bench.ExpectFault(intaglio_MOTION_LIMIT,
                        fmt::format("M7: a target {} mm outside", beyond_mm));
      Expect(bench.RestsWithin(kReportTime), "M7: the stage does not brake");
      bench.ExpectStill(500ms, "M7: the stage moves");
      bench.ClearFault();
      bench.ExpectGoodRun(2);
    }
  }
}

/// After a cut in mid-run that is over.
void ExpectRecovery(MotionBench& bench) {
  Expect(bench.Until([&] { return bench.state().link_up; }, 3s),
         "M10: the line does not come back: " + bench.Message());
  bench.ExpectFault(intaglio_MOTION_STARVED, "M10: a run that was lost");
  bench.ExpectStill(500ms, "M10: motion comes back by itself");
  bench.ClearFault();
  bench.ExpectGoodRun(9);
}

void ACutLineBringsTheStageToRest(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  bench.MoveALot(1);
  bench.rig().CutLine(true);
  Expect(bench.Until([&] { return !bench.state().link_up; }, 300ms),
         "M2: a cut line is up");
  Expect(bench.RestsWithin(kSilence), "M9: the stage goes on without a host");
  Expect(bench.state().fault == intaglio_MOTION_LINK_LOST && !bench.Message().empty(),
         "M2: a lost line is no fault");
  Expect(bench.driver().Room() == 0, "M1: there is room on a lost line");
  Expect(!bench.driver().Append(std::vector{To(0, 0, 1)}, {}) &&
             !bench.driver().BeginRun(2, 1000, 0) && !bench.driver().AbortRun() &&
             !bench.driver().ClearFault(),
         "M2: a lost line takes commands");
  bench.StepFor(1s);
  bench.rig().CutLine(false);
  ExpectRecovery(bench);
}

// In the middle of a frame, too: of BeginRun, of segments, of what keeps the line alive.
void ALineCutAtAnyByteBringsTheStageToRest(const MotionRigMaker& make) {
  for (std::uint64_t bytes = 0; bytes < 600; bytes += 13) {
    MotionBench bench(make);
    bench.Connect();
    Course course = bench.CourseFromHere();
    course.cruise_ticks = 100;
    bench.rig().CutLineAfter(bytes);
    (void)bench.Begin(1);
    const auto segments = course.Segments();
    (void)bench.AppendAtOnce(
        std::span(segments).first(std::min(bench.driver().Room(), segments.size())));
    Expect(bench.Until([&] { return !bench.state().link_up; }),
           "M2: the line is not lost");
    Expect(bench.RestsWithin(kSilence), "M9: the stage goes on without a host");
    bench.ExpectStill(500ms, "M9: motion follows");
    Expect(bench.x() >= course.x0_mm - bench.rig().tolerance_mm() &&
               bench.x() <= course.end_mm() + bench.rig().tolerance_mm(),
           "M9: the stage has left its course");
  }
}

void APowerCycleEndsWhatWasBegun(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  bench.MoveALot(5);
  bench.rig().PowerCycle();
  Expect(!bench.state().link_up, "M2: a controller without power is up");
  (void)bench.driver().TakePositions();
  bench.positions.clear();
  bench.Connect();
  Expect(bench.state().run == 0, "M11: the run of before is reported");
  bench.ExpectStill(500ms, "M11: the run of before goes on");
  const bool of_before =
      std::ranges::any_of(bench.positions, [](const auto& p) { return p.run == 5; });
  Expect(!of_before, "M11: positions of the run of before");
  bench.StatePlace(5);
  bench.ExpectGoodRun(6);
}

void AnotherControllerMovesNothing(const MotionRigMaker& make) {
  MotionBench bench(make, "another");
  Expect(bench.Until(
             [&] { return bench.state().fault == intaglio_MOTION_WRONG_CONTROLLER; }),
         "M13: it is not refused");
  Expect(!bench.state().link_up && !bench.state().refusal.empty(),
         "M13: the refusal is not reported");
  Expect(!bench.driver().BeginRun(1, bench.state().tick + 50, 0) &&
             !bench.driver().Append(Course().Segments(), {}) &&
             !bench.driver().ClearFault() && bench.driver().Room() == 0,
         "M13: it takes commands");
  bench.ExpectStill(1s, "M13: it moves");
}

void NothingRunsWhereThePlaceIsLost(const MotionRigMaker& make) {
  MotionBench bench(make);
  bench.Connect();
  bench.ExpectGoodRun(1);
  if (!bench.rig().LosePlace()) return;
  const auto states_it = [&] {
    return bench.state().link_up &&
           FindHindrance(bench.state()).fault == intaglio_MOTION_PLACE_LOST;
  };
  Expect(bench.Until(states_it), "M18: a place that is lost is not stated");
  if (bench.state().fault != intaglio_MOTION_OK) bench.ClearFault();
  bench.Begin(2);
  bench.ExpectFault(intaglio_MOTION_SAFE_STATE, "M18: a run where the place is lost");
  Expect(bench.state().run == 2, "M18: the fault of a run is without its number");
  bench.ExpectStill(500ms, "M18: a run begins where the place is lost");
  bench.ClearFault();
  Expect(states_it(), "M18: ClearFault finds the place");
  Expect(bench.rig().FindPlace(), "M18: a person cannot state the place");
  Expect(bench.Until([&] { return !states_it(); }),
         "M18: the place stays lost: " + bench.Message());
  bench.positions.clear();
  bench.ExpectGoodRun(3);
}

std::vector<MotionCheck> AllMotionChecks() {
  std::vector<MotionCheck> all = {
      {"M2M3M4M12_runs", &RunsFollowTheirSegments},
      {"M1M4_room", &NoSegmentIsLostWhereThereIsNoRoom},
      {"M5_abort", &AnAbortEndsTheRun},
      {"M3_late", &ARunThatIsLateDoesNotBegin},
      {"M3_run_into_another", &ARunIntoAnotherStopsBoth},
      {"M6M8_fault", &AFaultLastsUntilItIsCleared},
      {"M7_travel", &ATargetOutsideTheTravelIsNotDrivenTo},
      {"M2M9M10_cut", &ACutLineBringsTheStageToRest},
      {"M9_cut_at_any_byte", &ALineCutAtAnyByteBringsTheStageToRest},
      {"M11_power_cycle", &APowerCycleEndsWhatWasBegun},
      {"M13_another_controller", &AnotherControllerMovesNothing},
      {"M18_lost_place", &NothingRunsWhereThePlaceIsLost},
      {"M14_jog", &AJogGoesToItsPlaceAndRests},
      {"M15_hold", &HoldEndsAJog},
      {"M14_refusals", &AJogIsRefusedDuringARunAndAfterAFault},
      {"M9_cut_in_a_jog", &ACutLineEndsAJog},
  };
  for (const MotionCheck& check : OutlineChecks()) all.push_back(check);
  for (const MotionCheck& check : BlockChecks()) all.push_back(check);
  for (const MotionCheck& check : MotionFaultChecks()) all.push_back(check);
  return all;
}

}  // namespace

std::span<const MotionCheck> MotionChecks() {
  static const std::vector<MotionCheck> checks = AllMotionChecks();
  return checks;
}

std::string ViolationOf(const MotionCheck& check, const MotionRigMaker& make) {
  try {
    check.run(make);
    return "";
  } catch (const std::runtime_error& violation) {
    return violation.what();
  }
}

}  // namespace intaglio::drivers
