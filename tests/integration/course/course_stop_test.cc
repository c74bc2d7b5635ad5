// A laser cutter whose job is disturbed: paused, its door opened, held at the controller,
// its processes killed. The judge is the way that the beam really went: no contour is cut
// twice without a person's consent, and of none is it unknown whether it was cut.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>
#include <random>
#include <thread>

#include "tests/integration/course/course_shop.h"

namespace intaglio::testing {
namespace {

using namespace std::chrono_literals;
using formats::PointOutcome;

constexpr int kColumns = 6, kCircles = 24;
constexpr double kPitch_mm = 4, kKerf_mm = 0.2, kRadius_mm = 1.5;

/// Openings into a sheet: the beam runs half the kerf inside them.
std::string Circles() {
  std::string text =
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="24mm" height="16mm" )"
      R"(viewBox="0 0 24 16">)";
  for (int i = 0; i < kCircles; ++i) {
    text += "<circle cx=\"" + std::to_string(2 + kPitch_mm * (i % kColumns)) +
            "\" cy=\"" + std::to_string(2 + kPitch_mm * (i / kColumns)) + "\" r=\"" +
            std::to_string(kRadius_mm) + "\"/>";
  }
  return text + "</svg>";
}

struct CutJudgement {
  std::size_t whole = 0;                ///< cut all around
  std::size_t doubled = 0;              ///< at more than the place where a contour closes
  std::size_t made = 0, uncertain = 0;  ///< by the journal
  std::size_t unknown = 0;              ///< begun, and neither made nor uncertain
  std::size_t not_made = 0;             ///< made by the journal, and not cut all around
  double stray_mm = 0;                  ///< lit beside the contours
};

class DisturbedCut : public ::testing::Test {
 protected:
  void Begin() {
    shop_.Write("circles.svg", Circles());
    ASSERT_TRUE(shop_.Open()) << shop_.Log();
    ASSERT_TRUE(shop_.Submit(
        shop_.WriteJob("circles",
                       "files: \"circles.svg\" make: COURSE_MAKE_CUT inside: true "
                       "tool_diameter_mm: 0.2 power_ratio: 0.5 speed_mm_s: 20")));
  }
  std::vector<ToolStep> Lit() const {
    std::vector<ToolStep> lit;
    for (const ToolStep& step : shop_.Way())
      if (step.on) lit.push_back(step);
    return lit;
  }
  /// So many contours are cut, or begun.
  bool AwaitBegun(std::size_t count) {
    return Eventually(
        [&] {
          if (BegunCount() == 0) shop_.GoOn();
          return BegunCount() >= count;
        },
        60s);
  }
  std::size_t BegunCount() const {
    const double each_mm = 2 * std::numbers::pi * (kRadius_mm - kKerf_mm / 2);
    double lit_mm = 0;
    for (const ToolStep& step : Lit()) lit_mm += step.length_mm();
    return static_cast<std::size_t>(std::ceil(lit_mm / each_mm));
  }
  /// Those of a busy computer: each ends the contour in hand. A product that has more of
  /// them in these small jobs is not excused by its own log.
  std::size_t Lapses() const {
    constexpr std::size_t kMaxLapses = 3;
    return std::min(kMaxLapses, shop_.Lapses());
  }
  CutJudgement Judge() const;
  void ExpectNothingDoubledOrUnknown(const CutJudgement& judgement) const {
    EXPECT_EQ(judgement.doubled, 0U);
    EXPECT_EQ(judgement.unknown, 0U);
    EXPECT_EQ(judgement.not_made, 0U);
    EXPECT_LE(judgement.stray_mm, 0.0);
    EXPECT_EQ(judgement.made + judgement.uncertain, std::size_t{kCircles});
    std::cout << "  " << judgement.whole << " cut, " << judgement.made << " made and "
              << judgement.uncertain << " uncertain by the journal\n";
  }

  CourseShop shop_{CourseShop::Machine::kLaser};
};

CutJudgement DisturbedCut::Judge() const {
  constexpr int kPlaces = 16;
  constexpr double kRound_mm = kRadius_mm - kKerf_mm / 2, kNear_mm = 0.02;
  CutJudgement judgement;
  const std::vector<ToolStep> lit = Lit();
  const mark::MarkSet set = shop_.Marks();
  EXPECT_EQ(set.marks.size(), std::size_t{kCircles});
  const auto outcomes = shop_.Outcomes(set.marks.size());
  double beside_mm = 0;
  for (const ToolStep& step : lit) beside_mm += step.length_mm();
  for (std::size_t k = 0; k < set.marks.size(); ++k) {
    // On the raster of the drawing.
    const Vec2 first = set.marks[k].places[0].at_mm;
    const Vec2 middle = kPitch_mm * ((first / kPitch_mm).array().floor() + 0.5);
    int visited = 0, again = 0;
    for (int i = 0; i < kPlaces; ++i) {
      const double angle = 2 * std::numbers::pi * (i + 0.4) / kPlaces;
      const std::size_t visits = VisitsOf(
          middle + kRound_mm * Vec2(std::cos(angle), std::sin(angle)), lit, kNear_mm);
      visited += visits > 0;
      again += visits > 1;
    }
    bool begun = false;
    for (const ToolStep& step : lit) {
      if (std::abs((step.to_mm.head<2>() - middle).norm() - kRound_mm) > kNear_mm)
        continue;
      begun = true;
      beside_mm -= step.length_mm();
    }
    const bool made = outcomes[k] == PointOutcome::kMade;
    const bool uncertain = outcomes[k] == PointOutcome::kUncertain;
    judgement.whole += visited == kPlaces;
    judgement.doubled += again > 1;
    judgement.made += made;
    judgement.uncertain += uncertain;
    judgement.unknown += begun && !made && !uncertain;
    judgement.not_made += made && visited < kPlaces;
  }
  judgement.stray_mm = beside_mm > 1e-6 ? beside_mm : 0;
  return judgement;
}

TEST_F(DisturbedCut, APauseEndsAtTheEndOfAContour) {
  Begin();
  ASSERT_TRUE(AwaitBegun(5)) << shop_.shown() << shop_.Log();
  shop_.Type({"pause", "1"});
  ASSERT_TRUE(shop_.AwaitState("paused", 20s)) << shop_.shown();
  std::this_thread::sleep_for(1s);
  const std::size_t begun = BegunCount();
  EXPECT_LT(begun, std::size_t{kCircles});
  std::this_thread::sleep_for(1s);
  EXPECT_EQ(BegunCount(), begun) << "it goes on in a pause";
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  const CutJudgement judgement = Judge();
  ExpectNothingDoubledOrUnknown(judgement);
  EXPECT_GE(judgement.whole + Lapses(), std::size_t{kCircles});
  EXPECT_LE(judgement.uncertain, Lapses());
}

TEST_F(DisturbedCut, AnOpenDoorEndsTheContourInHandAndAPersonGoesOn) {
  Begin();
  ASSERT_TRUE(AwaitBegun(5));
  shop_.AtPanel("door open");
  ASSERT_TRUE(shop_.AwaitState("paused", 20s)) << shop_.shown();
  const std::size_t begun = BegunCount();
  shop_.AtPanel("door close");
  std::this_thread::sleep_for(2s);
  EXPECT_EQ(BegunCount(), begun) << "it goes on when the door is closed";
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  const CutJudgement judgement = Judge();
  ExpectNothingDoubledOrUnknown(judgement);
  EXPECT_LE(judgement.uncertain, 1U + Lapses());
}

TEST_F(DisturbedCut, AHoldAtTheControllerEndsTheContourInHand) {
  Begin();
  ASSERT_TRUE(AwaitBegun(5));
  shop_.AtPanel("hold");
  std::this_thread::sleep_for(1s);
  const std::size_t begun = BegunCount();
  EXPECT_LT(begun, std::size_t{kCircles});
  // Behind a lost line the arm would be renewed within three seconds.
  std::this_thread::sleep_for(6s);
  EXPECT_EQ(BegunCount(), begun) << "it goes on without a person";
  ASSERT_TRUE(shop_.AwaitState("paused", 20s)) << shop_.shown();
  EXPECT_THAT(shop_.shown(), ::testing::HasSubstr("on hold"));
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  const CutJudgement judgement = Judge();
  ExpectNothingDoubledOrUnknown(judgement);
  EXPECT_LE(judgement.uncertain, 1U + Lapses());
}

TEST_F(DisturbedCut, WithConsentTheUncertainContourIsCutAgainAndNoOther) {
  Begin();
  ASSERT_TRUE(AwaitBegun(5));
  shop_.AtPanel("hold");
  ASSERT_TRUE(shop_.AwaitState("paused", 20s)) << shop_.shown();
  shop_.Type({"resume", "1", "--fire-uncertain"});
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  const CutJudgement judgement = Judge();
  EXPECT_EQ(judgement.whole, std::size_t{kCircles});
  EXPECT_EQ(judgement.made, std::size_t{kCircles});
  EXPECT_LE(judgement.doubled, 1U + Lapses());
}

// INTAGLIO_MARK_KILLS: how many times, one unless it is set.
class KilledCut : public DisturbedCut,
                  public ::testing::WithParamInterface<const char*> {};

TEST_P(KilledCut, NoContourIsCutTwiceAndNoneIsUnknown) {
  const char* const asked = std::getenv("INTAGLIO_MARK_KILLS");
  const int kills = asked != nullptr ? std::atoi(asked) : 1;
  std::mt19937 random(11);
  Begin();
  int killed = 0;
  for (int i = 0; i < kills; ++i) {
    std::this_thread::sleep_for(
        std::chrono::milliseconds(std::uniform_int_distribution(1000, 5000)(random)));
    killed += shop_.Kill(GetParam());
  }
  EXPECT_GT(killed, 0);
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  const CutJudgement judgement = Judge();
  ExpectNothingDoubledOrUnknown(judgement);
  // One contour is in hand at a time.
  EXPECT_LE(judgement.uncertain, static_cast<std::size_t>(kills) + Lapses());
}

INSTANTIATE_TEST_SUITE_P(EveryService, KilledCut,
                         ::testing::Values("intaglio-job-service", "intaglio-discretizer",
                                           "intaglio-sorter", "intaglio-marker"),
                         [](const auto& service) {
                           std::string name = service.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace intaglio::testing
