#pragma once

// A mark rig in the middle of a check.

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <string>

#include "tests/services/drivers/marks/mark_conformance.h"
#include "tests/services/drivers/rig_expect.h"

namespace intaglio::drivers {

class MarkBench {
 public:
  explicit MarkBench(const MarkRigMaker& make, const std::string& serial_number = "")
      : rig_(make(serial_number)) {}

  MarkRig& rig() { return *rig_; }
  MarkDriver& driver() { return *rig_->driver; }
  const MarkDeviceState& state() { return driver().state(); }

  /// In each of all checks the guide laser is dark, but for an outline.
  void Step() {
    rig_->Step();
    Expect(outline_ms || !rig_->guide_is_on(), "K12: the guide laser is on");
    if (!outline_ms) return;
    // Permitted before, the gate is closed before the guide laser is on.
    Expect((!rig_->guide_is_on() && ++*outline_ms < kReportTime.count()) ||
               !rig_->gate_is_open(),
           "K12: the gate of the laser is open in an outline");
  }
  void StepFor(milliseconds time) {
    for (std::int64_t i = 0; i < time.count(); ++i) Step();
  }
  bool Until(const std::function<bool()>& condition,
             milliseconds limit = std::chrono::seconds(5)) {
    for (std::int64_t i = 0; i < limit.count() && !condition(); ++i) Step();
    return condition();
  }
  void Connect() {
    Expect(Until([&] { return state().link_up && state().settled; }),
           "the line does not come up: " + state().message);
    Expect(!state().power_up.empty(), "K9: the controller's power-up is not reported");
  }
  /// All of `count` marks are appended and the run is finished, without a wait for it.
  void Begin(std::uint32_t run, int count) {
    const mark::MarkSet set = rig_->MarksFor(count);
    Expect(driver().Begin(run, set.pens), "Begin");
    for (std::uint32_t i = 0; i < set.marks.size(); ++i)
      Expect(driver().Append({i, set.marks[i]}), "Append");
    Expect(driver().Finish(), "Finish");
  }
  std::optional<MarkFate> LastOf(std::uint32_t run, std::uint32_t mark) const {
    std::optional<MarkFate> fate;
    for (const MarkEvent& event : rig_->events)
      if (event.run == run && event.mark == mark) fate = event.fate;
    return fate;
  }
  /// Four marks, of which the second is in hand, and the tool is on.
  void RunIntoTheSecond(std::uint32_t run) {
    Begin(run, 4);
    Expect(Until([&] {
             return LastOf(run, 1) == MarkFate::kBegun && rig_->is_on() &&
                    rig_->work_count() > 0;
           }),
           "K3: the second mark is not begun: " + state().fault);
    StepFor(milliseconds(30));
  }
  void ExpectGoodRun(std::uint32_t run) {
    Expect(Until([&] { return state().settled; }),
           "K4: it does not settle: " + state().fault);
    Begin(run, 2);
    Expect(Until([&] { return state().settled; }, std::chrono::seconds(30)),
           "K3: a run does not end: " + state().fault);
    for (const std::uint32_t mark : {0U, 1U})
      Expect(LastOf(run, mark) == MarkFate::kDone,
             "K3: a mark is not done: " + state().fault);
  }
  /// Nothing is on, and nothing works.
  void ExpectStill(milliseconds time, const std::string& violation) {
    const std::uint64_t before = rig_->work_count();
    for (std::int64_t i = 0; i < time.count(); ++i) {
      Step();
      Expect(!rig_->is_on(), violation + ": the tool is on");
      Expect(rig_->work_count() == before, violation + ": it works");
    }
  }
  /// As a person does: homed, or the zero set where the tool is.
  void FindPlace() {
    HandMotion* const hand = driver().hand();
    Expect(hand != nullptr, "K10: nobody can find the place of the tool");
    if (!hand->Home())
      Expect(hand->SetZero(state().position_mm, {true, true, true}), "SetZero");
    Expect(Until([&] { return hand->state().at_rest && state().place_lost.empty(); },
                 std::chrono::seconds(30)),
           "K10: the place stays lost");
  }

  std::optional<int> outline_ms;  ///< an outline was begun before so long

 private:
  std::unique_ptr<MarkRig> rig_;
};

}  // namespace intaglio::drivers
