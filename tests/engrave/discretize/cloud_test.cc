#include "engrave/discretize/cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "engrave/discretize/mesh/fill.h"
#include "engrave/discretize/mesh/sections.h"
#include "engrave/discretize/spacing/fixed_points.h"
#include "tests/engrave/discretize/oracles.h"
#include "tests/engrave/discretize/shapes.h"

namespace intaglio::discretize {
namespace {

using ::testing::HasSubstr;

CloudOptions Options(double spacing_mm) {
  CloudOptions options;
  options.thinning.min_spacing_mm = spacing_mm;
  options.permitted_mm = {Vec3(-20, -20, -20), Vec3(20, 20, 20)};
  return options;
}

// A torus on edge, so that it reaches through many slabs, and a sphere that cuts into it.
Sources TorusAndSphere(double spacing_mm) {
  SectionOptions sections;
  sections.layer_distance_mm = sections.vertex_distance_mm = spacing_mm;
  mesh::TriangleMesh torus = Torus(Vec3(0, 0, 0), 8, 2, 60, 30);
  for (Vec3& v : torus.vertices) std::swap(v.x(), v.z());
  Sources sources;
  sources.push_back(*MakeSections(std::move(torus), sections));
  sources.push_back(*MakeFill(Sphere(Vec3(3, 0, 5), 4, 40, 60), {spacing_mm, true}));
  return sources;
}

/// Starts as many threads as there is work, the last first.
void Backwards(std::size_t count, const std::function<void(std::size_t)>& work) {
  std::vector<std::thread> threads;
  for (std::size_t i = count; i-- > 0;) threads.emplace_back(work, i);
  for (std::thread& thread : threads) thread.join();
}

TEST(Cloud, IsTheSameWhoeverMakesIt) {
  const Sources sources = TorusAndSphere(0.2);
  const CloudOptions options = Options(0.2);
  const auto whole = MakeCloud(sources, options, {}, {}, {});
  ASSERT_TRUE(whole.has_value()) << whole.error().message;
  EXPECT_GT(whole->cloud.size(), 5000u);
  const auto threaded = MakeCloud(sources, options, {}, Backwards, {});
  EXPECT_EQ(threaded->cloud.points_mm, whole->cloud.points_mm);
  EXPECT_EQ(threaded->cloud.source, whole->cloud.source);
  for (const std::size_t parts : {2u, 3u, 7u}) {
    PointList joined;
    std::uint64_t candidates = 0, thinned = 0, offered = 0;
    for (std::size_t i = 0; i < parts; ++i) {
      const auto part = MakeCloud(sources, options, {i, parts}, {}, {});
      joined.insert(joined.end(), part->cloud.points_mm.begin(),
                    part->cloud.points_mm.end());
      candidates += part->candidate_count;
      thinned += part->thinned_count;
      for (const MethodStatistics& model : part->models) offered += model.point_count;
    }
    EXPECT_EQ(joined, whole->cloud.points_mm) << parts;
    EXPECT_EQ(candidates, whole->candidate_count);
    EXPECT_EQ(thinned, whole->thinned_count);
    EXPECT_EQ(offered, whole->candidate_count);
  }
}

TEST(Cloud, KeepsTheSpacingAndLeavesNoRoomAcrossSeams) {
  const Sources sources = TorusAndSphere(0.3);
  const auto made = MakeCloud(sources, Options(0.3), {}, {}, {});
  ASSERT_TRUE(made.has_value());
  EXPECT_EQ(made->candidate_count, made->cloud.size() + made->thinned_count);
  EXPECT_GE(MinDistance(made->cloud.points_mm), 0.3);
  SpacedCloud candidates;
  for (std::uint32_t i = 0; i < sources.size(); ++i) {
    ASSERT_TRUE(sources[i]->AddPoints({}, i, {}, candidates).has_value());
  }
  // Every tenth is enough: a removed candidate is too near to a kept point.
  for (std::size_t i = 0; i < candidates.size(); i += 10) {
    double nearest = INFINITY;
    for (const Vec3& p : made->cloud.points_mm) {
      nearest = std::min(nearest, (p - candidates.points_mm[i]).norm());
    }
    ASSERT_LT(nearest, 0.3);
  }
}

TEST(Cloud, PointsOutsideAreCountedByTheirSides) {
  const Sources sources = TorusAndSphere(0.5);
  CloudOptions options = Options(0.5);
  options.permitted_mm = {Vec3(-20, -20, -1), Vec3(6, 20, 20)};
  const auto refused = MakeCloud(sources, options, {}, {}, {});
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, ErrorCode::kOutsideBlock);
  EXPECT_THAT(refused.error().message, HasSubstr("high x"));
  EXPECT_THAT(refused.error().message, HasSubstr("low z"));
  EXPECT_THAT(refused.error().message, ::testing::Not(HasSubstr("low x")));
  options.clip = true;
  const auto clipped = MakeCloud(sources, options, {}, {}, {});
  ASSERT_TRUE(clipped.has_value());
  EXPECT_GT(clipped->clipped_count, 0u);
  EXPECT_EQ(clipped->candidate_count,
            clipped->cloud.size() + clipped->thinned_count + clipped->clipped_count);
  for (const Vec3& p : clipped->cloud.points_mm) {
    EXPECT_LE(p.x(), 6 + 1e-6);
    EXPECT_GE(p.z(), -1 - 1e-6);
  }
}

TEST(Cloud, ProgressRisesToItsTotalAndCancels) {
  const Sources sources = TorusAndSphere(0.3);
  std::uint64_t last = 0, end = 0;
  const auto made = MakeCloud(sources, Options(0.3), {}, {},
                              [&](std::uint64_t done, std::uint64_t total) {
                                EXPECT_GE(done, last);
                                EXPECT_LE(done, total);
                                last = done;
                                end = total;
                                return true;
                              });
  ASSERT_TRUE(made.has_value());
  EXPECT_GT(end, 0u);
  EXPECT_GT(last, 0u);
  const auto cancelled = MakeCloud(sources, Options(0.3), {}, {},
                                   [](std::uint64_t, std::uint64_t) { return false; });
  ASSERT_FALSE(cancelled.has_value());
  EXPECT_EQ(cancelled.error().code, ErrorCode::kCancelled);
}

TEST(Cloud, OfNothingIsEmpty) {
  const auto none = MakeCloud({}, Options(0.1), {}, {}, {});
  ASSERT_TRUE(none.has_value());
  EXPECT_EQ(none->cloud.size(), 0u);
}

}  // namespace
}  // namespace intaglio::discretize
