#include "engrave/discretize/picture/relief.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/engrave/discretize/oracles.h"
#include "tests/engrave/image/pictures.h"

namespace intaglio::discretize {
namespace {

using image::GreyImage;
using image::PaintGrey;

ReliefOptions Options(double width_mm, double depth_mm, double distance_mm) {
  ReliefOptions options;
  options.size.width_mm = width_mm;
  options.depth_mm = depth_mm;
  options.vertex_distance_mm = distance_mm;
  return options;
}

PointList PointsOf(const GreyImage& map, const std::optional<GreyImage>& photo,
                   const ReliefOptions& options) {
  const auto source = MakeRelief(map, photo, {}, options);
  EXPECT_TRUE(source) << source.error().message;
  SpacedCloud cloud;
  if (source) {
    EXPECT_TRUE((*source)->AddPoints({}, 0, {}, cloud));
  }
  return cloud.points_mm;
}

std::size_t CountBetween(const PointList& points, double x0, double x1) {
  return static_cast<std::size_t>(
      std::count_if(points.begin(), points.end(),
                    [&](const Vec3& p) { return p.x() >= x0 && p.x() < x1; }));
}

TEST(Relief, PointsLieOnTheSurface) {
  const auto depth = [](double u, double v) {
    return 0.5 + 0.3 * std::sin(6 * u) * std::cos(4 * v);
  };
  const GreyImage map = PaintGrey(
      400, 400, [&](int x, int y) { return depth((x + 0.5) / 400, (y + 0.5) / 400); });
  for (const bool near : {true, false}) {
    ReliefOptions options = Options(10, 4, 0.25);
    options.white_is_near = near;
    const PointList points = PointsOf(map, std::nullopt, options);
    ASSERT_GT(points.size(), 1000U);
    for (const Vec3& p : points) {
      const double z = 4 * depth(p.x() / 10, 1 - p.y() / 10);
      // Half a pixel of a quarter distance at the border, where the border goes on.
      EXPECT_NEAR(p.z(), near ? z : 4 - z, 0.03) << p.x() << ", " << p.y();
    }
  }
}

TEST(Relief, SlopesGetAsManyPointsAMm2OfSurfaceAsPlains) {
  // Flat for 5 mm, then a slope of 10 mm over 5 mm: sqrt(5) times the area.
  const GreyImage map =
      PaintGrey(400, 200, [](int x, int) { return std::max(0.0, (x - 199.5) / 200); });
  const ReliefOptions options = Options(10, 10, 0.1);
  const PointList points = PointsOf(map, std::nullopt, options);
  EXPECT_GE(MinDistance(points), 0.1);
  const auto flat = static_cast<double>(CountBetween(points, 0.5, 4.5));
  const auto slope = static_cast<double>(CountBetween(points, 5.5, 9.5));
  EXPECT_NEAR(slope / flat, std::sqrt(5.0), 0.03 * std::sqrt(5.0));
  EXPECT_NEAR(flat / (4 * 5), 0.7 / 0.01, 0.05 * 70);
}

TEST(Relief, ThePhotoGivesTheDensity) {
  const GreyImage map = PaintGrey(10, 10, [](int x, int y) { return (x + y) / 20.0; });
  const ReliefOptions options = Options(16, 3, 0.1);
  const auto white = static_cast<double>(PointsOf(map, std::nullopt, options).size());
  for (const double tone : {0.02, 0.1, 0.4, 0.8}) {
    const GreyImage photo = PaintGrey(4, 4, [&](int, int) { return tone; });
    EXPECT_NEAR(static_cast<double>(PointsOf(map, photo, options).size()), tone * white,
                0.01 * tone * white + 1);
  }
  const GreyImage half = PaintGrey(160, 4, [](int x, int) { return x < 80 ? 0.2 : 0.6; });
  const PointList points = PointsOf(map, half, options);
  const double ratio = static_cast<double>(CountBetween(points, 0.5, 7.5)) /
                       static_cast<double>(CountBetween(points, 8.5, 15.5));
  EXPECT_NEAR(ratio, 1 / 3.0, 0.02 / 3);
}

TEST(Relief, ThinnedPointsAreEven) {
  const GreyImage map = PaintGrey(4, 4, [](int, int) { return 0.5; });
  const GreyImage photo = PaintGrey(4, 4, [](int, int) { return 0.1; });
  const PointList points = PointsOf(map, photo, Options(10, 3, 0.1));
  // Points thrown at random come as near as they like; these keep half of the distance
  // that as many in a triangular lattice would have.
  const double lattice_mm =
      std::sqrt(2 / std::sqrt(3.0) * 100 / static_cast<double>(points.size()));
  EXPECT_GT(MinDistance(points), 0.5 * lattice_mm);
}

TEST(Relief, LayersKeepTheirDistanceOnSlopesToo) {
  const GreyImage map = PaintGrey(100, 50, [](int x, int) { return (x + 0.5) / 100; });
  ReliefOptions options = Options(5, 15, 0.2);  // 72 degrees
  options.layer_count = 3;
  options.layer_distance_mm = 0.2;
  const PointList points = PointsOf(map, std::nullopt, options);
  EXPECT_GE(MinDistance(points), 0.2);
  options.layer_distance_mm = 2;
  const PointList apart = PointsOf(map, std::nullopt, options);
  EXPECT_GE(MinDistance(apart), 0.2);
  options.layer_count = 1;
  EXPECT_NEAR(static_cast<double>(apart.size()),
              3 * static_cast<double>(PointsOf(map, std::nullopt, options).size()),
              0.03 * static_cast<double>(apart.size()));
}

TEST(Relief, SmoothingTakesTheStepsOfEightBits) {
  const GreyImage map = PaintGrey(
      1000, 10, [](int x, int) { return std::floor((x + 0.5) / 1000 * 16) / 16; });
  ReliefOptions options = Options(50, 8, 0.2);
  options.smoothing_mm = 4;
  for (const Vec3& p : PointsOf(map, std::nullopt, options)) {
    if (p.x() < 5 || p.x() > 45) continue;
    EXPECT_NEAR(p.z(), 8 * (p.x() / 50 - 0.5 / 16), 0.2);
  }
}

TEST(Relief, OptionsOutsideTheirRangesAreReported) {
  ReliefOptions options = Options(5, -1, 1000);
  options.smoothing_mm = 11;
  options.layer_count = 0;
  EXPECT_EQ(CheckRelief(options).size(), 4U);
  options = Options(1000, 500, 0.01);
  const GreyImage white = PaintGrey(1, 1, [](int, int) { return 1.0; });
  EXPECT_EQ(MakeRelief(white, std::nullopt, {}, options).error().code,
            ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace intaglio::discretize
