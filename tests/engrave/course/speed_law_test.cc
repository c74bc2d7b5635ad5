#include "engrave/course/speed_law.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/engrave/course/cut_program.h"

namespace intaglio::course {
namespace {

std::vector<double> Random(std::size_t count, double from, double to, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> draw(from, to);
  std::vector<double> values(count);
  for (double& x : values) x = draw(random);
  return values;
}

TEST(PlanSpeeds, KeepsEveryLimit) {
  for (const Path& path : CutProgram(2, 100, 3)) {
    auto nodes = Random(path.node_count(), 0, 120, 5);
    nodes.front() = nodes.back() = 0;
    const auto caps = Random(path.segment_count(), 20, 150, 6);
    const auto accelerations = Random(path.segment_count(), 500, 4000, 7);
    const SpeedLaw law = PlanSpeeds(path, {nodes, caps, accelerations});
    constexpr double kPeriodS = 1e-4;
    const auto count = static_cast<std::size_t>(law.duration_s / kPeriodS) + 2;
    const auto s = SampleLaw(law, kPeriodS, 0, count);
    const auto v = SampleSpeed(law, kPeriodS, 0, count);
    const auto& at = path.node_s_mm();
    std::size_t k = 0;
    for (std::size_t i = 1; i < count; ++i) {
      ASSERT_GE(s[i], s[i - 1] - 1e-9);
      while (k + 2 < at.size() && s[i] > at[k + 1]) ++k;
      ASSERT_LE(v[i], std::min(caps[k], 100.0) * (1 + 1e-9) + 1e-9);
      // A period may cross into the next segment with its greater acceleration.
      const double a =
          std::max(accelerations[k], k > 0 ? accelerations[k - 1] : accelerations[k]);
      ASSERT_LE(std::abs(v[i] - v[i - 1]), a * kPeriodS * (1 + 1e-9) + 1e-9);
      // The speed is what the position does.
      ASSERT_NEAR(s[i] - s[i - 1], (v[i] + v[i - 1]) / 2 * kPeriodS, 4000 * 1e-8);
    }
    EXPECT_NEAR(s.back(), path.length_mm(), 1e-9);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      EXPECT_LE(law.node_speed_mm_s[i], nodes[i] + 1e-12);
  }
}

// Against the textbook's three phases: 100 mm, 50 mm/s, 500 mm/s^2 from rest to rest.
TEST(PlanSpeeds, TakesTheTimeOfATrapezoid) {
  const Path line = PolylinePath({Vec2(0, 0), Vec2(100, 0)}, 50);
  EXPECT_NEAR(PlanSpeeds(line, {}, 500).duration_s, 100.0 / 50 + 50.0 / 500, 1e-12);
  // Too short for the feed: a triangle with the peak sqrt(a L).
  const Path piece = PolylinePath({Vec2(0, 0), Vec2(2, 0)}, 50);
  EXPECT_NEAR(PlanSpeeds(piece, {}, 500).duration_s, 2 * std::sqrt(2.0 / 500), 1e-12);
}

// No law can be faster: raising any node's speed breaks a limit. By bisection from both
// neighbours, independent of the two passes.
TEST(PlanSpeeds, IsTheFastest) {
  const Path path = CutProgram(0.5, 100, 9, {0, 0, 0, 1}).front();
  auto nodes = Random(path.node_count(), 5, 100, 8);
  nodes.front() = nodes.back() = 0;
  const std::vector<double> caps(path.segment_count(), 90);
  const std::vector<double> a(path.segment_count(), 2000);
  const SpeedLaw law = PlanSpeeds(path, {nodes, caps, a});
  const auto reachable = [&](std::size_t from, std::size_t to, std::size_t segment) {
    const double v = law.node_speed_mm_s[from];
    return law.node_speed_mm_s[to] + 1e-9 <
           std::sqrt(v * v + 2 * 2000 * path.segments()[segment].length_mm);
  };
  for (std::size_t k = 1; k + 1 < path.node_count(); ++k) {
    const bool could_rise = law.node_speed_mm_s[k] < std::min(nodes[k], 90.0) - 1e-9 &&
                            reachable(k - 1, k, k - 1) && reachable(k + 1, k, k);
    EXPECT_FALSE(could_rise) << k;
  }
}

// What look-ahead needs: the law up to a braking distance before the last known node does
// not change when more of the path is known.
TEST(PlanSpeeds, IsFinalABrakingDistanceBeforeTheEnd) {
  for (const Path& path : CutProgram(2, 100, 4, {0.2, 0.2, 0.3, 0.3})) {
    const auto limits = Random(path.node_count(), 5, 100, 2);
    const auto law_of = [&](const Path& part) {
      return PlanSpeeds(part, std::span(limits).subspan(1, part.node_count() - 2), 2000);
    };
    const SpeedLaw whole = law_of(path);
    const std::size_t known = path.segment_count() / 2 + 1;
    const SpeedLaw part = law_of(path.Part(0, known));
    const double final_mm = path.node_s_mm()[known] - 100.0 * 100 / (2 * 2000);
    for (std::size_t k = 0; k < known && path.node_s_mm()[k] <= final_mm; ++k)
      EXPECT_EQ(part.node_speed_mm_s[k], whole.node_speed_mm_s[k]);
  }
}

/// When the law passes a node.
double PassedS(const Path& path, const SpeedLaw& law, std::size_t node) {
  double from_s = 0, to_s = law.duration_s;
  for (int i = 0; i < 80; ++i) {
    const double middle_s = (from_s + to_s) / 2;
    const double s_mm = SampleLaw(law, 1, middle_s, 1).front();
    (s_mm < path.node_s_mm()[node] ? from_s : to_s) = middle_s;
  }
  return to_s;
}

// A node that is passed slower delays the blocks behind its own by whole periods.
TEST(AlignBlocks, KeepsTheClockOfOtherBlocks) {
  constexpr double kPeriodS = 5e-4;
  const Path path = JoinedPath(CutProgram(8, 100, 3));
  ASSERT_GT(path.segment_count(), 4 * kBlockSegments);
  auto nodes = Random(path.node_count(), 5, 100, 5);
  nodes.front() = nodes.back() = 0;
  const std::vector<double> caps(path.segment_count(), 100), a(path.segment_count(), 5e3);
  const SpeedLaw plain = PlanSpeeds(path, {nodes, caps, a});
  SpeedLaw before = plain;
  AlignBlocks(path, kPeriodS, before);
  nodes[kBlockSegments / 2] *= 0.9;
  SpeedLaw behind = PlanSpeeds(path, {nodes, caps, a});
  AlignBlocks(path, kPeriodS, behind);
  const auto blocks = static_cast<double>(path.segment_count() / kBlockSegments);
  EXPECT_GE(before.duration_s, plain.duration_s);
  EXPECT_LE(before.duration_s, plain.duration_s + blocks * kPeriodS);
  for (std::size_t node = kBlockSegments; node < path.node_count(); node += 37) {
    const double periods =
        (PassedS(path, behind, node) - PassedS(path, before, node)) / kPeriodS;
    // Times of some 100 s, searched to their last digits.
    EXPECT_NEAR(periods, std::round(periods), 1e-6) << node;
  }
  EXPECT_GT(behind.duration_s, before.duration_s + kPeriodS / 2);
  // Nowhere faster than planned.
  for (std::size_t i = 0; i < plain.phases.size(); ++i) {
    EXPECT_LE(before.phases[i].v_mm_s, plain.phases[i].v_mm_s);
    EXPECT_LE(std::abs(before.phases[i].a_mm_s2), std::abs(plain.phases[i].a_mm_s2));
    EXPECT_GE(before.phases[i].begin_s, plain.phases[i].begin_s);
  }
}

TEST(SampleLaw, SmoothedKeepsTheJerk) {
  const Path path = PolylinePath({Vec2(0, 0), Vec2(3, 0), Vec2(3, 2)}, 50);
  constexpr double kJerk = 200000, kA = 1000, kPeriodS = 1e-4;
  const SpeedLaw law = PlanSpeeds(path, std::vector<double>{20}, kA);
  const auto s = SampleLaw(law, kPeriodS, -0.02,
                           static_cast<std::size_t>((law.duration_s + 0.04) / kPeriodS),
                           2 * kA / kJerk);
  for (std::size_t i = 3; i < s.size(); ++i) {
    const double jerk = (s[i] - 3 * s[i - 1] + 3 * s[i - 2] - s[i - 3]) /
                        (kPeriodS * kPeriodS * kPeriodS);
    // Differences of rounded positions: 5e-16 x 8 / 1e-12 is 0.004; a window of whole
    // periods is 1 % off.
    ASSERT_LE(std::abs(jerk), kJerk * 1.02);
  }
  EXPECT_NEAR(s.back(), 5, 1e-9);
}

}  // namespace
}  // namespace intaglio::course
