// The guarantees K1..K8 of services/drivers/interface/mark_driver.h, kept by the driver
// of a scan head and the virtual head together; and that it makes marks where they
// belong.

#include "services/drivers/galvo/galvo_driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "services/drivers/galvo/head_profile.h"
#include "tests/services/drivers/galvo/head_bench.h"

namespace intaglio::drivers {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const mark::Pen kFastPen{"fast", 1500, 0.5, 20000, 1, 0, 0};
const mark::Pen kSlowPen{"slow", 20, 0.5, 20000, 1, 0, 0};

struct Burnt {
  double worst_um = 0;  ///< of the distance from the circle
  double gap_um = 0;    ///< from the end to the beginning
  double way_mm = 0, energy_mj = 0;
};

Burnt OverCircle(const std::vector<formats::BurntTick>& ticks, std::uint32_t mark,
                 const Vec2& centre_mm, double diameter_mm) {
  Burnt burnt;
  const formats::BurntTick *first = nullptr, *last = nullptr;
  for (const formats::BurntTick& tick : ticks) {
    if (tick.mark != mark) continue;
    if (first == nullptr) first = &tick;
    last = &tick;
    const double off_mm = (tick.place_mm - centre_mm).norm() - diameter_mm / 2;
    burnt.worst_um = std::max(burnt.worst_um, 1e3 * std::abs(off_mm));
    burnt.way_mm += tick.way_mm.norm();
    burnt.energy_mj += tick.energy_mj;
  }
  if (first != nullptr)
    burnt.gap_um = 1e3 * (last->place_mm - (first->place_mm - first->way_mm)).norm();
  return burnt;
}

mark::MarkSet ThreeSlowLines() {
  return {
      {kSlowPen},
      {LineMark({0, 0}, {10, 0}), LineMark({0, 1}, {10, 1}), LineMark({0, 2}, {10, 2})}};
}

class GalvoDriver : public ::testing::Test {
 protected:
  HeadBench bench_{HeadProfile(), HeadTruthOf(HeadProfile())};

  void BeginLines() {
    ASSERT_TRUE(bench_.Connect());
    bench_.Run(1, ThreeSlowLines());
    ASSERT_TRUE(bench_.Until([&] { return !bench_.Burnt().empty(); }));
  }
  /// The beam has ended within this time, and no later tick burns.
  void ExpectDark() {
    ASSERT_TRUE(bench_.Until([&] { return bench_.state().settled; }, 2));
    const auto burnt = bench_.Burnt().size();
    bench_.Until([] { return false; }, 0.5);
    EXPECT_EQ(bench_.Burnt().size(), burnt);
    EXPECT_TRUE(bench_.state().at_rest);
  }
  void ExpectBrokenInTheFirst() {
    EXPECT_THAT(bench_.FatesOf(0), ElementsAre(MarkFate::kBegun, MarkFate::kBroken));
    for (const std::uint32_t mark : {1u, 2u}) {
      EXPECT_EQ(bench_.FatesOf(mark).back(), MarkFate::kNotBegun);
      EXPECT_FALSE(bench_.Has(mark, MarkFate::kDone));
    }
    for (const auto& tick : bench_.Burnt()) EXPECT_EQ(tick.mark, 0u);
  }
};

TEST_F(GalvoDriver, MakesMarksOnAPieceAtRestEachOnceInOrder) {
  ASSERT_TRUE(bench_.Connect());
  mark::MarkSet set{{kFastPen}, {}};
  for (int i = 0; i < 40; ++i)
    set.marks.push_back(CircleMark({-40 + 2.0 * i, 15 - 0.7 * i}, 1.5));
  bench_.Run(1, set);
  ASSERT_TRUE(bench_.Until([&] { return bench_.state().settled; }))
      << bench_.state().fault;
  EXPECT_EQ(bench_.state().fault, "");
  const auto ticks = bench_.Burnt();
  double worst_um = 0, gap_um = 0;
  for (std::uint32_t i = 0; i < 40; ++i) {
    EXPECT_THAT(bench_.FatesOf(i), ElementsAre(MarkFate::kBegun, MarkFate::kDone));
    const Burnt burnt = OverCircle(ticks, i, {-40 + 2.0 * i, 15 - 0.7 * i}, 1.5);
    worst_um = std::max(worst_um, burnt.worst_um);
    gap_um = std::max(gap_um, burnt.gap_um);
    // 25 W at 1500 mm/s, a tick of 15 um more or less.
    EXPECT_NEAR(burnt.energy_mj / burnt.way_mm, 25.0 / 1.5, 0.1) << i;
    EXPECT_NEAR(burnt.way_mm, 1.5 * M_PI, 0.02) << i;
  }
  // A step of the outputs is 1.5 um; the issue asks for 10 and 15.
  EXPECT_LT(worst_um, 5);
  EXPECT_LT(gap_um, 10);
  RecordProperty("worst_um", std::to_string(worst_um));
  RecordProperty("gap_um", std::to_string(gap_um));
  for (std::size_t i = 1; i < ticks.size(); ++i)
    EXPECT_GE(ticks[i].mark, ticks[i - 1].mark);
}

TEST_F(GalvoDriver, RefusesWhatItCannotMakeByTheMarksNumber) {  // K1
  EXPECT_FALSE(bench_.driver().Begin(1, std::array{kFastPen}));
  ASSERT_TRUE(bench_.Connect());
  EXPECT_FALSE(bench_.driver().Append({0, LineMark({0, 0}, {1, 0})}));
  ASSERT_TRUE(bench_.driver().Begin(1, std::array{kFastPen}));
  EXPECT_FALSE(bench_.driver().Begin(2, std::array{kFastPen}));
  const auto error_of = [&](const mark::Mark& mark) {
    const auto appended = bench_.driver().Append({12, mark});
    return appended ? "" : appended.error().message;
  };
  EXPECT_THAT(error_of(LineMark({0, 0}, {51, 0})), HasSubstr("mark 12: (51.000, 0.000)"));
  mark::Mark hole;
  hole.places = {{{1, 1}, 0}};
  EXPECT_THAT(error_of(hole), HasSubstr("has no length"));
  mark::Mark web = LineMark({0, 0}, {1, 0});
  web.web_mm = 100;
  EXPECT_THAT(error_of(web), HasSubstr("scan_head.encoder_count_um"));
  std::uint32_t taken = 0;
  while (bench_.driver().Append({taken, LineMark({0, 0}, {1, 0})})) ++taken;
  EXPECT_EQ(bench_.driver().Room(), 0u);
  EXPECT_GT(taken, 0u);
}

// It loses it so many turns after a mark was given to it that comes alone.
TEST_F(GalvoDriver, AHostThatLosesItsProcessorAtTheBeginningBreaksNoMark) {
  ASSERT_TRUE(bench_.Connect());
  std::uint32_t mark = 0;
  const auto stalled = [&](int turns) {
    const double from_mm = mark % 2 == 0 ? 0 : 30;  // no jump to it, which is dark
    ASSERT_TRUE(
        bench_.driver().Append({mark, LineMark({from_mm, 0}, {30 - from_mm, 0})}));
    for (int turn = 0; turn < turns; ++turn) bench_.Step();
    bench_.AdvanceHead(std::chrono::milliseconds(30));
    ASSERT_TRUE(bench_.Until([&] { return bench_.Has(mark, MarkFate::kDone); }, 1))
        << turns << " turns: " << bench_.state().fault;
    ++mark;
  };
  for (int turns = 0; turns < 40; ++turns) {
    const auto run = static_cast<std::uint32_t>(turns + 1);
    bench_.Run(run, {{kFastPen}, {}}, false);
    for (int i = 0; i < 4; ++i) ASSERT_NO_FATAL_FAILURE(stalled(turns));
    ASSERT_TRUE(bench_.driver().Finish());
    ASSERT_TRUE(bench_.Until([&] { return bench_.state().settled; }, 1));
  }
}

TEST_F(GalvoDriver, BurnsOnlyWhilePermittedAndTheControllerEndsItByItself) {  // K2
  BeginLines();
  bench_.permits = false;
  ExpectDark();
  ExpectBrokenInTheFirst();
  EXPECT_TRUE(bench_.state().safe_state);
  EXPECT_FALSE(bench_.state().shutter_open);
  EXPECT_THAT(bench_.state().fault, HasSubstr("250 ms"));
  EXPECT_FALSE(bench_.driver().Begin(2, std::array{kSlowPen}));
  bench_.permits = true;
  ASSERT_TRUE(bench_.driver().Reset());
  ASSERT_TRUE(bench_.Until([&] { return !bench_.state().safe_state; }));
  bench_.events.clear();
  bench_.Run(2, {{kFastPen}, {LineMark({0, 0}, {1, 0})}});
  ASSERT_TRUE(bench_.Until([&] { return bench_.state().settled; }));
  EXPECT_THAT(bench_.FatesOf(0), ElementsAre(MarkFate::kBegun, MarkFate::kDone));
}

TEST_F(GalvoDriver, WithdrawnPermissionAndStopEndTheBeam) {  // K4
  BeginLines();
  bench_.permits = false;
  ASSERT_TRUE(bench_.driver().Permit(false));
  ExpectDark();
  ExpectBrokenInTheFirst();
  EXPECT_EQ(bench_.state().fault, "");
  bench_.permits = true;
  bench_.events.clear();
  bench_.Run(2, ThreeSlowLines());
  ASSERT_TRUE(bench_.Until(
      [&] { return bench_.state().shutter_open && bench_.Has(0, MarkFate::kBegun); }));
  bench_.Until([] { return false; }, 0.1);
  ASSERT_TRUE(bench_.driver().Stop());
  bench_.permits = false;
  ExpectDark();
  EXPECT_EQ(bench_.FatesOf(0).back(), MarkFate::kBroken);
  EXPECT_EQ(bench_.FatesOf(2).back(), MarkFate::kNotBegun);
}

TEST_F(GalvoDriver, PausesBehindTheMarkInHand) {  // K5
  BeginLines();
  ASSERT_TRUE(bench_.driver().Pause());
  ExpectDark();
  EXPECT_THAT(bench_.FatesOf(0), ElementsAre(MarkFate::kBegun, MarkFate::kDone));
  EXPECT_EQ(bench_.FatesOf(1).back(), MarkFate::kNotBegun);
  double way_mm = 0;
  for (const auto& tick : bench_.Burnt()) {
    EXPECT_EQ(tick.mark, 0u);
    way_mm += tick.way_mm.norm();
  }
  EXPECT_NEAR(way_mm, 10, 0.01);
}

TEST_F(GalvoDriver, RemembersForAnotherHostWhatBecameOfMarks) {  // K6
  ASSERT_TRUE(bench_.Connect());
  EXPECT_TRUE(bench_.state().remembers_marks);
  const std::string power_up = bench_.state().power_up;
  mark::MarkSet set{{kSlowPen}, {}};
  set.marks = {LineMark({0, 0}, {1, 0}), LineMark({0, 1}, {10, 1}),
               LineMark({0, 2}, {10, 2})};
  bench_.Run(1, set);
  ASSERT_TRUE(bench_.Until([&] {
    const auto burnt = bench_.Burnt();
    return !burnt.empty() && burnt.back().mark == 1;
  }));
  bench_.Restart();
  ASSERT_TRUE(bench_.Connect());
  EXPECT_EQ(bench_.state().power_up, power_up);
  ASSERT_TRUE(bench_.driver().RequestPast(1, 0, 4));
  ASSERT_TRUE(bench_.Until([&] { return bench_.events.size() == 4; }));
  EXPECT_THAT(bench_.FatesOf(0), ElementsAre(MarkFate::kDone));
  EXPECT_THAT(bench_.FatesOf(1), ElementsAre(MarkFate::kBroken));
  EXPECT_THAT(bench_.FatesOf(2), ElementsAre(MarkFate::kNotBegun));
  EXPECT_THAT(bench_.FatesOf(3), ElementsAre(MarkFate::kNotBegun));
  EXPECT_TRUE(bench_.state().safe_state);
}

TEST_F(GalvoDriver, ALostLineEndsTheBeamAndTheRun) {  // K4
  BeginLines();
  const auto session = bench_.state().session;
  bench_.CutLine();
  bench_.Until([] { return false; }, 1);
  const auto burnt = bench_.Burnt().size();
  bench_.Until([] { return false; }, 0.5);
  EXPECT_EQ(bench_.Burnt().size(), burnt);
  EXPECT_FALSE(bench_.state().link_up);
  bench_.JoinLine();
  ASSERT_TRUE(bench_.Until([&] { return bench_.state().link_up; }));
  EXPECT_GT(bench_.state().session, session);
  EXPECT_TRUE(bench_.state().settled);
  EXPECT_THAT(bench_.state().fault, HasSubstr("line"));
}

TEST_F(GalvoDriver, KeyDoorAndStopButtonEndTheBeamAndAreCounted) {  // K7
  std::uint32_t openings = 0;
  std::uint32_t run = 0;
  using Head = virtual_engraver::HeadController;
  ASSERT_TRUE(bench_.Connect());
  const auto each = {std::pair{&Head::SetKey, true}, std::pair{&Head::SetDoor, true},
                     std::pair{&Head::SetStopButton, false}};
  for (const auto& [set, holds] : each) {
    bench_.events.clear();
    const auto before = bench_.Burnt().size();
    bench_.Run(++run, ThreeSlowLines());
    ASSERT_TRUE(bench_.Until([&] { return bench_.Burnt().size() > before; }));
    (bench_.head().*set)(!holds);
    ExpectDark();
    EXPECT_EQ(bench_.FatesOf(0).back(), MarkFate::kBroken);
    EXPECT_EQ(bench_.FatesOf(1).back(), MarkFate::kNotBegun);
    EXPECT_EQ(bench_.state().openings, ++openings);
    EXPECT_THAT(bench_.state().fault, HasSubstr("door"));
    (bench_.head().*set)(holds);
    ASSERT_TRUE(bench_.driver().Reset());
    ASSERT_TRUE(bench_.Until([&] { return !bench_.state().safe_state; }));
    // The lease of the permission is the host's to renew.
    ASSERT_TRUE(bench_.Until([&] { return bench_.state().shutter_open; }));
  }
}

TEST_F(GalvoDriver, RefusesAnotherHeadAndAnotherField) {  // K8
  MachineSpec profile = HeadProfile();
  profile.mutable_mark_line()->set_serial_number("sh-7");
  HeadBench other(profile, HeadTruthOf(HeadProfile()));
  EXPECT_FALSE(other.Until([&] { return other.state().link_up; }, 1));
  EXPECT_THAT(other.state().refusal, HasSubstr("virtual-head-1"));
  EXPECT_FALSE(other.driver().Begin(1, std::array{kFastPen}));
  MachineSpec wide = HeadProfile();
  wide.mutable_scan_head()->set_field_mm(110);
  HeadBench field(wide, HeadTruthOf(HeadProfile()));
  EXPECT_FALSE(field.Until([&] { return field.state().link_up; }, 1));
  EXPECT_THAT(field.state().refusal, HasSubstr("scan_head.field_mm"));
}

TEST(ScanHeadProfile, WhatIsMissingIsNamed) {
  MachineSpec machine = HeadProfile();
  EXPECT_TRUE(CheckScanHead(machine).empty());
  machine.mutable_scan_head()->set_correction_file("field.xyz");
  const auto errors = CheckScanHead(machine);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_THAT(errors[0].message, HasSubstr("scan_head.correction_file"));
  machine.clear_scan_head();
  EXPECT_THAT(CheckScanHead(machine)[0].message, HasSubstr("scan_head: is missing"));
}

/// Circles of an eighth of a second each; the first is made.
class GalvoInLockstep : public ::testing::Test {
 protected:
  static constexpr std::uint32_t kCircles = 200;

  void SetUp() override {
    ASSERT_TRUE(bench_.Connect());
    mark::MarkSet set{{mark::Pen{"pen", 200, 0.5, 20000, 1, 0, 0}}, {}};
    for (std::uint32_t i = 0; i < kCircles; ++i)
      set.marks.push_back(CircleMark(Vec2(10.0 * (i % 4), 0.5 * (i / 4)), 8));
    bench_.Run(1, set);
    ASSERT_TRUE(bench_.Until([&] { return bench_.Has(0, MarkFate::kDone); }));
    bench_.permits = false;
  }
  void ExpectAllDone() {
    ASSERT_TRUE(bench_.Until([&] { return bench_.state().settled; }))
        << bench_.state().fault;
    EXPECT_EQ(bench_.state().fault, "");
    for (std::uint32_t mark = 0; mark < kCircles; ++mark)
      EXPECT_TRUE(bench_.Has(mark, MarkFate::kDone)) << mark;
  }
  static virtual_engraver::HeadOptions Options() {
    virtual_engraver::HeadOptions options = HeadTruthOf(HeadProfile());
    options.lockstep = true;
    return options;
  }

  HeadBench bench_{HeadProfile(), Options()};
};

// No tick passes any more when all marks are made.
TEST(GalvoRunInLockstep, EndsWhenItsHostFinishesItLate) {
  virtual_engraver::HeadOptions options = HeadTruthOf(HeadProfile());
  options.lockstep = true;
  HeadBench bench(HeadProfile(), options);
  ASSERT_TRUE(bench.Connect());
  bench.Run(1, {{kFastPen}, {LineMark({0, 0}, {5, 0})}}, false);
  ASSERT_TRUE(bench.Until([&] { return bench.Has(0, MarkFate::kDone); }));
  ASSERT_FALSE(bench.Until([] { return false; }, 0.1));
  ASSERT_TRUE(bench.driver().Finish());
  EXPECT_TRUE(bench.Until([&] { return bench.state().settled; }, 1));
  EXPECT_EQ(bench.state().fault, "");
}

// Wall time says nothing of a machine whose time waits for its host.
TEST_F(GalvoInLockstep, APermissionThatIsLateByTheClockBreaksNoMark) {
  ASSERT_FALSE(bench_.Until([] { return false; }, 0.3));
  ASSERT_FALSE(bench_.state().settled) << "the run is too short for this test";
  ExpectAllDone();
}

TEST_F(GalvoInLockstep, AHoldStopsItsTimeUntilThePermissionComes) {
  ASSERT_TRUE(bench_.state().can_hold);
  ASSERT_TRUE(bench_.driver().Hold());
  // What was sent, 0.2 s of its time at most.
  ASSERT_FALSE(bench_.Until([] { return false; }, 0.1));
  const std::uint64_t burnt = bench_.burnt_ticks();
  ASSERT_FALSE(bench_.Until([] { return false; }, 2));
  EXPECT_EQ(bench_.burnt_ticks(), burnt);
  EXPECT_FALSE(bench_.state().settled);
  bench_.permits = true;
  ExpectAllDone();
}

}  // namespace
}  // namespace intaglio::drivers
