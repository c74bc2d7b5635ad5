// Repeats that begin at print marks: the driver of a scan head at the virtual head, whose
// record has where each print mark lies on the web. That alone judges the places.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "tests/services/drivers/galvo/head_bench.h"

namespace intaglio::drivers {
namespace {

using ::testing::HasSubstr;

constexpr double kPrintPitch = 20, kPrintOffset = -6, kWeb_mm_s = 100;
constexpr std::uint32_t kPrintedRepeats = 24, kMarksOfRepeat = 2;
constexpr PrintEye kPrintedEye{.pitch_mm = kPrintPitch,
                               .offset_mm = kPrintOffset,
                               .tolerance_mm = 3,
                               .max_missing = 2};

MachineSpec EyeProfile() {
  MachineSpec machine = HeadProfile();
  machine.mutable_scan_head()->set_encoder_count_um(23);
  machine.mutable_scan_head()->set_eye_mm(80);
  return machine;
}

virtual_engraver::HeadOptions PrintedTruth() {
  auto truth = HeadTruthOf(EyeProfile());
  truth.physics.web_mm_s = kWeb_mm_s;
  truth.physics.eye_mm = 80;
  truth.physics.print = {.pitch_mm = kPrintPitch};
  return truth;
}

/// Two circles beside each other, in each repeat.
mark::MarkSet PrintedRepeatSet(std::uint32_t first = 0) {
  mark::MarkSet set{{{"pen", 500, 0.5, 0, 1, 0, 0}}, {}};
  for (std::uint32_t i = first; i < kPrintedRepeats; ++i) {
    set.marks.push_back(CircleMark({2, -8}, 1, kPrintPitch * i));
    set.marks.push_back(CircleMark({-2, 8}, 1, kPrintPitch * i));
  }
  return set;
}

Vec2 PlannedCentre(std::uint32_t mark) {
  return mark % kMarksOfRepeat == 0 ? Vec2(2, -8) : Vec2(-2, 8);
}

struct PrintJudgement {
  std::map<std::uint32_t, double> error_um;          // by mark, of those that were burnt
  std::map<std::uint32_t, std::set<double>> prints;  // by repeat, the nearest ones
};

PrintJudgement JudgeByPrint(HeadBench& bench) {
  const formats::MarkRecord record = bench.Record();
  struct Sum {
    Vec2 centre = Vec2::Zero();
    double length = 0;
  };
  std::map<std::uint32_t, Sum> of_mark;
  for (const auto& tick : record.ticks) {
    Sum& sum = of_mark[tick.mark];
    sum.centre += tick.way_mm.norm() * (tick.place_mm - tick.way_mm / 2);
    sum.length += tick.way_mm.norm();
  }
  PrintJudgement judged;
  for (const auto& [mark, sum] : of_mark) {
    EXPECT_NEAR(sum.length, M_PI, 0.02) << "mark " << mark << " is not one circle";
    const Vec2 origin = sum.centre / sum.length - PlannedCentre(mark);
    const auto nearest =
        std::ranges::min_element(record.prints, {}, [&](const formats::PrintMark& print) {
          return std::abs(origin.x() - print.place_mm - kPrintOffset);
        });
    EXPECT_NE(nearest, record.prints.end());
    if (nearest == record.prints.end()) return judged;
    judged.error_um[mark] =
        1e3 * (origin - Vec2(nearest->place_mm + kPrintOffset, 0)).norm();
    judged.prints[mark / kMarksOfRepeat].insert(nearest->place_mm);
  }
  return judged;
}

double WorstErrorUm(const PrintJudgement& judged) {
  double worst = 0;
  for (const auto& [mark, error] : judged.error_um) worst = std::max(worst, error);
  return worst;
}

/// Each repeat has a print mark of its own.
void ExpectOwnPrints(const PrintJudgement& judged) {
  std::set<double> all;
  for (const auto& [repeat, prints] : judged.prints) {
    EXPECT_EQ(prints.size(), 1u) << "repeat " << repeat;
    for (const double place : prints)
      EXPECT_TRUE(all.insert(place).second) << "repeat " << repeat << " on another's";
  }
}

/// A print that stretches by 1 % and ripples by 10 %, as the speed of its web does.
virtual_engraver::HeadOptions UnevenTruth() {
  auto truth = PrintedTruth();
  truth.physics.web_wave_ratio = 0.1;
  truth.physics.web_wave_s = 0.7;
  truth.physics.print.stretch_ratio = 0.01;
  truth.physics.print.ripple_ratio = 0.1;
  truth.physics.print.ripple_mm = 300;
  return truth;
}

TEST(GalvoEye, EachRepeatLiesByItsPrintMark) {
  auto truth = UnevenTruth();
  const virtual_engraver::PrintedWeb print(truth.physics.print);
  truth.physics.print.missing = {12};
  truth.physics.print.false_mm = {print.PlaceOf(15) + 0.4 * kPrintPitch};
  HeadBench bench(EyeProfile(), truth);
  ASSERT_TRUE(bench.Connect());
  bench.Until([] { return false; }, 0.5);
  ASSERT_TRUE(bench.driver().UseEye(kPrintedEye));
  bench.Run(1, PrintedRepeatSet());
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 20));
  EXPECT_EQ(bench.state().fault, "");
  const PrintJudgement judged = JudgeByPrint(bench);
  std::set<std::uint32_t> left_out;
  for (std::uint32_t mark = 0; mark < kPrintedRepeats * kMarksOfRepeat; ++mark) {
    const bool made = judged.error_um.contains(mark);
    EXPECT_EQ(bench.FatesOf(mark).back(), made ? MarkFate::kDone : MarkFate::kNoPrintMark)
        << mark;
    if (!made) left_out.insert(mark / kMarksOfRepeat);
  }
  ASSERT_EQ(left_out.size(), 1u);
  EXPECT_EQ(judged.prints.size(), kPrintedRepeats - 1u);
  ExpectOwnPrints(judged);
  // Two pitches lie between its neighbours: the print mark that is missing.
  const std::uint32_t missing = *left_out.begin();
  const double before = *judged.prints.at(missing - 1).begin(),
               behind = *judged.prints.at(missing + 1).begin();
  EXPECT_NEAR(before - behind, print.PlaceOf(13) - print.PlaceOf(11), 0.05);
  EXPECT_THAT(bench.state().print_text,
              AllOf(HasSubstr("expected places: 1;"),
                    HasSubstr("repeat " + std::to_string(missing + 1))));
  EXPECT_LE(WorstErrorUm(judged), 20);
  RecordProperty("worst_um", std::to_string(WorstErrorUm(judged)));
}

// What the eye is for, and that the judge can see it.
TEST(GalvoEye, WithoutItTheSamePrintIsMissedByMillimetres) {
  HeadBench bench(EyeProfile(), UnevenTruth());
  ASSERT_TRUE(bench.Connect());
  bench.Until([] { return false; }, 0.5);
  bench.Run(1, PrintedRepeatSet());
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 20));
  const PrintJudgement judged = JudgeByPrint(bench);
  EXPECT_GT(WorstErrorUm(judged), 2000);
  // Had a person laid the first repeat upon its print mark, the others would not be on
  // theirs.
  const auto record = bench.Record();
  std::map<std::uint32_t, double> x_mm;
  for (const auto& tick : record.ticks) {
    if (tick.mark % kMarksOfRepeat == 0)
      x_mm.try_emplace(tick.mark / kMarksOfRepeat, tick.place_mm.x());
  }
  ASSERT_EQ(x_mm.size(), kPrintedRepeats);
  double drift_mm = 0;
  for (const auto& [repeat, x] : x_mm) {
    const double by_print = record.prints[repeat].place_mm - record.prints[0].place_mm;
    drift_mm = std::max(drift_mm, std::abs(x - x_mm.at(0) - by_print));
  }
  EXPECT_GT(drift_mm, 2);
  RecordProperty("drift_mm", std::to_string(drift_mm));
}

TEST(GalvoEye, MoreMissingThanMayBeEndTheRun) {
  auto truth = PrintedTruth();
  truth.physics.print.missing = {10, 11, 12};
  HeadBench bench(EyeProfile(), truth);
  ASSERT_TRUE(bench.Connect());
  bench.Until([] { return false; }, 0.5);
  ASSERT_TRUE(bench.driver().UseEye(kPrintedEye));
  bench.Run(1, PrintedRepeatSet());
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 20));
  EXPECT_THAT(bench.state().fault, HasSubstr("3 print marks missing in a row, and "
                                             "marks.web.eye.max_missing is 2"));
  const PrintJudgement judged = JudgeByPrint(bench);
  EXPECT_LE(WorstErrorUm(judged), 20);
  ExpectOwnPrints(judged);
  const auto made = static_cast<std::uint32_t>(judged.prints.size());
  ASSERT_GE(made, 2u);
  // Two repeats are left out, and what is behind them can be made by another run.
  for (std::uint32_t mark = 0; mark < kPrintedRepeats * kMarksOfRepeat; ++mark) {
    const std::uint32_t repeat = mark / kMarksOfRepeat;
    EXPECT_EQ(bench.FatesOf(mark).back(), repeat < made       ? MarkFate::kDone
                                          : repeat < made + 2 ? MarkFate::kNoPrintMark
                                                              : MarkFate::kNotBegun)
        << mark;
  }
}

TEST(GalvoEye, AWebWithoutPrintEndsTheRun) {
  auto truth = PrintedTruth();
  truth.physics.print = {};
  HeadBench bench(EyeProfile(), truth);
  ASSERT_TRUE(bench.Connect());
  ASSERT_TRUE(bench.driver().UseEye(kPrintedEye));
  bench.Run(1, PrintedRepeatSet());
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 20));
  EXPECT_THAT(bench.state().fault, HasSubstr("no print mark 20 mm behind another one"));
  EXPECT_TRUE(bench.Burnt().empty());
}

// The web goes on while the run is paused: what it brought then is not marked later, and
// no repeat lies on another one's print mark.
TEST(GalvoEye, BehindAPauseOnlyNewPrintMarksBeginRepeats) {
  HeadBench bench(EyeProfile(), UnevenTruth());
  ASSERT_TRUE(bench.Connect());
  bench.Until([] { return false; }, 0.5);
  ASSERT_TRUE(bench.driver().UseEye(kPrintedEye));
  const mark::MarkSet set = PrintedRepeatSet();
  bench.Run(1, set, false);
  ASSERT_TRUE(bench.Until([&] { return bench.Has(13, MarkFate::kDone); }, 20));
  ASSERT_TRUE(bench.driver().Pause());
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }));
  std::uint32_t next = 0;
  for (std::uint32_t mark = 0; mark < set.marks.size(); ++mark)
    if (bench.Has(mark, MarkFate::kDone)) next = mark / kMarksOfRepeat + 1;
  bench.Until([] { return false; }, 0.73);
  const double paused_mm = bench.Record().prints.back().place_mm;
  PrintEye eye = kPrintedEye;
  eye.first_repeat = next;
  ASSERT_TRUE(bench.driver().UseEye(eye));
  ASSERT_TRUE(bench.driver().Begin(2, set.pens));
  for (std::uint32_t i = next * kMarksOfRepeat; i < set.marks.size(); ++i)
    ASSERT_TRUE(bench.driver().Append({i, set.marks[i]}));
  ASSERT_TRUE(bench.driver().Finish());
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 20));
  EXPECT_EQ(bench.state().fault, "");
  const PrintJudgement judged = JudgeByPrint(bench);
  EXPECT_LE(WorstErrorUm(judged), 20);
  ExpectOwnPrints(judged);
  for (std::uint32_t repeat = next; repeat < kPrintedRepeats; ++repeat) {
    ASSERT_TRUE(judged.prints.contains(repeat)) << repeat;
    EXPECT_LT(*judged.prints.at(repeat).begin(), paused_mm) << repeat;
  }
}

// The numbers have a gap, and what belongs to which repeat is not known any more.
TEST(GalvoEye, APrintMarkThatIsLostEndsTheRun) {
  HeadBench bench(EyeProfile(), UnevenTruth());
  ASSERT_TRUE(bench.Connect());
  bench.Until([] { return false; }, 0.5);
  ASSERT_TRUE(bench.driver().UseEye(kPrintedEye));
  bench.Run(1, PrintedRepeatSet());
  ASSERT_TRUE(bench.Until([&] { return bench.Has(3, MarkFate::kDone); }, 20));
  ASSERT_TRUE(bench.Until([&] { return !bench.head().TakePrints().empty(); }, 2));
  ASSERT_TRUE(bench.Until([&] { return bench.state().settled; }, 2));
  EXPECT_THAT(bench.state().fault, HasSubstr("were lost on the line"));
}

TEST(GalvoEye, AHeadWithoutAnEyeRefusesPrintMarks) {
  MachineSpec blind = EyeProfile();
  blind.mutable_scan_head()->clear_eye_mm();
  HeadBench bench(blind, PrintedTruth());
  ASSERT_TRUE(bench.Connect());
  const Status refused = bench.driver().UseEye(kPrintedEye);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("scan_head.eye_mm"));
  auto truth = PrintedTruth();
  truth.physics.eye_mm.reset();
  HeadBench unwired(EyeProfile(), truth);
  ASSERT_TRUE(unwired.Connect());
  const Status absent = unwired.driver().UseEye(kPrintedEye);
  ASSERT_FALSE(absent);
  EXPECT_THAT(absent.error().message, HasSubstr("reports no photo eye"));
  EXPECT_TRUE(unwired.driver().UseEye(std::nullopt));
}

}  // namespace
}  // namespace intaglio::drivers
