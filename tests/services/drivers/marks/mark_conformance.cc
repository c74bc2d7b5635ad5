#include "tests/services/drivers/marks/mark_conformance.h"

#include "tests/services/drivers/marks/mark_bench.h"
#include "tests/services/drivers/marks/mark_conformance_outline.h"

namespace intaglio::drivers {
namespace {

using namespace std::chrono_literals;

// The permission lapses after it.
constexpr auto kLapse = 250ms;

void NothingIsTakenWithoutALineOrARun(const MarkRigMaker& make) {
  MarkBench bench(make);
  const mark::MarkSet set = bench.rig().MarksFor(1);
  Expect(!bench.state().link_up, "K1: the line is up before it was opened");
  Expect(!bench.driver().Begin(1, set.pens), "K1: a run begins before the line is up");
  Expect(!bench.driver().RequestPast(1, 0, 1), "K1: a line that is down is asked");
  bench.Connect();
  Expect(bench.driver().Room() == 0, "K1: there is room without a run");
  Expect(!bench.driver().Append({0, set.marks[0]}), "K1: a mark without a run is taken");
  bench.ExpectStill(300ms, "K1");
  bench.ExpectGoodRun(1);
  Expect(!bench.driver().Append({5, set.marks[0]}), "K1: a run that ended takes a mark");
}

void MarksAreMadeOnceAndInOrder(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.Connect();
  bench.Begin(1, 4);
  std::uint64_t worked = bench.rig().work_count();
  std::size_t known = 0;
  bool in_hand = false;
  const auto ended = [&] {
    for (; known < bench.rig().events.size(); ++known)
      in_hand = bench.rig().events[known].fate == MarkFate::kBegun;
    const std::uint64_t now = bench.rig().work_count();
    // What was made in this step, or the one before, may be of a mark that ended in it.
    Expect(now == worked || !bench.rig().events.empty(),
           "K3: it works before the first kBegun");
    worked = now;
    return bench.state().settled;
  };
  Expect(bench.Until(ended, 30s), "K3: the run does not end: " + bench.state().fault);
  Expect(!in_hand, "K3: a mark has no end");
  std::vector<std::pair<std::uint32_t, MarkFate>> expected, seen;
  for (std::uint32_t i = 0; i < 4; ++i) {
    expected.emplace_back(i, MarkFate::kBegun);
    expected.emplace_back(i, MarkFate::kDone);
  }
  for (const MarkEvent& event : bench.rig().events)
    seen.emplace_back(event.mark, event.fate);
  std::ranges::stable_sort(seen, {}, [](const auto& one) { return one.first; });
  Expect(seen == expected,
         "K3: not each mark is begun and done once: " + bench.state().fault);
  bench.ExpectStill(500ms, "K2: behind the run");
}

void WithoutPermissionItEndsByItself(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.Connect();
  bench.RunIntoTheSecond(1);
  bench.rig().permits = false;
  bench.StepFor(kLapse + bench.rig().stop_time() + kReportTime);
  if (bench.state().can_hold) {
    const std::uint64_t worked = bench.rig().work_count();
    bench.StepFor(kMaxHold - kLapse);
    Expect(bench.LastOf(1, 1) == MarkFate::kBroken, "K2: the run is not ended");
    Expect(bench.rig().work_count() == worked, "K2: it works without a permission");
  }
  bench.ExpectStill(500ms, "K2: without a permission");
  bench.rig().permits = true;
  bench.ExpectStill(500ms, "K2: with a permission, but without a run");
  Expect(bench.Until([&] { return bench.state().settled; }), "K4: it does not settle");
  Expect(bench.LastOf(1, 3) != MarkFate::kDone, "K2: a mark was made");
}

void AHoldRestsWithinTheMarkInHand(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.Connect();
  Expect(!bench.driver().Hold(), "K11: a hold is taken without a run");
  bench.RunIntoTheSecond(1);
  if (!bench.state().can_hold) {
    Expect(!bench.driver().Hold(), "K11: a hold is taken, but it cannot");
  } else {
    const bool turns = bench.rig().is_on();
    bench.rig().permits = false;
    Expect(bench.driver().Hold(), "K11: Hold");
    bench.StepFor(kHoldTime);
    const std::uint64_t worked = bench.rig().work_count();
    for (int i = 0; i < 1000; ++i) {
      bench.Step();
      Expect(bench.rig().work_count() == worked, "K11: it works in a hold");
      Expect(bench.rig().is_on() == turns, "K11: the tool is ended in a hold");
    }
    bench.rig().permits = true;
  }
  Expect(bench.Until([&] { return bench.state().settled; }, 30s),
         "K11: the run does not end: " + bench.state().fault);
  for (const std::uint32_t mark : {0U, 1U, 2U, 3U})
    Expect(bench.LastOf(1, mark) == MarkFate::kDone,
           "K11: a mark is not done: " + bench.state().fault);
}

void StopEndsTheRun(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.Connect();
  bench.RunIntoTheSecond(1);
  Expect(bench.driver().Stop(), "Stop");
  bench.StepFor(bench.rig().stop_time());
  bench.ExpectStill(500ms, "K4: behind Stop");
  Expect(bench.state().settled, "K4: it does not settle");
  for (std::uint32_t mark = 0; mark < 4; ++mark) {
    const auto fate = bench.LastOf(1, mark);
    Expect(fate && *fate != MarkFate::kBegun, "K4: a mark has no end");
    Expect(mark < 3 || fate == MarkFate::kNotBegun, "K4: the last mark was begun");
  }
  Expect(bench.driver().Reset(), "Reset");
  bench.StepFor(300ms);
  bench.ExpectGoodRun(2);
}

void ACutLineEndsTheRun(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.Connect();
  const std::uint64_t session = bench.state().session;
  bench.RunIntoTheSecond(1);
  bench.rig().CutLine(true);
  Expect(bench.Until([&] { return !bench.state().link_up; }, kSilence + 60ms),
         "K4: a line that is cut is up");
  bench.StepFor(bench.rig().stop_time());
  const std::uint64_t worked = bench.rig().work_count();
  bench.StepFor(1s);
  Expect(bench.rig().work_count() == worked, "K4: it works without a host");
  bench.rig().CutLine(false);
  Expect(bench.Until([&] { return bench.state().link_up && bench.state().settled; }),
         "K4: the line does not come back: " + bench.state().message);
  Expect(bench.state().session > session, "K4: no new session");
  bench.ExpectStill(1s, "K4: it goes on by itself");
  Expect(bench.driver().Reset(), "Reset");
  bench.StepFor(300ms);
  bench.ExpectGoodRun(2);
}

void APauseEndsBehindTheMarkInHand(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.Connect();
  bench.RunIntoTheSecond(1);
  Expect(bench.driver().Pause(), "Pause");
  Expect(bench.Until([&] { return bench.state().settled; }, 20s),
         "K5: the run does not end");
  bench.ExpectStill(500ms, "K5: behind a pause");
  for (std::uint32_t mark = 0; mark < 3; ++mark) {
    const auto fate = bench.LastOf(1, mark);
    Expect(fate == MarkFate::kDone || fate == MarkFate::kNotBegun,
           "K5: the mark in hand is not done: " + bench.state().fault);
  }
  Expect(bench.LastOf(1, 0) == MarkFate::kDone, "K5: the mark before it is not done");
  Expect(bench.LastOf(1, 3) == MarkFate::kNotBegun, "K5: the last mark was begun");
  bench.ExpectGoodRun(2);
}

void ThePastIsKnownOrUncertain(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.Connect();
  bench.ExpectGoodRun(1);
  for (const bool restarted : {false, true}) {
    if (restarted) {
      bench.rig().driver = bench.rig().MakeDriver("");
      bench.Connect();
    }
    bench.rig().events.clear();
    Expect(bench.driver().RequestPast(1, 0, 2), "RequestPast");
    Expect(bench.Until([&] { return bench.rig().events.size() >= 2; }, 1s),
           "K6: nothing is answered");
    bench.StepFor(100ms);
    Expect(bench.rig().events.size() == 2, "K6: a mark is answered twice");
    const bool knows = !restarted || bench.state().remembers_marks;
    for (const MarkEvent& event : bench.rig().events) {
      Expect(event.fate == (knows ? MarkFate::kDone : MarkFate::kUncertain),
             "K6: what became of a mark is told wrong");
    }
  }
}

void AnOpenDoorEndsItAndIsCounted(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.Connect();
  const std::uint32_t openings = bench.state().openings;
  bench.RunIntoTheSecond(1);
  bench.rig().SetDoor(false);
  bench.StepFor(bench.rig().stop_time());
  bench.ExpectStill(300ms, "K7: behind an open door");
  Expect(!bench.state().door_closed, "K7: an open door is not reported");
  Expect(bench.state().openings == openings + 1, "K7: the opening is not counted once");
  (void)bench.driver().Reset();
  const mark::MarkSet set = bench.rig().MarksFor(1);
  Expect(!bench.driver().Begin(2, set.pens), "K7: a run begins behind an open door");
  bench.rig().SetDoor(true);
  bench.ExpectStill(1s, "K7: it goes on when the door is closed");
  Expect(bench.driver().Reset(), "Reset");
  Expect(bench.Until([&] { return !bench.state().safe_state; }),
         "K7: the safe state stays");
  bench.ExpectGoodRun(3);
}

void AnotherControllerIsRefused(const MarkRigMaker& make) {
  MarkBench bench(make, "another");
  Expect(bench.Until([&] { return !bench.state().refusal.empty(); }),
         "K8: it is not refused");
  const mark::MarkSet set = bench.rig().MarksFor(1);
  Expect(!bench.state().link_up, "K8: the line of a refused controller is up");
  Expect(!bench.driver().Begin(1, set.pens), "K8: a run begins");
  bench.ExpectStill(500ms, "K8");
}

// The bench finds it, in whatever state.
void TheGuideLaserIsDark(const MarkRigMaker& make) {
  MarkBench bench(make);
  bench.rig().permits = false;
  bench.Connect();
  bench.StepFor(500ms);
  bench.rig().permits = true;
  bench.StepFor(500ms);
  bench.RunIntoTheSecond(1);
  bench.rig().SetDoor(false);
  bench.StepFor(500ms);
  bench.rig().SetDoor(true);
  bench.StepFor(500ms);
  Expect(bench.driver().Reset(), "Reset");
  Expect(bench.Until([&] { return !bench.state().safe_state; }),
         "K7: the safe state stays");
  bench.ExpectGoodRun(2);
  Expect(bench.driver().Permit(false), "Permit");
  bench.rig().permits = false;
  bench.StepFor(500ms);
}

/// What a host compares, so that no grant of before counts any more.
struct Known {
  std::string power_up;
  std::uint32_t openings = 0;
  bool operator==(const Known&) const = default;
};
Known KnownOf(MarkBench& bench) {
  return {bench.state().power_up, bench.state().openings};
}

void ExpectRunsBehindResetAlone(MarkBench& bench, std::uint32_t run) {
  const mark::MarkSet set = bench.rig().MarksFor(1);
  const bool must_reset = !bench.state().fault.empty() || bench.state().safe_state;
  Expect(!must_reset || !bench.driver().Begin(run, set.pens),
         "K9: a run begins before Reset");
  Expect(bench.driver().Reset(), "Reset");
  bench.ExpectStill(500ms, "K9: Reset");
  if (!bench.state().place_lost.empty()) {
    Expect(!bench.driver().Begin(run, set.pens), "K10: a run begins at a lost place");
    bench.FindPlace();
  }
  bench.ExpectGoodRun(run);
}

void AFaultIsReportedAndNothingGoesOn(const MarkRigMaker& make, ControllerFault fault,
                                      FaultInstant instant) {
  MarkBench bench(make);
  bench.Connect();
  if (instant == FaultInstant::kInTheRun) bench.RunIntoTheSecond(1);
  if (instant == FaultInstant::kBehindTheRun) bench.ExpectGoodRun(1);
  const Known known = KnownOf(bench);
  if (!bench.rig().Inflict(fault)) return;
  bench.StepFor(1s);
  bench.rig().Relieve(fault);
  Expect(bench.Until([&] { return bench.state().link_up; }),
         "K9: the line does not come back: " + bench.state().message);
  bench.StepFor(bench.rig().stop_time() + 100ms);
  bench.ExpectStill(3s, "K9: it goes on by itself");
  const bool of_line = fault == ControllerFault::kUnplug && bench.rig().knows_power_ups();
  Expect((KnownOf(bench) == known) == of_line,
         of_line ? "K9: a lost line is reported as a stop of the controller"
                 : "K9: a stop of the controller is not reported");
  const bool may_lose =
      fault == ControllerFault::kPowerCycle || fault == ControllerFault::kReset ||
      fault == ControllerFault::kLimit || fault == ControllerFault::kAlarm;
  Expect(!may_lose || !bench.rig().can_lose_place() || !bench.state().place_lost.empty(),
         "K10: a place that may be lost is not reported");
  ExpectRunsBehindResetAlone(bench, 2);
}

std::vector<MarkCheck> AllChecks() {
  std::vector<MarkCheck> all = {
      {"K1_refusals", &NothingIsTakenWithoutALineOrARun},
      {"K2_permission", &WithoutPermissionItEndsByItself},
      {"K3_order", &MarksAreMadeOnceAndInOrder},
      {"K4_stop", &StopEndsTheRun},
      {"K4_cut", &ACutLineEndsTheRun},
      {"K5_pause", &APauseEndsBehindTheMarkInHand},
      {"K6_past", &ThePastIsKnownOrUncertain},
      {"K7_door", &AnOpenDoorEndsItAndIsCounted},
      {"K11_hold", &AHoldRestsWithinTheMarkInHand},
      {"K8_another_controller", &AnotherControllerIsRefused},
      {"K12_guide", &TheGuideLaserIsDark},
  };
  for (const ControllerFault fault : kControllerFaults) {
    for (const FaultInstant instant : kFaultInstants) {
      all.push_back({fmt::format("K9K10_{}_{}", NameOf(fault), NameOf(instant)),
                     [fault, instant](const MarkRigMaker& make) {
                       AFaultIsReportedAndNothingGoesOn(make, fault, instant);
                     }});
    }
  }
  for (const MarkCheck& check : MarkOutlineChecks()) all.push_back(check);
  return all;
}

}  // namespace

const std::vector<MarkCheck>& MarkChecks() {
  static const std::vector<MarkCheck> checks = AllChecks();
  return checks;
}

std::string ViolationOf(const MarkCheck& check, const MarkRigMaker& make) {
  try {
    check.run(make);
    return "";
  } catch (const std::runtime_error& violation) {
    return violation.what();
  }
}

}  // namespace intaglio::drivers
