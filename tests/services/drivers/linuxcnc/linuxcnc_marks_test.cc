// Contours on LinuxCNC with a beam: what HAL's sampler has seen of the axes and of the
// beam, against the marks.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "services/drivers/interface/mark_edges.h"
#include "services/drivers/linuxcnc/linuxcnc_driver.h"
#include "services/drivers/linuxcnc/marks/contour_plan.h"
#include "services/drivers/linuxcnc/marks/linuxcnc_course_driver.h"
#include "services/job/plan/course_motion.h"
#include "tests/services/drivers/linuxcnc/driven_axes.h"
#include "tests/services/drivers/linuxcnc/linuxcnc_mark_rig.h"

namespace intaglio::linuxcnc {
namespace {

using drivers::HalSample;
using drivers::MarkFate;
using ::testing::HasSubstr;
using namespace std::chrono_literals;

constexpr double kTolerance_mm = 0.02;
const Vec2 kOrigin_mm(10, 20);

class LinuxcncContours : public ::testing::Test {
 protected:
  void SetUp() override {
    if (const std::string why = EnterNamespace(); !why.empty()) GTEST_SKIP() << why;
    Start(nullptr);
  }
  void Start(void (*change)(MachineSpec& profile)) {
    rig_.reset();
    rig_ = std::make_unique<BeamRig>("", change);
    ASSERT_TRUE(StepUntil([&] { return state().link_up && state().settled; }))
        << state().message;
  }
  const drivers::MarkDeviceState& state() const { return rig_->driver->state(); }
  template <typename Condition>
  bool StepUntil(Condition condition) {
    for (int i = 0; i < 20'000; ++i) {
      if (condition()) return true;
      rig_->Step();
    }
    return false;
  }
  void StepFor(std::chrono::milliseconds time) {
    for (auto i = time.count(); i > 0; --i) rig_->Step();
  }
  void Begin(const mark::MarkSet& set) {
    ASSERT_TRUE(StepUntil([&] { return state().settled; }));
    const Status begun = rig_->driver->Begin(++run_, set.pens);
    ASSERT_TRUE(begun) << begun.error().message;
    for (std::uint32_t i = 0; i < set.marks.size(); ++i)
      ASSERT_TRUE(rig_->driver->Append({i, set.marks[i]}));
    ASSERT_TRUE(rig_->driver->Finish());
  }
  std::optional<MarkFate> LastOf(std::uint32_t mark) const {
    std::optional<MarkFate> fate;
    for (const drivers::MarkEvent& event : rig_->events)
      if (event.run == run_ && event.mark == mark) fate = event.fate;
    return fate;
  }
  /// LinuxCNC runs in real time, here on a kernel that has none: a run whose rows came
  /// late is made again, twice at most. What HAL has seen of the last one is recorded.
  void CutInTime(const mark::MarkSet& set) {
    constexpr int kRuns = 3;
    for (int run = 0; run < kRuns; ++run) {
      rig_->tap.Record();
      Begin(set);
      ASSERT_TRUE(StepUntil([&] { return state().settled; })) << state().fault;
      StepFor(100ms);
      if (state().fault.find("too busy") == std::string::npos) break;
      ASSERT_TRUE(rig_->driver->Reset());
      StepFor(300ms);
    }
    ASSERT_EQ(state().fault, "");
  }
  bool RunIntoTheFirst(const mark::MarkSet& set) {
    Begin(set);
    return StepUntil([&] { return rig_->is_on(); });
  }

  std::unique_ptr<BeamRig> rig_;
  std::uint32_t run_ = 0;
};

mark::Mark Star(const Vec2& middle_mm, double radius_mm) {
  mark::Mark star;
  star.closed = true;
  for (int i = 0; i < 10; ++i) {
    const double r = i % 2 == 0 ? radius_mm : radius_mm * 0.45, a = i * M_PI / 5;
    star.places.push_back(
        {{middle_mm.x() + r * std::cos(a), middle_mm.y() + r * std::sin(a)}});
  }
  return star;
}

/// Sixteen corners, and a circle of two arcs.
mark::MarkSet WheelAndRing() {
  mark::MarkSet set{{CutterPen(40)}, {{}, {}}};
  set.marks[0].closed = set.marks[1].closed = true;
  for (int i = 0; i < 16; ++i) {
    const double a = i * M_PI / 8;
    set.marks[0].places.push_back({{8 + 6 * std::cos(a), 8 + 6 * std::sin(a)}});
  }
  set.marks[1].places = {{{20, 5}, 1}, {{26, 5}, 1}};
  return set;
}

double DistanceTo(const contour::Edges& edges, const Vec2& at_mm) {
  double nearest_mm = 1e9;
  for (const contour::Edge& edge : edges)
    nearest_mm = std::min(nearest_mm, contour::DistanceTo(edge, at_mm));
  return nearest_mm;
}

struct Seen {
  std::vector<Vec2> lit_mm;
  std::uint64_t first_row = 0, last_row = 0;
};

Seen SeenOf(const std::vector<HalSample>& samples, std::uint32_t mark) {
  Seen seen;
  for (const HalSample& sample : samples) {
    if (!sample.Has(drivers::kHalLaser) || sample.tick != mark + 1) continue;
    if (seen.lit_mm.empty()) seen.first_row = sample.row;
    seen.last_row = sample.row;
    seen.lit_mm.push_back(sample.actual_mm.head<2>() - kOrigin_mm);
  }
  return seen;
}

TEST_F(LinuxcncContours, AreCutAsPlannedWithTheBeamOnThemAlone) {
  const mark::MarkSet set = WheelAndRing();
  CutInTime(set);
  const MachineSpec profile = CutterProfile(rig_->machine.folder());
  std::size_t lit_count = 0;
  for (std::uint32_t i = 0; i < set.marks.size(); ++i) {
    EXPECT_EQ(LastOf(i), MarkFate::kDone);
    const Seen seen = SeenOf(rig_->tap.recorded(), i);
    lit_count += seen.lit_mm.size();
    const auto plan = drivers::PlanContour(set.marks[i], set.pens[0], profile, 1e-3);
    ASSERT_TRUE(plan) << plan.error().message;
    // In each period of the plan, without a gap.
    EXPECT_EQ(seen.lit_mm.size(), plan->lit_end - plan->lit_begin);
    EXPECT_EQ(seen.last_row - seen.first_row + 1, seen.lit_mm.size());
    const contour::Edges edges = drivers::EdgesOfMark(set.marks[i]);
    double worst_mm = 0, missed_mm = 0;
    contour::Edges way;
    for (std::size_t k = 0; k < seen.lit_mm.size(); ++k) {
      worst_mm = std::max(worst_mm, DistanceTo(edges, seen.lit_mm[k]));
      if (k > 0 && (seen.lit_mm[k] - seen.lit_mm[k - 1]).norm() > 1e-9)
        way.push_back(contour::MakeLine(seen.lit_mm[k - 1], seen.lit_mm[k]));
    }
    for (const contour::Edge& edge : edges) {
      for (int k = 0; k <= 50; ++k)
        missed_mm = std::max(
            missed_mm, DistanceTo(way, contour::PointAt(edge, edge.length_mm * k / 50)));
    }
    EXPECT_LE(worst_mm, kTolerance_mm + 1e-4);
    EXPECT_LE(missed_mm, kTolerance_mm + 1e-4);
    const auto path = CoursePathAlong(edges, set.pens[0].speed_mm_s).value();
    const std::vector<double> stops(path.node_count() - 2, 0);
    const double stopping_s = course::PlanSpeeds(path, stops, 2000).duration_s;
    const double lit_s = 1e-3 * static_cast<double>(seen.lit_mm.size());
    EXPECT_NEAR(lit_s, plan->duration_s, 0.02);
    EXPECT_LT(lit_s, 0.9 * stopping_s);
    std::cout << fmt::format(
        "  mark {}: {:.3f} s, planned {:.3f} s, with stops {:.3f} s; {:.1f} um from the "
        "contour, {:.1f} um of it missed\n",
        i, lit_s, plan->duration_s, stopping_s, 1e3 * worst_mm, 1e3 * missed_mm);
  }
  std::size_t all = 0;
  for (const HalSample& sample : rig_->tap.recorded())
    all += sample.Has(drivers::kHalLaser) ? 1 : 0;
  EXPECT_EQ(all, lit_count) << "the beam was on outside of the marks";
}

// Simulated axes are where they are commanded. So what HAL has commanded, as its sampler
// has seen it, is given to axes that are integrated here: an oscillator of 60 Hz.
TEST_F(LinuxcncContours, KeepTheToleranceOnAxesThatLag) {
  constexpr double kNatural_rad_s = 2 * M_PI * 60, kDamping = 0.5;
  Start([](MachineSpec& profile) {
    profile.mutable_second_order()->set_natural_frequency_hz(60);
    profile.mutable_second_order()->set_damping_ratio(0.5);
    for (AxisLimits* axis : {profile.mutable_x(), profile.mutable_y()})
      axis->set_max_acceleration_mm_s2(1000);
  });
  const mark::MarkSet set = WheelAndRing();
  CutInTime(set);
  std::vector<Vec2> commanded_mm;
  for (const HalSample& sample : rig_->tap.recorded())
    commanded_mm.push_back(sample.target_mm.head<2>() - kOrigin_mm);
  const auto driven_mm = Driven(commanded_mm, kNatural_rad_s, kDamping, 1e-3);
  double worst_mm = 0, commanded_worst_mm = 0;
  for (std::size_t i = 0; i < driven_mm.size(); ++i) {
    const HalSample& sample = rig_->tap.recorded()[i];
    if (!sample.Has(drivers::kHalLaser)) continue;
    const contour::Edges edges = drivers::EdgesOfMark(set.marks[sample.tick - 1]);
    worst_mm = std::max(worst_mm, DistanceTo(edges, driven_mm[i]));
    commanded_worst_mm = std::max(commanded_worst_mm, DistanceTo(edges, commanded_mm[i]));
  }
  EXPECT_LE(worst_mm, 1.1 * kTolerance_mm);
  EXPECT_GT(commanded_worst_mm, kTolerance_mm) << "nothing is compensated";
  std::cout << fmt::format("  {:.1f} um as driven, {:.1f} um as commanded\n",
                           1e3 * worst_mm, 1e3 * commanded_worst_mm);
}

TEST_F(LinuxcncContours, EndInTheVeryPeriodInWhichTheRowsEnd) {
  ASSERT_TRUE(RunIntoTheFirst({{CutterPen(5)}, {Star({8, 8}, 6)}}));
  rig_->tap.Record();
  // The host stands still, but for the tap.
  for (int i = 0; i < 300; ++i) {
    std::this_thread::sleep_for(1ms);
    rig_->tap.Pump();
  }
  ASSERT_TRUE(StepUntil([&] { return state().settled; }));
  for (const HalSample& sample : rig_->tap.recorded()) {
    EXPECT_TRUE(!sample.Has(drivers::kHalLaser) || sample.Has(drivers::kHalFresh));
  }
  EXPECT_EQ(LastOf(0), MarkFate::kBroken);
  EXPECT_THAT(state().fault, HasSubstr("too busy"));
  EXPECT_TRUE(state().safe_state);
  EXPECT_GT(state().openings, 0u);
}

TEST_F(LinuxcncContours, EndWithoutAPermissionByHalAlone) {
  ASSERT_TRUE(RunIntoTheFirst({{CutterPen(5)}, {Star({8, 8}, 6)}}));
  const HalSample before = rig_->tap.newest();
  ASSERT_TRUE(before.Has(drivers::kHalWarm));
  rig_->permits = false;
  StepFor(400ms);
  EXPECT_FALSE(rig_->is_on());
  EXPECT_FALSE(rig_->tap.newest().Has(drivers::kHalWarm)) << "HAL still has a permission";
  ASSERT_TRUE(StepUntil([&] { return state().settled; }));
  EXPECT_EQ(LastOf(0), MarkFate::kBroken);
}

TEST_F(LinuxcncContours, NeedAPlaceThatIsKnown) {
  const mark::MarkSet set{{CutterPen(5)}, {Star({8, 8}, 6)}};
  ASSERT_TRUE(RunIntoTheFirst(set));
  const std::uint32_t openings = state().openings;
  rig_->machine.Command("sets axes-homed 0");
  ASSERT_TRUE(StepUntil([&] { return state().settled; }));
  EXPECT_FALSE(rig_->is_on());
  EXPECT_EQ(LastOf(0), MarkFate::kBroken);
  EXPECT_EQ(state().openings, openings + 1);
  ASSERT_TRUE(rig_->driver->Reset());
  StepFor(300ms);
  const Status lost = rig_->driver->Begin(9, set.pens);
  ASSERT_FALSE(lost);
  EXPECT_THAT(lost.error().message, HasSubstr("home them"));
  rig_->Command("sets axes-homed 1");
  StepFor(100ms);
  EXPECT_TRUE(rig_->driver->Begin(10, set.pens));
}

TEST_F(LinuxcncContours, EndWhereTheAxesLeaveTheirRow) {
  ASSERT_TRUE(RunIntoTheFirst({{CutterPen(5)}, {Star({8, 8}, 6)}}));
  // An axis that does not follow any more.
  rig_->machine.Command("unlinkp x-axis.in0");
  ASSERT_TRUE(StepUntil([&] { return state().settled; }));
  EXPECT_EQ(LastOf(0), MarkFate::kBroken);
  EXPECT_THAT(state().fault, HasSubstr("near.difference"));
}

TEST_F(LinuxcncContours, RefuseWhatThisTableCannotMake) {
  mark::Pen weak = CutterPen(10);
  weak.power_ratio = 0.4;
  const Status refused = rig_->driver->Begin(1, std::vector{weak});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("a power of 0.4"));
}

TEST_F(LinuxcncContours, AreRefusedByAHalOfPulsesAndPulsesByABeam) {
  MachineSpec profile = CutterProfile(rig_->machine.folder());
  *profile.mutable_motion_line() = profile.mark_line();
  drivers::LinuxcncDriver pulses(profile, rig_->tap.Opener(), link::MonotonicClock());
  for (int i = 0; i < 50 && pulses.refusal().empty(); ++i) {
    static_cast<drivers::MotionDriver&>(pulses).Poll();
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_THAT(pulses.refusal(), HasSubstr("was started with --beam"));
}

}  // namespace
}  // namespace intaglio::linuxcnc
