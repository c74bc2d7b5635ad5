#include "engrave/sort/beam/precedence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bitset>
#include <cmath>
#include <numeric>
#include <random>

#include "engrave/core/check.h"
#include "tests/engrave/sort/clouds.h"

namespace intaglio::sort {
namespace {

constexpr std::size_t kMaxPoints = 320;
using Mask = std::bitset<kMaxPoints>;
/// pairs[p][e]: p before e.
using Pairs = std::vector<Mask>;

Pairs EveryPair(const PointList& points_mm, const BeamCone& cone) {
  Pairs pairs(points_mm.size());
  for (std::size_t p = 0; p < points_mm.size(); ++p) {
    for (std::size_t e = 0; e < points_mm.size(); ++e) {
      const Vec3 d = points_mm[e] - points_mm[p];
      const double across_mm = std::sqrt(d.x() * d.x() + d.y() * d.y());
      pairs[p][e] = cone.Shades(across_mm, d.z());
    }
  }
  return pairs;
}

/// Warshall's closure.
Pairs Closed(Pairs pairs) {
  for (std::size_t q = 0; q < pairs.size(); ++q) {
    for (Mask& row : pairs) {
      if (row[q]) row |= pairs[q];
    }
  }
  return pairs;
}

Pairs KeptPairs(const Precedence& precedence, std::size_t size) {
  Pairs kept(size);
  for (std::uint32_t p = 0; p < size; ++p) {
    for (const std::uint32_t e : precedence.After(p)) {
      EXPECT_FALSE(kept[p][e]) << "twice";
      kept[p][e] = true;
    }
  }
  return kept;
}

std::vector<NamedCloud> SmallClouds() {
  std::vector<NamedCloud> clouds = Clouds(250);
  for (NamedCloud& cloud : DegenerateClouds()) clouds.push_back(std::move(cloud));
  for (NamedCloud& cloud : clouds) {
    if (cloud.points_mm.size() > kMaxPoints) cloud.points_mm.resize(kMaxPoints);
  }
  return clouds;
}

const BeamCone kOfTangentOnly[] = {{0}, {0.02}, {0.13}, {0.5}, {3}};
const BeamCone kOfCracks[] = {{0.13, 0.03, 0.1}, {0, 0.2, 0.5}, {0.5, 1, 0.3}};

TEST(Precedence, AllPairsFollowFromTheKeptOnesAndNoOthers) {
  for (const auto& [name, points_mm] : SmallClouds()) {
    for (const auto cones : {std::span<const BeamCone>(kOfTangentOnly),
                             std::span<const BeamCone>(kOfCracks)}) {
      for (const BeamCone& cone : cones) {
        const Pairs every = EveryPair(points_mm, cone);
        const Pairs kept = KeptPairs(Precedence(points_mm, cone), points_mm.size());
        EXPECT_EQ(Closed(kept), Closed(every)) << name << ", " << cone.tangent;
        for (std::size_t p = 0; p < every.size(); ++p) {
          ASSERT_TRUE((kept[p] & ~every[p]).none()) << "a pair that is none";
        }
      }
    }
  }
}

// A cone from its apex is transitive: above what is above is above.
TEST(Precedence, OfPointsTheClosureIsThePairs) {
  for (const auto& [name, points_mm] : SmallClouds()) {
    for (const BeamCone& cone : kOfTangentOnly) {
      const Pairs kept = KeptPairs(Precedence(points_mm, cone), points_mm.size());
      EXPECT_EQ(Closed(kept), EveryPair(points_mm, cone)) << name << ", " << cone.tangent;
    }
  }
}

TEST(Precedence, OfPointsNoPairIsKeptThatOthersImply) {
  std::size_t kept_count = 0;
  std::size_t every_count = 0;
  for (const auto& [name, points_mm] : SmallClouds()) {
    for (const BeamCone& cone : kOfTangentOnly) {
      const Pairs kept = KeptPairs(Precedence(points_mm, cone), points_mm.size());
      const Pairs closed = Closed(kept);
      for (std::size_t p = 0; p < kept.size(); ++p) {
        kept_count += kept[p].count();
        every_count += closed[p].count();
        for (std::size_t q = 0; q < kept.size(); ++q) {
          if (!kept[p][q]) continue;
          ASSERT_TRUE((closed[q] & kept[p]).none()) << name << ", " << cone.tangent;
        }
      }
    }
  }
  EXPECT_LT(2 * kept_count, every_count) << "there were some to leave out";
}

TEST(Precedence, BeforeIsTheInverseOfAfter) {
  for (const auto& [name, points_mm] : SmallClouds()) {
    for (const BeamCone& cone : {kOfTangentOnly[2], kOfCracks[0], kOfCracks[2]}) {
      const Precedence precedence(points_mm, cone);
      const Pairs after = KeptPairs(precedence, points_mm.size());
      Pairs before(points_mm.size());
      for (std::uint32_t e = 0; e < points_mm.size(); ++e) {
        for (const std::uint32_t p : precedence.Before(e)) {
          EXPECT_FALSE(before[p][e]) << "twice";
          before[p][e] = true;
        }
      }
      EXPECT_EQ(before, after) << name;
    }
  }
}

TEST(Precedence, WrongConesThrow) {
  const PointList points_mm = {{0, 0, 0}};
  EXPECT_THROW(Precedence(points_mm, -0.1), PreconditionError);
  EXPECT_THROW(Precedence(points_mm, {0.1, 0.1, 0}), PreconditionError);
}

}  // namespace
}  // namespace intaglio::sort
