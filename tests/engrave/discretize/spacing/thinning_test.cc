#include "engrave/discretize/spacing/thinning.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <tuple>

#include "engrave/discretize/spacing/point_source.h"
#include "tests/engrave/discretize/oracles.h"

namespace intaglio::discretize {
namespace {

/// How the own spacings of a random cloud's points come about.
enum class Own { kNone, kEqualBySource, kAnything };

struct Random {
  unsigned seed = 1;
  int count = 1500;
  double size_mm = 2;
  bool on_grid = false;
  Own own = Own::kNone;
  Vec3 shift_mm = Vec3::Zero();
};

SpacedCloud RandomCloud(const Random& r) {
  std::mt19937 random(r.seed);
  std::uniform_real_distribution<double> coordinate(-r.size_mm, r.size_mm);
  std::uniform_real_distribution<double> exponent(-3, 1);
  SpacedCloud cloud;
  for (int i = 0; i < r.count; ++i) {
    Vec3 p(coordinate(random), coordinate(random), coordinate(random));
    if (r.on_grid) p = (p * 4).array().round().matrix() / 4;
    const auto source = static_cast<std::uint32_t>(random() % 3);
    float own_mm = 0;
    if (r.own == Own::kEqualBySource) own_mm = 0.2F * static_cast<float>(source);
    if (r.own == Own::kAnything) own_mm = static_cast<float>(std::exp2(exponent(random)));
    if (r.own == Own::kAnything && random() % 8 == 0) own_mm = 0;
    cloud.Add(p + r.shift_mm, source, own_mm);
  }
  return cloud;
}

using Key = std::tuple<double, double, double, std::uint32_t, float>;

std::vector<Key> Keys(const SpacedCloud& cloud) {
  std::vector<Key> keys;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Vec3& p = cloud.points_mm[i];
    keys.emplace_back(p.z(), p.y(), p.x(), cloud.source[i], cloud.spacing_mm[i]);
  }
  return keys;
}

// The rules of weld.h, implemented literally.
bool AreTooNear(const Key& a, const Key& b, const ThinningOptions& options) {
  const double dx = std::get<2>(a) - std::get<2>(b), dy = std::get<1>(a) - std::get<1>(b);
  const double dz = std::get<0>(a) - std::get<0>(b);
  const auto& channels = options.channels_of_source;
  if (!channels.empty() &&
      (channels.at(std::get<3>(a)) & channels.at(std::get<3>(b))) == 0) {
    return false;
  }
  const double flat = dz / options.height_ratio;
  if (dx * dx + dy * dy + flat * flat < options.min_spacing_mm * options.min_spacing_mm) {
    return true;
  }
  const double s = std::max(std::get<4>(a), std::get<4>(b));
  return std::get<3>(a) == std::get<3>(b) && dx * dx + dy * dy + dz * dz < s * s;
}

std::vector<Key> ThinnedByBruteForce(const SpacedCloud& cloud,
                                     const ThinningOptions& options,
                                     const SpacedCloud& taken = {}) {
  std::vector<Key> kept;
  const std::vector<Key> fixed = Keys(taken);
  std::vector<Key> sorted = Keys(cloud);
  const auto height = [&](const Key& p) {
    return options.rise.dot(Vec3(std::get<2>(p), std::get<1>(p), std::get<0>(p)));
  };
  std::sort(sorted.begin(), sorted.end(), [&](const Key& a, const Key& b) {
    const auto order = [&](const Key& p) {
      const auto& [z, y, x, source, spacing_mm] = p;
      return std::tuple(height(p), y, x, source, spacing_mm, z);
    };
    return order(a) < order(b);
  });
  for (const Key& p : sorted) {
    const auto near = [&](const Key& q) { return AreTooNear(p, q, options); };
    if (std::any_of(fixed.begin(), fixed.end(), near)) continue;
    if (std::any_of(kept.begin(), kept.end(), near)) continue;
    kept.push_back(p);
  }
  return kept;
}

SpacedCloud Shuffled(const SpacedCloud& cloud, unsigned seed) {
  std::vector<std::size_t> order(cloud.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(seed));
  SpacedCloud shuffled;
  for (const std::size_t i : order) {
    shuffled.Add(cloud.points_mm[i], cloud.source[i], cloud.spacing_mm[i]);
  }
  return shuffled;
}

class ThinningOfRandomClouds
    : public testing::TestWithParam<std::tuple<Own, double, bool, bool>> {};

TEST_P(ThinningOfRandomClouds, KeepsWhatTheRulesRequire) {
  const auto [own, height_ratio, on_grid, with_taken] = GetParam();
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Vec3 rise = seed < 2 ? kUpward : ObliqueRise();
    const ThinningOptions options{0.15 + 0.1 * seed, height_ratio, {}, rise};
    const SpacedCloud cloud = RandomCloud({.seed = seed, .on_grid = on_grid, .own = own});
    const SpacedCloud taken = RandomCloud({.seed = seed + 50,
                                           .count = with_taken ? 60 : 0,
                                           .own = own,
                                           .shift_mm = Vec3(0.4, -3, 1)});
    const SpacedCloud kept = Thin(cloud, options, taken);
    EXPECT_EQ(Keys(kept), ThinnedByBruteForce(cloud, options, taken)) << seed;
    EXPECT_EQ(Keys(Thin(Shuffled(cloud, seed), options, Shuffled(taken, seed))),
              Keys(kept));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, ThinningOfRandomClouds,
    testing::Combine(testing::Values(Own::kNone, Own::kEqualBySource, Own::kAnything),
                     testing::Values(1.0, 2.5), testing::Bool(), testing::Bool()));

// Each channel has a block of its own: points without a common channel do not exclude
// each other.
TEST(Thin, PointsOfDifferentChannelsAreNotTooNear) {
  const std::vector<std::vector<ChannelMask>> masks = {{1, 1, 1}, {1, 2, 4},   {7, 2, 4},
                                                       {1, 3, 6}, {15, 4, 15}, {3, 5, 6}};
  for (unsigned seed = 0; seed < 12; ++seed) {
    const ThinningOptions options{0.25, seed % 2 == 0 ? 1.0 : 2.5,
                                  masks[seed % masks.size()]};
    const SpacedCloud cloud = RandomCloud({.seed = seed, .own = Own::kEqualBySource});
    const SpacedCloud taken =
        RandomCloud({.seed = seed + 50, .count = 60, .shift_mm = Vec3(0.4, -3, 1)});
    EXPECT_EQ(Keys(Thin(cloud, options, taken)),
              ThinnedByBruteForce(cloud, options, taken))
        << seed;
  }
}

// A horizontal face: all candidates are of one height, and the finer sheets are rows.
TEST(Thin, AFlatCloudIsAsByBruteForce) {
  SpacedCloud cloud = RandomCloud({.count = 4000});
  for (Vec3& p : cloud.points_mm) p.z() = 0.25;
  EXPECT_EQ(Keys(Thin(cloud, {0.1, 1})), ThinnedByBruteForce(cloud, {0.1, 1}));
  for (Vec3& p : cloud.points_mm) p.y() = 0.5;
  EXPECT_EQ(Keys(Thin(cloud, {0.001, 1})), ThinnedByBruteForce(cloud, {0.001, 1}));
}

TEST(Thin, HeightsOfEveryMagnitudeAreAsByBruteForce) {
  std::mt19937 random(3);
  SpacedCloud cloud;
  for (int i = 0; i < 2000; ++i) {
    const double x = 1e-3 * static_cast<double>(random() % 1000);
    cloud.Add(Vec3(x, 0, std::ldexp(1.0, -static_cast<int>(random() % 1070))), 0);
  }
  EXPECT_EQ(Keys(Thin(cloud, {0.01, 1})), ThinnedByBruteForce(cloud, {0.01, 1}));
}

TEST(Thin, CoincidentPointsBecomeOne) {
  SpacedCloud cloud;
  for (std::uint32_t i = 0; i < 10; ++i) cloud.Add(Vec3(1, 2, 3), 9 - i);
  const SpacedCloud kept = Thin(cloud, {0.1, 1});
  ASSERT_EQ(kept.size(), 1u);
  EXPECT_EQ(kept.source[0], 0u) << "the first model's";
}

TEST(Thin, ExactlyTheSpacingApartIsFarEnough) {
  SpacedCloud cloud;
  for (int i = 0; i < 5; ++i) cloud.Add(Vec3(0.25 * i, 0, 0), 0);
  EXPECT_EQ(Thin(cloud, {0.25, 1}).size(), 5u);
}

TEST(Thin, CracksAreLongerAlongTheBeam) {
  SpacedCloud cloud;
  for (int i = 0; i < 9; ++i) cloud.Add(Vec3(0, 0, 0.25 * i), 0);
  EXPECT_EQ(Thin(cloud, {0.25, 1}).size(), 9u);
  EXPECT_EQ(Thin(cloud, {0.25, 4}).size(), 3u);
}

TEST(Thin, OwnSpacingsHoldWithinASourceOnly) {
  SpacedCloud cloud;
  cloud.Add(Vec3(0, 0, 0), 0, 1);
  cloud.Add(Vec3(0.5, 0, 0), 0, 0.1F);  // within the other's spacing
  cloud.Add(Vec3(0, 0.5, 0), 1, 1);
  cloud.Add(Vec3(0, 0.75, 0), 2, 0);
  cloud.Add(Vec3(0, 0, 0.99), 0, 0);
  const SpacedCloud kept = Thin(cloud, {0.1, 1});
  ASSERT_EQ(kept.size(), 3u);
  EXPECT_EQ(kept.source, (std::vector<std::uint32_t>{0, 1, 2}));
}

TEST(Thin, TinySpacingInALargeBlockTakesLittle) {
  SpacedCloud cloud;
  cloud.Add(Vec3(0, 0, 0), 0);
  cloud.Add(Vec3(1000, 1000, 1000), 0);
  EXPECT_EQ(Thin(cloud, {1e-6, 1}).size(), 2u);
  EXPECT_EQ(Thin({}, {1, 1}).size(), 0u);
  EXPECT_EQ(Thin({}, {1, 1}, cloud).size(), 0u);
}

// Multiples of the spacing, off by the last digits: whether two are near enough is a
// matter of rounding, and so is the column of the grid they fall into.
TEST(Thin, NeighboursAtTheSpacingButForRoundingAreAsByBruteForce) {
  std::mt19937 random(11);
  for (const double spacing : {0.1, 0.13, 1.0 / 3}) {
    for (const double ratio : {1.0, 3.0}) {
      SpacedCloud cloud;
      for (int i = 0; i < 600; ++i) {
        Vec3 p;
        for (int axis = 0; axis < 3; ++axis) {
          p[axis] = spacing * static_cast<double>(random() % (axis == 0 ? 40 : 4));
          if (axis == 2) p[axis] *= ratio;
          for (auto k = random() % 4; k > 0; --k) p[axis] = std::nextafter(p[axis], -1);
          for (auto k = random() % 4; k > 0; --k) p[axis] = std::nextafter(p[axis], 99);
        }
        cloud.Add(p, 0, i % 2 == 0 ? 0 : static_cast<float>(spacing));
      }
      const ThinningOptions options{spacing, ratio};
      EXPECT_EQ(Keys(Thin(cloud, options)), ThinnedByBruteForce(cloud, options));
    }
  }
}

TEST(Thin, ZeroAndMinusZeroAreTheSamePoint) {
  SpacedCloud one, other;
  one.Add(Vec3(0.0, -0.0, 0.0), 0);
  one.Add(Vec3(-0.0, 0.0, -0.0), 0);
  other.Add(one.points_mm[1], 0);
  other.Add(one.points_mm[0], 0);
  for (const SpacedCloud& cloud : {one, other}) {
    const SpacedCloud kept = Thin(cloud, {0.1, 1});
    ASSERT_EQ(kept.size(), 1u);
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_FALSE(std::signbit(kept.points_mm[0][axis]));
  }
}

// A point far away makes the columns wider than the spacing and the sheets few.
TEST(Thin, AFarPointDoesNotChangeTheRest) {
  SpacedCloud cloud = RandomCloud({.seed = 3, .count = 2000, .size_mm = 0.01});
  const SpacedCloud near = Thin(cloud, {0.001, 1});
  cloud.Add(Vec3(900, 900, 900), 0);
  SpacedCloud with_far = Thin(cloud, {0.001, 1});
  ASSERT_EQ(with_far.size(), near.size() + 1);
  with_far.points_mm.pop_back();
  EXPECT_EQ(with_far.points_mm, near.points_mm);
}

TEST(Thin, LargeCloudsKeepTheSpacingToo) {
  const double spacing = 0.05;
  const SpacedCloud kept =
      Thin(RandomCloud({.seed = 8, .count = 300'000, .size_mm = 1}), {spacing, 1});
  ASSERT_GT(kept.size(), 10'000u);
  // nanoflann adds the squares in another order: the last digit may differ.
  EXPECT_GE(MinDistance(kept.points_mm), spacing * (1 - 1e-15));
}

// Dense on one side, a fortieth as dense on the other: were the sparse points' wide
// surroundings searched point by point at every candidate, this would take minutes.
TEST(Thin, StronglyVaryingSpacingsStayFast) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> coordinate(0, 20);
  SpacedCloud cloud;
  for (int i = 0; i < 400'000; ++i) {
    const Vec3 p(coordinate(random), coordinate(random), 0.1 * coordinate(random));
    cloud.Add(p, 0, p.x() < 10 ? 0.05F : 2.0F);
  }
  const SpacedCloud kept = Thin(cloud, {0.05, 1});
  EXPECT_GT(kept.size(), 100'000u);
  std::size_t sparse = 0;
  for (const float own_mm : kept.spacing_mm) sparse += own_mm > 1 ? 1 : 0;
  EXPECT_GT(sparse, 20u);
}

TEST(Thin, RefusesWhatItCannotThin) {
  SpacedCloud cloud;
  cloud.Add(Vec3(0, 0, 0), 0);
  EXPECT_ANY_THROW(Thin(cloud, {0, 1}));
  EXPECT_ANY_THROW(Thin(cloud, {0.1, 0.5}));
  cloud.spacing_mm[0] = -1;
  EXPECT_ANY_THROW(Thin(cloud, {0.1, 1}));
  cloud.spacing_mm[0] = 0;
  cloud.points_mm[0].y() = std::nan("");
  EXPECT_ANY_THROW(Thin(cloud, {0.1, 1}));
}

}  // namespace
}  // namespace intaglio::discretize
