#include "engrave/sort/beam/remaining_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "engrave/core/check.h"
#include "tests/engrave/sort/clouds.h"

namespace intaglio::sort {
namespace {

/// The same answers by checking every remaining point.
class EveryPoint {
 public:
  EveryPoint(const PointList& points_mm, double z_weight)
      : points_mm_(points_mm), z_weight_(z_weight) {
    for (std::uint32_t i = 0; i < points_mm.size(); ++i) left_.insert(i);
  }

  std::vector<std::uint32_t> Nearest(double x_mm, double y_mm, std::size_t count) const {
    using Key = std::tuple<double, double, double, double, std::uint32_t>;
    std::vector<Key> keys;
    for (const std::uint32_t i : left_) {
      const Vec3& p = points_mm_[i];
      const double across = std::max(std::abs(p.x() - x_mm), std::abs(p.y() - y_mm));
      keys.emplace_back(across + z_weight_ * p.z(), p.z(), p.y(), p.x(), i);
    }
    std::sort(keys.begin(), keys.end());
    keys.resize(std::min(count, keys.size()));
    std::vector<std::uint32_t> nearest;
    for (const Key& key : keys) nearest.push_back(std::get<4>(key));
    return nearest;
  }

  std::set<std::uint32_t> ShadedBy(const Vec3& crack_mm, const BeamCone& cone) const {
    std::set<std::uint32_t> shaded;
    for (const std::uint32_t i : left_) {
      const Vec3 d = crack_mm - points_mm_[i];
      if (cone.Shades(std::sqrt(d.x() * d.x() + d.y() * d.y()), d.z())) shaded.insert(i);
    }
    return shaded;
  }

  void Take(std::uint32_t index) { left_.erase(index); }
  bool IsLeft(std::uint32_t index) const { return left_.count(index) > 0; }
  std::size_t size() const { return left_.size(); }

 private:
  const PointList& points_mm_;
  double z_weight_;
  std::set<std::uint32_t> left_;
};

std::vector<std::uint32_t> AllOf(const PointList& points_mm) {
  std::vector<std::uint32_t> all(points_mm.size());
  std::iota(all.begin(), all.end(), 0U);
  return all;
}

std::vector<NamedCloud> CloudsOfAllKinds() {
  std::vector<NamedCloud> clouds = Clouds(400);
  for (NamedCloud& cloud : DegenerateClouds()) clouds.push_back(std::move(cloud));
  return clouds;
}

const BeamCone kCones[] = {{0.05}, {0.4}, {1.5}, {0.13, 0.03, 0.1}, {0.3, 0.5, 2}};

/// Takes some point at a time until none is left: one that was found, one by its index,
/// or the nearest. In between the same questions are asked of the tree and of every
/// point.
class TakingOneByOne {
 public:
  TakingOneByOne(const PointList& points_mm, double z_weight)
      : points_mm_(points_mm),
        remaining_(points_mm, AllOf(points_mm), z_weight),
        every_(points_mm, z_weight) {}

  void Run() {
    if (!points_mm_.empty()) here_mm_ = points_mm_.front();
    for (; every_.size() > 0 && !::testing::Test::HasFatalFailure(); ++round_) {
      ASSERT_EQ(remaining_.size(), every_.size());
      AskForTheNearest();
      AskForShades();
      TakeOne();
      const std::uint32_t asked = Any();
      ASSERT_EQ(remaining_.IsLeft(asked), every_.IsLeft(asked));
    }
    EXPECT_EQ(remaining_.size(), every_.size());
  }

 private:
  std::uint32_t Any() {
    return static_cast<std::uint32_t>(random_() % points_mm_.size());
  }

  void AskForTheNearest() {
    const std::size_t count = 1 + round_ % 14;
    remaining_.FindNearest(here_mm_.x(), here_mm_.y(), count, found_);
    indices_.clear();
    for (const auto& candidate : found_) {
      indices_.push_back(candidate.index);
      ASSERT_EQ(candidate.position_mm, points_mm_[candidate.index]);
    }
    ASSERT_EQ(indices_, every_.Nearest(here_mm_.x(), here_mm_.y(), count));
  }

  void AskForShades() {
    const Vec3& crack_mm = points_mm_[Any()];
    const BeamCone& cone = kCones[round_ % std::size(kCones)];
    const std::set<std::uint32_t> shaded = every_.ShadedBy(crack_mm, cone);
    const auto one = remaining_.FindShaded(crack_mm, cone);
    ASSERT_EQ(one.has_value(), !shaded.empty());
    ASSERT_EQ(remaining_.Shades(crack_mm, cone), !shaded.empty());
    if (one) {
      ASSERT_EQ(shaded.count(*one), 1);
    }
  }

  void TakeOne() {
    std::uint32_t taken = indices_.front();
    if (round_ % 3 == 0) {
      const auto& candidate = found_[random_() % found_.size()];
      taken = candidate.index;
      remaining_.Take(candidate);
    } else if (round_ % 3 == 1) {
      do {
        taken = Any();
      } while (!every_.IsLeft(taken));
      remaining_.Take(taken);
    } else {
      ASSERT_EQ(remaining_.TakeNearest(here_mm_.x(), here_mm_.y()).index, taken);
    }
    every_.Take(taken);
    here_mm_ = points_mm_[taken];
    // Now and then from elsewhere, far outside too.
    if (round_ % 7 == 0) here_mm_ += Vec3(random_() % 100, random_() % 100, 0);
  }

  const PointList& points_mm_;
  RemainingPoints remaining_;
  EveryPoint every_;
  std::mt19937 random_{1};
  std::uint32_t round_ = 0;
  Vec3 here_mm_ = Vec3::Zero();
  std::vector<RemainingPoints::Candidate> found_;
  std::vector<std::uint32_t> indices_;
};

TEST(RemainingPoints, AnswerAsATestOfEveryPointDoes) {
  for (const NamedCloud& cloud : CloudsOfAllKinds()) {
    for (const double z_weight : {0.1, 0.6, 3.0}) {
      SCOPED_TRACE(cloud.name + ", K = " + std::to_string(z_weight));
      TakingOneByOne(cloud.points_mm, z_weight).Run();
    }
  }
}

TEST(RemainingPoints, FindNoneWhereNoneIsLeft) {
  const PointList points_mm = RandomBox(20, {1, 1, 1}, 1);
  for (const std::size_t members : {std::size_t{0}, points_mm.size()}) {
    std::vector<std::uint32_t> some = AllOf(points_mm);
    some.resize(members);
    RemainingPoints remaining(points_mm, some, 0.6);
    while (remaining.size() > 0) remaining.TakeNearest(0, 0);
    std::vector<RemainingPoints::Candidate> found(3);
    remaining.FindNearest(0, 0, 5, found);
    EXPECT_TRUE(found.empty());
    EXPECT_FALSE(remaining.Shades({0.5, 0.5, 5}, 1));
    EXPECT_FALSE(remaining.IsLeft(3));
    EXPECT_THROW(remaining.TakeNearest(0, 0), PreconditionError);
    EXPECT_THROW(remaining.Take(3), PreconditionError);
  }
}

TEST(RemainingPoints, HoldOnlyTheirMembers) {
  const PointList points_mm = Grid(5, 5, 5, 0.1, 0.1, 1);
  const std::vector<std::uint32_t> members = {3, 50, 99, 7};
  RemainingPoints remaining(points_mm, members, 0.6);
  std::vector<RemainingPoints::Candidate> found;
  remaining.FindNearest(0, 0, 100, found);
  std::set<std::uint32_t> indices;
  for (const auto& candidate : found) indices.insert(candidate.index);
  EXPECT_EQ(indices, std::set<std::uint32_t>(members.begin(), members.end()));
  EXPECT_FALSE(remaining.IsLeft(0));
  EXPECT_TRUE(remaining.IsLeft(50));
}

TEST(RemainingPoints, RefuseAStaleCandidate) {
  const PointList points_mm = RandomBox(8, {1, 1, 1}, 1);
  RemainingPoints remaining(points_mm, AllOf(points_mm), 0.6);
  std::vector<RemainingPoints::Candidate> found;
  remaining.FindNearest(0, 0, 8, found);
  remaining.Take(found.front());
  EXPECT_THROW(remaining.Take(found.front()), PreconditionError);
  EXPECT_THROW(remaining.Take(found.front().index), PreconditionError);
}

TEST(RemainingPoints, KnowNoShadesWithoutAWeightForZ) {
  const PointList points_mm = RandomBox(8, {1, 1, 1}, 1);
  const RemainingPoints remaining(points_mm, AllOf(points_mm), 0);
  EXPECT_THROW(remaining.Shades({0, 0, 1}, 0.3), PreconditionError);
  EXPECT_THROW(RemainingPoints(points_mm, AllOf(points_mm), -1), PreconditionError);
}

}  // namespace
}  // namespace intaglio::sort
