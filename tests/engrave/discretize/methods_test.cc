// The guarantees of the methods that make points of a surface, together with the cloud.

#include <gtest/gtest.h>

#include <functional>
#include <map>
#include <string>

#include "engrave/discretize/cloud.h"
#include "engrave/discretize/mesh/fill.h"
#include "engrave/discretize/mesh/rays.h"
#include "engrave/discretize/mesh/sections.h"
#include "tests/engrave/discretize/oracles.h"
#include "tests/engrave/discretize/shapes.h"

namespace intaglio::discretize {
namespace {

using MakeSource =
    std::function<Result<std::unique_ptr<PointSource>>(const mesh::TriangleMesh&)>;

MakeSource SectionsOf(double spacing_mm, ParallelFaces parallel_faces) {
  SectionOptions options;
  options.layer_distance_mm = options.vertex_distance_mm = spacing_mm;
  options.parallel_faces = parallel_faces;
  return
      [options](const mesh::TriangleMesh& mesh) { return MakeSections(mesh, options); };
}

MakeSource RaysOf(double spacing_mm) {
  RayOptions options;
  options.distance_mm = spacing_mm;
  return [options](const mesh::TriangleMesh& mesh) { return MakeRays(mesh, options); };
}

/// Those whose points lie on the surface exactly, by their names.
std::map<std::string, MakeSource> EveryMethod(double spacing_mm) {
  return {{"sections", SectionsOf(spacing_mm, ParallelFaces::kCover)},
          {"fill",
           [spacing_mm](const mesh::TriangleMesh& mesh) {
             return MakeFill(mesh, {spacing_mm, true});
           }},
          {"rays", RaysOf(spacing_mm)}};
}

Result<Discretized> Discretize(const std::vector<mesh::TriangleMesh>& models,
                               const MakeSource& make, double spacing_mm) {
  Sources sources;
  for (const mesh::TriangleMesh& model : models) {
    auto source = make(model);
    if (!source) return tl::unexpected(source.error());
    sources.push_back(std::move(*source));
  }
  CloudOptions options;
  options.thinning.min_spacing_mm = spacing_mm;
  options.permitted_mm = {Vec3(-20, -20, -20), Vec3(20, 20, 20)};
  return MakeCloud(sources, options, {}, {}, {});
}

TEST(Methods, EveryMethodKeepsTheSpacingAndTheSurface) {
  // Two models that intersect: thinning applies to both together.
  const std::vector<mesh::TriangleMesh> models = {Torus(Vec3(0, 0, 0), 5, 2, 24, 16),
                                                  Sphere(Vec3(5, 0, 0), 3, 16, 24)};
  for (const auto& [name, method] : EveryMethod(0.4)) {
    const auto result = Discretize(models, method, 0.4);
    ASSERT_TRUE(result.has_value()) << name;
    EXPECT_GT(result->cloud.size(), 500u);
    EXPECT_GE(MinDistance(result->cloud.points_mm), 0.4);
    EXPECT_EQ(result->candidate_count, result->cloud.size() + result->thinned_count);
    for (std::size_t i = 0; i < result->cloud.size(); ++i) {
      EXPECT_LT(
          DistanceToMesh(result->cloud.points_mm[i], models[result->cloud.source[i]]),
          1e-9);
    }
  }
}

// Vertical walls cut at exactly the spacing: rounding must not remove a single layer.
TEST(Methods, LayersASpacingApartAllStay) {
  const auto result = Discretize({Cuboid(Vec3(-3, -3, -2.07), Vec3(3, 3, 2))},
                                 SectionsOf(0.1, ParallelFaces::kIgnore), 0.1);
  ASSERT_TRUE(result.has_value());
  EXPECT_LT(static_cast<double>(result->thinned_count), 0.02 * result->candidate_count)
      << "only points at the corners of the square may go";
}

// A square pillar with its faces on the grid of rays: hits on its flat top are exactly
// one grid step apart, and rounding must not remove one of them.
TEST(Methods, RaysASpacingApartAllStay) {
  const auto result =
      Discretize({Cuboid(Vec3(-3, -3, -2), Vec3(3.01, 3.01, 2))}, RaysOf(0.1), 0.1);
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->thinned_count, 0u);
  EXPECT_EQ(result->cloud.size(), 2u * 61 * 61);
}

TEST(Methods, TheSameModelTwiceGivesTheSamePointsOnce) {
  const auto mesh = Icosphere(4, 3, Vec3(0, 0, 0));
  for (const auto& [name, method] : EveryMethod(0.3)) {
    const auto once = Discretize({mesh}, method, 0.3);
    const auto twice = Discretize({mesh, mesh}, method, 0.3);
    ASSERT_TRUE(once.has_value() && twice.has_value());
    EXPECT_EQ(once->cloud.points_mm, twice->cloud.points_mm) << name;
    EXPECT_EQ(once->cloud.source, twice->cloud.source);
  }
}

TEST(Methods, AnEmptyMeshHasNoPoints) {
  for (const auto& [name, method] : EveryMethod(0.3)) {
    const auto result = Discretize({mesh::TriangleMesh{}}, method, 0.3);
    ASSERT_TRUE(result.has_value()) << name;
    EXPECT_EQ(result->cloud.size(), 0u);
  }
}

}  // namespace
}  // namespace intaglio::discretize
