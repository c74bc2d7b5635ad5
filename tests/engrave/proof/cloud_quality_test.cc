#include "engrave/proof/cloud_quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/engrave/proof/proof_shapes.h"

namespace intaglio::proof {
namespace {

using ::testing::HasSubstr;

PointCloud CloudOf(const PointList& points_mm) {
  return {points_mm, std::vector<std::uint32_t>(points_mm.size(), 0)};
}

QualityOptions Options(double min_spacing_mm) {
  return {.min_spacing_mm = min_spacing_mm,
          .crack_diameter_mm = 0.095,
          .crack_length_mm = 0.135};
}

TEST(CrackRisk, CountsAsBruteForce) {
  const PointList points = RandomPoints(3000, 2, 8);
  const DistinctPlaces places = DistinctPlacesOf(points);
  const PointTree tree(places.places_mm);
  const CrackRisk risk =
      MeasureCrackRisk(places, tree, {.crack_diameter_mm = 0.1, .crack_length_mm = 0.15});
  EXPECT_DOUBLE_EQ(risk.ball_radius_mm, 0.3);
  std::uint64_t largest = 0, risky = 0;
  const double ball_mm3 = 4.0 / 3 * std::numbers::pi * 0.027;
  const double crack_mm3 = std::numbers::pi / 6 * 0.1 * 0.1 * 0.15;
  for (const Vec3& p : points) {
    std::uint64_t count = 0;
    for (const Vec3& q : points) count += (p - q).norm() < 0.3;
    largest = std::max(largest, count);
    risky += count * crack_mm3 / ball_mm3 > 0.35;
  }
  EXPECT_EQ(risk.densest.cracks, largest);
  EXPECT_NEAR(risk.densest.crack_share, largest * crack_mm3 / ball_mm3, 1e-12);
  EXPECT_NEAR(risk.densest.points_per_mm3, largest / ball_mm3, 1e-9);
  EXPECT_EQ(risk.risky_count, risky);
}

// The basis of the header's limit: sheets at the published spacing of both lenses.
TEST(CrackRisk, ASheetAtThePublishedSpacingIsSoundTwoSheetsAreNot) {
  struct Lens {
    double diameter_mm, length_mm, spacing_mm;
  };
  for (const Lens& lens : {Lens{0.095, 0.135, 0.09}, Lens{0.135, 0.195, 0.13}}) {
    const QualityOptions options{.min_spacing_mm = lens.spacing_mm,
                                 .crack_diameter_mm = lens.diameter_mm,
                                 .crack_length_mm = lens.length_mm};
    PointList points = HexagonalLattice(6, 6, 5, lens.spacing_mm);
    const auto sheet = MeasureCloud(CloudOf(points), {}, options);
    ASSERT_TRUE(sheet && sheet->crack_risk);
    // 37 of the lattice's points are within three spacings of each, rim included.
    EXPECT_LT(sheet->crack_risk->densest.crack_share, 0.3);
    EXPECT_GT(sheet->crack_risk->densest.crack_share, 0.22);
    EXPECT_EQ(sheet->crack_risk->risky_count, 0u);
    EXPECT_TRUE(sheet->warnings.empty());
    const PointList above = HexagonalLattice(6, 6, 5 + lens.spacing_mm, lens.spacing_mm);
    points.insert(points.end(), above.begin(), above.end());
    const auto sheets = MeasureCloud(CloudOf(points), {}, options);
    ASSERT_TRUE(sheets && sheets->crack_risk);
    EXPECT_GT(sheets->crack_risk->risky_count, points.size() / 2);
    EXPECT_TRUE(sheets->KeepsSpacing());
    EXPECT_EQ(sheets->warnings.size(), 1u);
  }
}

TEST(CrackRisk, NamesTheTwoClumps) {
  PointList points = HexagonalLattice(20, 20, 1, 0.5);
  for (const Vec3& p : RandomPoints(300, 0.4, 1)) points.push_back(p + Vec3(4, 5, 6));
  for (const Vec3& p : RandomPoints(200, 0.4, 2)) points.push_back(p + Vec3(14, 5, 9));
  const auto quality = MeasureCloud(CloudOf(points), {}, Options(0.1));
  ASSERT_TRUE(quality);
  const auto& worst = quality->crack_risk->worst;
  ASSERT_EQ(worst.size(), 2u);
  EXPECT_LT((worst[0].place_mm - Vec3(4.2, 5.2, 6.2)).norm(), 0.3);
  EXPECT_LT((worst[1].place_mm - Vec3(14.2, 5.2, 9.2)).norm(), 0.3);
  EXPECT_THAT(quality->warnings.back().text, HasSubstr("mm, also at (14."));
  EXPECT_THAT(quality->warnings.back().text, HasSubstr("minimum spacing of 0.2"));
  EXPECT_EQ(quality->warnings.back().code, WarningCode::kBreakage);
  EXPECT_EQ(quality->warnings.back().weight, WarningWeight::kConsent);
}

TEST(CrackRisk, AClumpOfThousandsDoesNotTakeForever) {
  const auto quality =
      MeasureCloud(CloudOf(RandomPoints(20000, 0.05, 1)), {}, Options(0.1));
  ASSERT_TRUE(quality);
  EXPECT_GE(quality->crack_risk->densest.cracks, 4096u);
  EXPECT_TRUE(quality->nearest.more_pairs);
  EXPECT_THAT(quality->warnings.front().text, HasSubstr("or more pairs"));
}

TEST(CloudQuality, OfAnEvenSheet) {
  const auto quality = MeasureCloud(CloudOf(HexagonalLattice(12, 7, 3, 0.4)),
                                    {Rectangle(12, 7, 3, 3)}, Options(0.4));
  ASSERT_TRUE(quality);
  EXPECT_NEAR(quality->nearest.smallest.distance_mm, 0.4, 1e-12);
  EXPECT_NEAR(quality->nearest.variation_ratio, 0, 1e-9);
  EXPECT_TRUE(quality->KeepsSpacing());
  ASSERT_TRUE(quality->surface);
  EXPECT_EQ(quality->surface->triangle_count, 18u);
  EXPECT_NEAR(quality->surface->uncovered.radius_mm, 0.4 / std::sqrt(3.0), 1e-12);
  // The lattice reaches over the rectangle's rim, up to two points, which count as off
  // it.
  EXPECT_NEAR(quality->surface->density_ratio, 1, 0.12);
  EXPECT_TRUE(quality->warnings.empty());
}

TEST(CloudQuality, WarnsOfWhatIsWrongWithItsPlace) {
  PointList points;
  for (int i = 0; i <= 40; ++i) {
    for (int j = 0; j <= 40; ++j) {
      const Vec3 p(0.25 * i, 0.25 * j, 2);
      if ((p - Vec3(6, 7, 2)).norm() > 2) points.push_back(p);
    }
  }
  const std::vector<mesh::TriangleMesh> models = {Rectangle(10, 10, 2, 4)};
  const auto holed = MeasureCloud(CloudOf(points), models, Options(0.2));
  ASSERT_TRUE(holed);
  ASSERT_EQ(holed->warnings.size(), 1u);
  EXPECT_THAT(holed->warnings[0].text, HasSubstr("hole of radius 2."));
  EXPECT_NEAR((holed->surface->uncovered.place_mm - Vec3(6, 7, 2)).norm(), 0, 0.25);

  points.push_back(points[100] + Vec3(0.01, 0, 0));
  const auto near = MeasureCloud(CloudOf(points), {}, Options(0.2));
  EXPECT_FALSE(near->KeepsSpacing());
  EXPECT_THAT(near->warnings.at(0).text, HasSubstr("1 pair of points is nearer"));
  EXPECT_EQ(near->warnings.at(0).code, WarningCode::kNearPoints);
  points.push_back(points[200]);
  const auto doubled = MeasureCloud(CloudOf(points), {}, Options(0.2));
  EXPECT_EQ(doubled->nearest.doubled_count, 1u);
  EXPECT_THAT(doubled->warnings.at(0).text,
              HasSubstr("1 point has the same place as another one"));
}

TEST(CloudQuality, ReportsTheShareOfEverySource) {
  PointCloud cloud;
  for (int i = 0; i < 30; ++i) cloud.Add(Vec3(0.3 * i, 0, 1), 0);
  for (int i = 0; i < 10; ++i) cloud.Add(Vec3(0.3 * i, 0, 3), 2);
  const auto quality = MeasureCloud(
      cloud, {Rectangle(9, 1, 1, 2), Rectangle(9, 2, 2, 2), Rectangle(3, 1, 3, 2)},
      Options(0.2));
  ASSERT_TRUE(quality);
  ASSERT_EQ(quality->sources.size(), 3u);
  EXPECT_DOUBLE_EQ(quality->sources[0].point_ratio, 0.75);
  EXPECT_EQ(quality->sources[1].point_count, 0u);
  EXPECT_NEAR(*quality->sources[1].surface_ratio, 18.0 / 30, 1e-12);
  EXPECT_EQ(quality->sources[2].source, 2u);
}

TEST(CloudQuality, RefusesWhatCannotBeMeasured) {
  const auto empty = MeasureCloud({}, {}, Options(0.1));
  ASSERT_FALSE(empty);
  EXPECT_EQ(empty.error().code, ErrorCode::kMissing);
  const auto bare =
      MeasureCloud(CloudOf({Vec3::Zero()}), {mesh::TriangleMesh{}}, Options(0.1));
  ASSERT_FALSE(bare);
  const auto single = MeasureCloud(CloudOf({Vec3(1, 1, 1)}), {Cube(2)}, Options(0.1));
  ASSERT_TRUE(single);
  EXPECT_NEAR(single->surface->uncovered.radius_mm, std::sqrt(3.0), 1e-12);
}

}  // namespace
}  // namespace intaglio::proof
