#include "engrave/discretize/methods.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "engrave/discretize/bounds.h"
#include "tests/engrave/discretize/oracles.h"
#include "tests/engrave/discretize/shapes.h"

namespace intaglio::discretize {
namespace {

using ::testing::HasSubstr;

DiscretizeOptions Options(Method method, double spacing_mm) {
  DiscretizeOptions options;
  options.method = method;
  options.min_spacing_mm = spacing_mm;
  options.sections.layer_distance_mm = options.sections.vertex_distance_mm = spacing_mm;
  options.fill.vertex_distance_mm = spacing_mm;
  options.rays.distance_mm = spacing_mm;
  options.permitted_mm = {Vec3(-20, -20, -20), Vec3(20, 20, 20)};
  return options;
}

TEST(Methods, EveryMethodKeepsTheSpacingAndTheSurface) {
  // Two models that cut into each other: the weld holds over both.
  const std::vector<mesh::TriangleMesh> models = {Torus(Vec3(0, 0, 0), 5, 2, 24, 16),
                                                  Sphere(Vec3(5, 0, 0), 3, 16, 24)};
  for (const Method method : {Method::kSections, Method::kFill, Method::kRays}) {
    const auto result = Discretize(models, Options(method, 0.4), {});
    ASSERT_TRUE(result.has_value()) << NameOf(method);
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
  auto options = Options(Method::kSections, 0.1);
  const auto result =
      Discretize({Cuboid(Vec3(-3, -3, -2.07), Vec3(3, 3, 2))}, options, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_LT(static_cast<double>(result->welded_count), 0.02 * result->candidate_count)
      << "only points at the corners of the square may go";
}

TEST(Methods, FilledSurfaceHasNoHoles) {
  const auto mesh = Sphere(Vec3(0, 0, 0), 4, 60, 90);
  const auto result = Discretize({mesh}, Options(Method::kFill, 0.3), {});
  ASSERT_TRUE(result.has_value());
  double largest = 0;
  for (const Vec3& v : mesh.vertices) {
    double nearest = INFINITY;
    for (const Vec3& p : result->cloud.points_mm)
      nearest = std::min(nearest, (p - v).norm());
    largest = std::max(largest, nearest);
  }
  // 1.36 spacings by the derivation in fill.cc.
  EXPECT_LT(largest, 1.36 * 0.3);
}

TEST(Methods, PointsOutsideAreCountedByTheirSides) {
  auto options = Options(Method::kSections, 0.5);
  options.permitted_mm = {Vec3(-10, -10, -1), Vec3(6, 10, 10)};
  const std::vector<mesh::TriangleMesh> models = {Torus(Vec3(0, 0, 0), 5, 2, 24, 16)};
  const auto refused = Discretize(models, options, {});
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kOutsideBlock);
  EXPECT_THAT(refused.error().message, HasSubstr("high x"));
  EXPECT_THAT(refused.error().message, HasSubstr("low z"));
  EXPECT_THAT(refused.error().message, ::testing::Not(HasSubstr("low x")));
  options.clip = true;
  const auto clipped = Discretize(models, options, {});
  ASSERT_TRUE(clipped.has_value());
  EXPECT_GT(clipped->clipped_count, 0u);
  EXPECT_EQ(CheckBounds(clipped->cloud.points_mm, options.permitted_mm).outside_count,
            0u);
}

TEST(Methods, LostFacesAreWarnedOf) {
  const auto result = Discretize({Cuboid(Vec3(0, 0, 0), Vec3(5, 5, 5))},
                                 Options(Method::kSections, 0.2), {});
  ASSERT_TRUE(result.has_value());
  ASSERT_EQ(result->warnings.size(), 1u);
  EXPECT_THAT(result->warnings[0], HasSubstr("50.00 mm^2"));
}

TEST(Methods, WrongOptionsAreNamedAllAtOnce) {
  auto options = Options(Method::kSections, 0.015);
  options.sections.layer_distance_mm = -1;
  options.sections.twist_phase_ratio = std::nan("");
  EXPECT_EQ(CheckOptions(options).size(), 3u);
  EXPECT_FALSE(Discretize({}, options, {}).has_value());
}

TEST(Methods, NamesAndMethodsGoBothWays) {
  for (const Method method : {Method::kSections, Method::kFill, Method::kRays}) {
    EXPECT_EQ(MethodFromName(NameOf(method)).value(), method);
  }
  EXPECT_THAT(MethodFromName("dice").error().message, HasSubstr("sections, fill, rays"));
}

// A square pillar with its faces on the grid of rays: hits on its flat top stand exactly
// a grid step apart, and rounding may not cost one of them.
TEST(Methods, RaysASpacingApartAllStay) {
  const auto result = Discretize({Cuboid(Vec3(-3, -3, -2), Vec3(3.01, 3.01, 2))},
                                 Options(Method::kRays, 0.1), {});
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->welded_count, 0u);
  EXPECT_EQ(result->cloud.size(), 2u * 61 * 61);
}

TEST(Methods, AFillKeepsItsVertexDistance) {
  auto options = Options(Method::kFill, 0.1);
  options.fill.vertex_distance_mm = 0.7;
  const auto result = Discretize({Icosphere(4, 3, Vec3(0, 0, 0))}, options, {});
  ASSERT_TRUE(result.has_value());
  EXPECT_GE(LeastDistance(result->cloud.points_mm), 0.7 * (1 - 1e-15));
}

TEST(Methods, TheSameModelTwiceGivesTheSamePointsOnce) {
  const auto mesh = Icosphere(4, 3, Vec3(0, 0, 0));
  for (const Method method : {Method::kSections, Method::kFill, Method::kRays}) {
    const auto once = Discretize({mesh}, Options(method, 0.3), {});
    const auto twice = Discretize({mesh, mesh}, Options(method, 0.3), {});
    ASSERT_TRUE(once.has_value() && twice.has_value());
    EXPECT_EQ(once->cloud.points_mm, twice->cloud.points_mm) << NameOf(method);
    EXPECT_EQ(once->cloud.source, twice->cloud.source);
  }
}

TEST(Methods, NothingToMakeIsAnError) {
  for (const Method method : {Method::kSections, Method::kFill, Method::kRays}) {
    const auto result = Discretize({mesh::TriangleMesh{}}, Options(method, 0.3), {});
    ASSERT_FALSE(result.has_value());
    EXPECT_EQ(result.error().code, ErrorCode::kMissing);
  }
}

TEST(Methods, ProgressRisesToTheEndAndCanCancel) {
  const std::vector<mesh::TriangleMesh> models(3, Icosphere(4, 4, Vec3(0, 0, 0)));
  for (const Method method : {Method::kSections, Method::kFill, Method::kRays}) {
    std::uint64_t last = 0;
    const auto whole = Discretize(models, Options(method, 0.3),
                                  [&](std::uint64_t done, std::uint64_t total) {
                                    EXPECT_GE(done, last);
                                    EXPECT_LE(done, total);
                                    last = done;
                                    return true;
                                  });
    EXPECT_TRUE(whole.has_value());
    const auto cancelled = Discretize(models, Options(method, 0.3),
                                      [](std::uint64_t, std::uint64_t) { return false; });
    ASSERT_FALSE(cancelled.has_value());
    EXPECT_EQ(cancelled.error().code, ErrorCode::kCancelled);
  }
}

}  // namespace
}  // namespace intaglio::discretize
