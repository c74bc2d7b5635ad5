#include "engrave/course/contour_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "tests/engrave/course/cut_program.h"
#include "tests/engrave/course/oracle.h"

namespace intaglio::course {
namespace {

TEST(MeasureContour, IsThatOfAllPlaces) {
  std::mt19937 random(5);
  std::normal_distribution<double> shift(0, 0.05);
  for (const Path& path : CutProgram(1.2, 100, 21)) {
    PathCursor cursor(path);
    std::vector<Vec2> actual;
    std::vector<double> s_mm;
    for (double s = 0; s < path.length_mm() + 0.05; s += 0.1) {
      s_mm.push_back(std::min(s, path.length_mm()));
      actual.push_back(cursor.PointAt(s_mm.back()) + Vec2(shift(random), shift(random)));
    }
    std::vector<NearestPlace> places(actual.size());
    const ContourError error = MeasureContour(path, actual, s_mm, {6, 6}, places);
    const OracleError oracle = OracleMeasure(path, actual, s_mm);
    // Between the points it examines more than the oracle, which has points alone.
    EXPECT_GE(error.worst_one_sided_mm, oracle.one_sided_mm - 1e-12);
    EXPECT_LE(error.worst_one_sided_mm, oracle.one_sided_mm + 0.03);
    // Only the chords next to the nearest point are examined; of a course as rough as
    // this one a chord further on may be nearer.
    EXPECT_GE(error.worst_node_miss_mm, oracle.node_miss_mm - 1e-12);
    EXPECT_LE(error.worst_node_miss_mm, oracle.node_miss_mm + 0.03);
    EXPECT_EQ(
        error.worst_one_sided_mm,
        std::ranges::max_element(places, {}, &NearestPlace::distance_mm)->distance_mm);
    EXPECT_EQ(error.worst_one_sided_mm,
              *std::max_element(error.one_sided_mm.begin(), error.one_sided_mm.end()));
  }
}

// A cut-off tip: all points are on the path, but the tip is missed.
TEST(MeasureContour, FindsATipThatIsCutOff) {
  const Path tip = PolylinePath({Vec2(0, 0), Vec2(10, 0), Vec2(0, 0.2)}, 50);
  std::vector<Vec2> actual;
  std::vector<double> s_mm;
  for (double s = 0; s <= tip.length_mm(); s += 0.05) {
    const double x = std::min(std::min(s, 9.0), tip.length_mm() - s);
    actual.push_back({x, s < 10 ? 0 : 0.02 * (10 - x)});
    s_mm.push_back(s);
  }
  const ContourError error = MeasureContour(tip, actual, s_mm, {3, 3});
  EXPECT_LT(error.worst_one_sided_mm, 0.02);
  EXPECT_NEAR(error.node_miss_mm[1], 1, 0.02);
}

// Both legs of a corner are equally far at the cusp: between two samples.
TEST(MeasureContour, FindsTheCuspBetweenSamples) {
  const Path corner = CornerPath(0, std::numbers::pi / 2, 10, 50);
  std::vector<Vec2> actual{{-0.3, 0.02}, {-0.16, 0.1}, {-0.04, 0.22}, {-0.02, 0.3}};
  const std::vector<double> s_mm{9.8, 9.95, 10.1, 10.3};
  const ContourError error = MeasureContour(corner, actual, s_mm, {2, 2});
  // On the chord from (-.16, .1) to (-.04, .22), where -x = y: .13.
  EXPECT_NEAR(error.worst_one_sided_mm, 0.13, 0.004);
}

TEST(MeasureContour, MeasuresArcs) {
  const std::vector<Piece> pieces{{Vec2(0, 20), 50, std::numbers::pi}};
  const Path arc = Path::Make(Vec2(0, 0), pieces).value();
  std::vector<Vec2> actual;
  std::vector<double> s_mm;
  for (int i = 0; i <= 1000; ++i) {
    const double angle = -std::numbers::pi / 2 + std::numbers::pi * i / 1000;
    actual.push_back(Vec2(0, 10) + 10.04 * Vec2(std::cos(angle), std::sin(angle)));
    s_mm.push_back(std::numbers::pi * i / 100);
  }
  const ContourError error = MeasureContour(arc, actual, s_mm, {2, 2});
  EXPECT_NEAR(error.worst_one_sided_mm, 0.04, 1e-9);
  // The nodes to chords 31 um long: flatter than the circle by 12 nm.
  EXPECT_NEAR(error.worst_node_miss_mm, 0.04, 1e-4);
}

}  // namespace
}  // namespace intaglio::course
