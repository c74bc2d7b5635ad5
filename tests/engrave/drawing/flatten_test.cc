#include "engrave/drawing/flatten.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "engrave/core/segment.h"
#include "engrave/drawing/pieces.h"

namespace intaglio::drawing {
namespace {

constexpr double kChordTolerance_mm = 0.001;
constexpr int kCurveSamples = 1000;

double DistanceFrom(const PointList& line_mm, const Vec3& p) {
  double squared = (p - line_mm.front()).squaredNorm();
  for (std::size_t i = 1; i < line_mm.size(); ++i)
    squared =
        std::min(squared, SquaredDistanceFromSegment(p, line_mm[i - 1], line_mm[i]));
  return std::sqrt(squared);
}

/// How far a piece, sampled densely, is from its polyline at most.
template <typename At>
double Deviation(const Piece& piece, const At& at) {
  Curve curve;
  curve.pieces = {piece};
  const auto flat = FlattenCurve(curve);
  EXPECT_TRUE(flat);
  double worst_mm = 0;
  for (int i = 0; flat && i <= kCurveSamples; ++i)
    worst_mm =
        std::max(worst_mm, DistanceFrom(flat->points_mm, at(i * 1.0 / kCurveSamples)));
  return worst_mm;
}

class Bends : public testing::Test {
 protected:
  double Uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Vec3 Place() { return {Uniform(-40, 40), Uniform(-40, 40), 0}; }
  /// Nearly on the line through both: a curve through such points bends narrowly.
  Vec3 NearLine(const Vec3& a, const Vec3& b) {
    const double off_mm = std::pow(10, Uniform(-6, 0));
    return a + Uniform(-1, 2) * (b - a) +
           Vec3(Uniform(-off_mm, off_mm), Uniform(-off_mm, off_mm), 0);
  }
  std::mt19937_64 random_{7};
};

// The curve of degree two in a drawing whose tip was 68 um beyond its polyline.
TEST(Flatten, ReachesTheTipOfANarrowBendOfASpline) {
  Nurbs nurbs;
  nurbs.degree = 2;
  nurbs.control_mm = {{55.62853577620413, 19.587243757624, 0},
                      {27.89182751769343, -8.034365706818, 0},
                      {36.01378529579967, 0.03997575179084123, 0},
                      {-15.184703404666262, 22.6008942512238, 0}};
  nurbs.knots = {0, 0, 0, 1, 2, 2, 2};
  nurbs.weights.assign(4, 1);
  EXPECT_LT(Deviation(nurbs, [&](double t) { return PointAtKnot(nurbs, 2 * t); }),
            kChordTolerance_mm);
}

TEST_F(Bends, OfCubicCurvesAreWithinTheTolerance) {
  double worst_mm = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 from = Place(), to = Place();
    const CubicBezier bezier{{from, NearLine(from, to), NearLine(from, to), to}};
    worst_mm = std::max(worst_mm,
                        Deviation(bezier, [&](double t) { return PointAt(bezier, t); }));
  }
  EXPECT_LT(worst_mm, kChordTolerance_mm);
}

TEST_F(Bends, OfCurvesThatTurnBothWaysAreWithinTheTolerance) {
  double worst_mm = 0;
  for (int i = 0; i < 50; ++i) {
    const CubicBezier bezier{{Place(), Place(), Place(), Place()}};
    worst_mm = std::max(worst_mm,
                        Deviation(bezier, [&](double t) { return PointAt(bezier, t); }));
  }
  EXPECT_LT(worst_mm, kChordTolerance_mm);
}

TEST_F(Bends, OfRationalSplinesAreWithinTheTolerance) {
  double worst_mm = 0;
  for (int i = 0; i < 50; ++i) {
    Nurbs nurbs;
    nurbs.degree = std::uniform_int_distribution<int>(1, 5)(random_);
    const auto degree = static_cast<std::size_t>(nurbs.degree);
    const Vec3 from = Place(), to = Place();
    for (std::size_t k = 0; k < degree + 3; ++k) {
      nurbs.control_mm.push_back(k % 2 == 0 ? Place() : NearLine(from, to));
      nurbs.weights.push_back(std::pow(10, Uniform(-1, 1)));
    }
    nurbs.knots.assign(degree + 1, 0);
    for (std::size_t k = 0; k < degree + 3; ++k)
      nurbs.knots.push_back(std::min(3.0, static_cast<double>(k + 1)));
    worst_mm = std::max(
        worst_mm, Deviation(nurbs, [&](double t) { return PointAtKnot(nurbs, 3 * t); }));
  }
  EXPECT_LT(worst_mm, kChordTolerance_mm);
}

TEST_F(Bends, OfNarrowEllipsesAreWithinTheTolerance) {
  double worst_mm = 0;
  for (int i = 0; i < 200; ++i) {
    const Vec3 major = Place();
    const Vec3 across = Vec3(-major.y(), major.x(), 0) * std::pow(10, Uniform(-7, 0));
    const EllipticArc arc{Place(), major, across, Uniform(-7, 7), Uniform(-7, 7)};
    worst_mm =
        std::max(worst_mm, Deviation(arc, [&](double t) { return PointAt(arc, t); }));
  }
  EXPECT_LT(worst_mm, kChordTolerance_mm);
}

}  // namespace
}  // namespace intaglio::drawing
