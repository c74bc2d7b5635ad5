// Long webs under the virtual head, by its driver: at 98 % of the largest speed all marks
// are made, at 102 % what is missed is known before. The judge is the head's record.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>

#include "engrave/galvo/files/ct5_tables.h"
#include "engrave/galvo/head_fit.h"
#include "engrave/proof/mark_comparison.h"
#include "services/job/marks/job_marks.h"
#include "tests/services/drivers/galvo/head_bench.h"
#include "tests/test_folder.h"

namespace intaglio::drivers {
namespace {

using ::testing::HasSubstr;

MachineSpec WebProfile(double field_mm) {
  MachineSpec machine = HeadProfile();
  machine.mutable_scan_head()->set_field_mm(field_mm);
  machine.mutable_scan_head()->set_encoder_count_um(23);
  return machine;
}

/// Circles of 1 mm and squares at random places of so much web.
mark::MarkSet MarksOver(double length_mm, double across_mm) {
  std::mt19937 random(31);
  std::uniform_real_distribution<double> gap(1, 9), across(-across_mm, across_mm);
  mark::MarkSet set{{{"pen", 1500, 0.5, 0, 1, 0, 0}}, {}};
  bool square = false;
  for (double s_mm = 0; s_mm < length_mm; s_mm += gap(random)) {
    const double y = across(random);
    set.marks.push_back(CircleMark({0, y}, 1, s_mm));
    if (square) {
      set.marks.back().places = {
          {{0, y}, 0}, {{1, y}, 0}, {{1, y + 1}, 0}, {{0, y + 1}, 0}};
    }
    square = !square;
  }
  return set;
}

struct WebPlan {
  mark::MarkSet set;
  double max_mm_s = 0, field_mm = 0;
  std::vector<galvo::TimedMark> timed;
};

WebPlan PlanOf(const MachineSpec& machine, const mark::MarkSet& set) {
  const HeadFigures head = HeadFiguresOf(machine);
  WebPlan plan;
  plan.set = OrderForWeb(set, head, true).value();
  plan.timed = TimedMarksOf(plan.set, head);
  plan.field_mm = head.web_field_mm();
  plan.max_mm_s = galvo::MaxSpeed(plan.timed, plan.field_mm).value();
  return plan;
}

void RunAt(HeadBench& bench, const WebPlan& plan) {
  ASSERT_TRUE(bench.Connect());
  bench.Until([] { return false; }, 0.5);
  ASSERT_TRUE(bench.driver().Begin(1, plan.set.pens));
  for (std::uint32_t i = 0; i < plan.set.marks.size(); ++i) {
    ASSERT_TRUE(bench.Until(
        [&] { return bench.driver().Room() > 0 || bench.state().settled; }, 20));
    if (bench.state().settled) return;  // a fault
    ASSERT_TRUE(bench.driver().Append({i, plan.set.marks[i]}));
  }
  ASSERT_TRUE(bench.driver().Finish());
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 20));
}

virtual_engraver::HeadOptions TruthAt(const MachineSpec& machine, double web_mm_s) {
  auto truth = HeadTruthOf(machine);
  truth.physics.web_mm_s = web_mm_s;
  return truth;
}

TEST(GalvoRun, OfTenMetresAt98PercentOfTheLargestSpeedMissesNoMark) {
  for (const double field_mm : {100.0, 20.0}) {
    const MachineSpec machine = WebProfile(field_mm);
    const WebPlan plan = PlanOf(machine, MarksOver(10'000, 0.3 * field_mm));
    EXPECT_TRUE(
        galvo::MissedMarks(plan.timed, plan.field_mm, 0.98 * plan.max_mm_s).empty());
    HeadBench bench(machine, TruthAt(machine, 0.98 * plan.max_mm_s));
    RunAt(bench, plan);
    EXPECT_EQ(bench.state().fault, "") << field_mm;
    const auto found = proof::CompareMarks(plan.set, bench.Burnt(), true);
    EXPECT_EQ(found.made_count, plan.set.marks.size()) << field_mm;
    EXPECT_EQ(found.missed_count + found.incomplete_count + found.doubled_count, 0u);
    EXPECT_EQ(found.stray_tick_count, 0u);
    EXPECT_LE(found.worst.place_um, 20) << field_mm;
    RecordProperty("run_" + std::to_string(static_cast<int>(field_mm)),
                   std::to_string(plan.max_mm_s) + " mm/s, " +
                       std::to_string(plan.set.marks.size()) + " marks, place " +
                       std::to_string(found.worst.place_um) + " um");
  }
}

TEST(GalvoRun, At102PercentWhatIsMissedIsKnownBeforeAndTheHeadMissesIt) {
  const MachineSpec machine = WebProfile(100);
  const WebPlan plan = PlanOf(machine, MarksOver(10'000, 30));
  const auto missed = galvo::MissedMarks(plan.timed, plan.field_mm, 1.02 * plan.max_mm_s);
  ASSERT_FALSE(missed.empty());
  HeadBench bench(machine, TruthAt(machine, 1.02 * plan.max_mm_s));
  RunAt(bench, plan);
  EXPECT_THAT(bench.state().fault, HasSubstr("has left the field"));
  // The run ends there, and what was made before is whole.
  const auto found = proof::CompareMarks(plan.set, bench.Burnt(), true);
  // The plan counts the lead of the commands as if it were along the web.
  EXPECT_GE(found.made_count, missed.front());
  EXPECT_LE(found.made_count, missed.front() + 40);
  EXPECT_EQ(found.incomplete_count + found.doubled_count, 0u);
}

constexpr double kLensBorderRad = 20 * std::numbers::pi / 180;

/// What a board corrects a field of 100 mm with whose lens shrinks (below 0) or widens
/// the picture by this ratio at the border.
std::string CorrectionFor(double lens_ratio) {
  constexpr double kLensFieldMm = 100;
  constexpr int kLensNodes = 129, kLensBits = 5243;
  galvo::HeadFit fit;
  fit.model = galvo::HeadModel::Ideal(kLensFieldMm / 2 / kLensBorderRad);
  fit.model.lens_ratio[1] = lens_ratio / (kLensBorderRad * kLensBorderRad);
  const auto spline = galvo::Interpolation::kSpline;
  const auto deviations = galvo::CorrectionTable::Make(
                              galvo::DeviationsOf(fit, kLensFieldMm, kLensNodes), spline)
                              .value();
  const auto commands = galvo::CorrectionTable::Make(
                            galvo::CommandGrid(deviations, kLensNodes).value(), spline)
                            .value();
  const auto file = test::FreshFolder() / "head.ct5";
  std::ofstream(file, std::ios::binary)
      << galvo::WriteCt5(galvo::Ct5Of(commands, kLensBits, nullptr).value());
  return file;
}

// Marks up to 40 mm aside, where a shrunk field of 100 mm is 96 mm long: a mark is begun
// when the mirrors reach it, and the plan knows that.
TEST(GalvoRun, AFieldThatOpticsShrinkOrWidenIsUsedAsFarAsItsCorrectionReaches) {
  for (const double lens_ratio : {-0.03, 0.03}) {
    MachineSpec machine = WebProfile(100);
    machine.mutable_scan_head()->set_correction_file(CorrectionFor(lens_ratio));
    const WebPlan plan = PlanOf(machine, MarksOver(2000, 40));
    auto truth = TruthAt(machine, 0.98 * plan.max_mm_s);
    truth.physics.half_angle_rad = kLensBorderRad;
    truth.physics.lens_ratio = lens_ratio;
    HeadBench bench(machine, truth);
    RunAt(bench, plan);
    EXPECT_EQ(bench.state().fault, "") << lens_ratio;
    const auto found = proof::CompareMarks(plan.set, bench.Burnt(), true);
    EXPECT_EQ(found.made_count, plan.set.marks.size()) << lens_ratio;
    EXPECT_EQ(found.missed_count + found.incomplete_count + found.doubled_count, 0u);
    EXPECT_LE(found.worst.place_um, 20) << lens_ratio;
    RecordProperty(lens_ratio < 0 ? "shrunk" : "widened",
                   std::to_string(plan.max_mm_s) + " mm/s, place " +
                       std::to_string(found.worst.place_um) + " um");
  }
}

}  // namespace
}  // namespace intaglio::drivers
