// Jobs of marks through all processes at a virtual BJJCZ board, whose own record is the
// judge: what the beam really made, whatever was reported.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/integration/course/course_shop.h"

namespace intaglio::testing {
namespace {

using namespace std::chrono_literals;
using formats::PointOutcome;

constexpr double kPlacesPerMm = 65536.0 / 110;
constexpr std::size_t kSquares = 24;
// A computer that is too busy to permit the beam ends the mark in hand: so many marks of
// a job at most, whatever the product's log says of it.
constexpr int kLapses = 2;

std::string SquaresToMark() {
  std::string text =
      R"(<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" )"
      R"(viewBox="0 0 60 40">)";
  for (std::size_t i = 0; i < kSquares; ++i)
    text += "<rect x=\"" + std::to_string(1 + 10 * (i % 6)) + "\" y=\"" +
            std::to_string(1 + 10 * (i / 6)) + "\" width=\"7\" height=\"7\"/>";
  return text + "</svg>";
}

Vec2 MiddleOfSquare(const mark::Mark& mark) {
  Box3 box;
  for (const mark::Place& place : mark.places)
    box.Extend(Vec3(place.at_mm.x(), place.at_mm.y(), 0));
  return box.center_mm().head<2>();
}

class BoardShop : public ::testing::Test {
 protected:
  /// Each square takes 0.28 s: two lists.
  void Begin() {
    shop_.Write("squares.svg", SquaresToMark());
    shop_.Write("squares.textproto",
                "name: \"squares\" machine_file: \"machine.textproto\" marks { items { "
                "drawing { file: \"squares.svg\" } } pen { speed_mm_s: 100 power_ratio: "
                "0.5 frequency_hz: 30000 } }\n");
    ASSERT_TRUE(shop_.Open()) << shop_.Log();
    ASSERT_TRUE(shop_.Submit(shop_.folder() / "squares.textproto"));
  }
  struct Made {
    std::vector<double> ratio;  ///< of each mark's length, by the board
    double beside_mm = 0;       ///< farthest from all marks
  };
  /// Squares lie apart: a stroke belongs to the mark whose middle is nearest.
  Made JudgeBoard() const {
    const mark::MarkSet set = shop_.Marks();
    Made made{std::vector<double>(set.marks.size()), 0};
    std::ifstream record(shop_.board_record());
    std::string word;
    Vec2 from, to;
    double begin_us = 0, end_us = 0, lit_us = 0;
    while (record >> word >> from.x() >> from.y() >> to.x() >> to.y() >> begin_us >>
           end_us >> lit_us) {
      const Vec2 a = (from.array() - 32768) / kPlacesPerMm,
                 b = (to.array() - 32768) / kPlacesPerMm;
      std::size_t nearest = 0;
      double best = 1e9;
      for (std::size_t i = 0; i < set.marks.size(); ++i) {
        const double distance = (MiddleOfSquare(set.marks[i]) - (a + b) / 2).norm();
        if (distance < best) best = distance, nearest = i;
      }
      if (set.marks.empty()) continue;
      made.ratio[nearest] += (b - a).norm() / mark::LengthOf(set.marks[nearest]);
      const Vec2 middle = MiddleOfSquare(set.marks[nearest]);
      for (const Vec2& at : {a, b})
        made.beside_mm =
            std::max(made.beside_mm, std::abs((at - middle).cwiseAbs().maxCoeff() - 3.5));
    }
    return made;
  }
  double MadeInAll() const {
    double sum = 0;
    for (const double ratio : JudgeBoard().ratio) sum += ratio;
    return sum;
  }
  /// None twice and none beside; what the journal calls made is whole, and what it calls
  /// uncertain is not more than what was in hand. Returns how many are uncertain.
  int ExpectJournalIsTrue() const {
    const auto outcomes = shop_.Outcomes(kSquares);
    const Made made = JudgeBoard();
    EXPECT_EQ(made.ratio.size(), kSquares);
    EXPECT_LT(made.beside_mm, 1.5 / kPlacesPerMm);
    int uncertain = 0;
    for (std::size_t i = 0; i < made.ratio.size(); ++i) {
      EXPECT_LT(made.ratio[i], 1.001) << i << " was made twice";
      if (outcomes[i] == PointOutcome::kMade)
        EXPECT_GT(made.ratio[i], 0.999) << i;
      else
        EXPECT_EQ(outcomes[i], PointOutcome::kUncertain) << i;
      uncertain += outcomes[i] == PointOutcome::kUncertain ? 1 : 0;
    }
    return uncertain;
  }
  bool AwaitMade(double count) {
    return Eventually(
        [&] {
          if (!shop_.IsOpen() && !shop_.Open()) return false;
          shop_.GoOn();
          return MadeInAll() >= count;
        },
        120s);
  }

  CourseShop shop_{CourseShop::Machine::kBoard};
};

TEST_F(BoardShop, AJobIsMadeAsItIsPlanned) {
  Begin();
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  EXPECT_LE(ExpectJournalIsTrue(), kLapses);
}

TEST_F(BoardShop, AKilledMarkerAndAPulledCableLeaveOneMarkUncertainEach) {
  Begin();
  int inflicted = 0;
  for (const double at : {2.3, 5.1, 8.7}) {
    ASSERT_TRUE(AwaitMade(at)) << shop_.shown() << shop_.Log();
    inflicted += shop_.Kill("intaglio-marker");
  }
  for (const double at : {12.4, 16.2}) {
    ASSERT_TRUE(AwaitMade(at)) << shop_.shown() << shop_.Log();
    shop_.AtPanel("unplug");
    std::this_thread::sleep_for(1s);
    shop_.AtPanel("plug");
    ++inflicted;
  }
  ASSERT_TRUE(AwaitMade(19.5)) << shop_.shown() << shop_.Log();
  shop_.AtPanel("power off");
  std::this_thread::sleep_for(1s);
  shop_.AtPanel("power on");
  ++inflicted;
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  EXPECT_LE(ExpectJournalIsTrue(), inflicted + kLapses);
}

TEST_F(BoardShop, BehindAnOpenDoorNothingIsMadeBeforeAPersonResumes) {
  Begin();
  ASSERT_TRUE(AwaitMade(4.5)) << shop_.shown() << shop_.Log();
  shop_.AtPanel("door open");
  std::this_thread::sleep_for(1s);
  const double made = MadeInAll();
  shop_.AtPanel("door close");
  std::this_thread::sleep_for(3s);
  EXPECT_EQ(MadeInAll(), made);
  ASSERT_TRUE(shop_.AwaitDone(kJobBound)) << shop_.shown() << shop_.Log();
  EXPECT_LE(ExpectJournalIsTrue(), 1 + kLapses);
}

}  // namespace
}  // namespace intaglio::testing
