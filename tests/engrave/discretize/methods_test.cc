#include "engrave/discretize/methods.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engrave/discretize/cloud.h"
#include "tests/engrave/discretize/oracles.h"
#include "tests/engrave/discretize/shapes.h"

namespace intaglio::discretize {
namespace {

using ::testing::HasSubstr;

std::vector<MeshMethod> EveryMethod(double spacing_mm) {
  SectionOptions sections;
  sections.layer_distance_mm = sections.vertex_distance_mm = spacing_mm;
  RayOptions rays;
  rays.distance_mm = spacing_mm;
  return {sections, FillOptions{spacing_mm, true}, rays};
}

Result<Discretized> Discretize(const std::vector<mesh::TriangleMesh>& models,
                               const MeshMethod& method, double spacing_mm) {
  Sources sources;
  for (const mesh::TriangleMesh& model : models) {
    auto source = MakeSource(model, method);
    if (!source) return tl::unexpected(source.error());
    sources.push_back(std::move(*source));
  }
  CloudOptions options;
  options.weld.min_spacing_mm = spacing_mm;
  options.permitted_mm = {Vec3(-20, -20, -20), Vec3(20, 20, 20)};
  return MakeCloud(sources, options, {}, {}, {});
}

TEST(Methods, EveryMethodKeepsTheSpacingAndTheSurface) {
  // Two models that cut into each other: the weld holds over both.
  const std::vector<mesh::TriangleMesh> models = {Torus(Vec3(0, 0, 0), 5, 2, 24, 16),
                                                  Sphere(Vec3(5, 0, 0), 3, 16, 24)};
  for (const MeshMethod& method : EveryMethod(0.4)) {
    const auto result = Discretize(models, method, 0.4);
    ASSERT_TRUE(result.has_value()) << method.index();
    EXPECT_GT(result->cloud.size(), 500u);
    EXPECT_GE(LeastDistance(result->cloud.points_mm), 0.4);
    EXPECT_EQ(result->candidate_count, result->cloud.size() + result->welded_count);
    for (std::size_t i = 0; i < result->cloud.size(); ++i) {
      EXPECT_LT(
          DistanceToMesh(result->cloud.points_mm[i], models[result->cloud.source[i]]),
          1e-9);
    }
  }
}

// Vertical walls cut at exactly the spacing: rounding may not cost a single layer.
TEST(Methods, LayersASpacingApartAllStay) {
  auto sections = std::get<SectionOptions>(EveryMethod(0.1)[0]);
  sections.parallel_faces = ParallelFaces::kIgnore;
  const auto result =
      Discretize({Cuboid(Vec3(-3, -3, -2.07), Vec3(3, 3, 2))}, sections, 0.1);
  ASSERT_TRUE(result.has_value());
  EXPECT_LT(static_cast<double>(result->welded_count), 0.02 * result->candidate_count)
      << "only points at the corners of the square may go";
}

// A square pillar with its faces on the grid of rays: hits on its flat top stand exactly
// a grid step apart, and rounding may not cost one of them.
TEST(Methods, RaysASpacingApartAllStay) {
  const auto result = Discretize({Cuboid(Vec3(-3, -3, -2), Vec3(3.01, 3.01, 2))},
                                 EveryMethod(0.1)[2], 0.1);
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->welded_count, 0u);
  EXPECT_EQ(result->cloud.size(), 2u * 61 * 61);
}

TEST(Methods, TheSameModelTwiceGivesTheSamePointsOnce) {
  const auto mesh = Icosphere(4, 3, Vec3(0, 0, 0));
  for (const MeshMethod& method : EveryMethod(0.3)) {
    const auto once = Discretize({mesh}, method, 0.3);
    const auto twice = Discretize({mesh, mesh}, method, 0.3);
    ASSERT_TRUE(once.has_value() && twice.has_value());
    EXPECT_EQ(once->cloud.points_mm, twice->cloud.points_mm) << method.index();
    EXPECT_EQ(once->cloud.source, twice->cloud.source);
  }
}

TEST(Methods, AnEmptyMeshHasNoPoints) {
  for (const MeshMethod& method : EveryMethod(0.3)) {
    const auto result = Discretize({mesh::TriangleMesh{}}, method, 0.3);
    ASSERT_TRUE(result.has_value()) << method.index();
    EXPECT_EQ(result->cloud.size(), 0u);
  }
}

TEST(Methods, WhatIsMissingIsToldWithTheRemedy) {
  EXPECT_TRUE(WarningsOf({}, 0.1).empty());
  MethodStatistics statistics;
  statistics.parallel_area_mm2 = 50;
  statistics.ray_count = 1000;
  statistics.odd_ray_count = 3;
  statistics.rejected_triangle_count = 2;
  const auto warnings = WarningsOf(statistics, 0.1);
  ASSERT_EQ(warnings.size(), 3u);
  EXPECT_THAT(warnings[0], HasSubstr("50.00 mm^2"));
  EXPECT_THAT(warnings[1], HasSubstr("3 of 1000 rays"));
  EXPECT_THAT(warnings[2], HasSubstr("2 triangles"));
}

}  // namespace
}  // namespace intaglio::discretize
