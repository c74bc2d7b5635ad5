#include "engrave/calibrate/mark_matching.h"

#include <gmock/gmock.h>

#include <cmath>
#include <random>

#include "engrave/calibrate/test_pattern.h"

namespace intaglio::calibrate {
namespace {

std::vector<Vec2> Pattern() {
  std::vector<Vec2> marks;
  for (const Vec3& p : MakeTestPattern({}).value().marks_mm) marks.push_back(p.head<2>());
  return marks;
}

/// Every mark but each `lost`-th, turned, shifted, scaled, with errors of some um, in
/// another sequence; and dust. `numbers`: what each is.
std::vector<Vec2> Measured(const std::vector<Vec2>& marks, double turn_deg, double scale,
                           unsigned seed, std::vector<int>& numbers) {
  std::mt19937 random(seed);
  std::normal_distribution<double> error(0, 0.01);
  std::uniform_real_distribution<double> anywhere(0, 50);
  const double turn = turn_deg * M_PI / 180;
  std::vector<std::pair<Vec2, int>> all;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (i % 11 != 0) all.emplace_back(marks[i], static_cast<int>(i));
  }
  for (int i = 0; i < 25; ++i)
    all.emplace_back(Vec2(anywhere(random), anywhere(random)), -1);
  std::shuffle(all.begin(), all.end(), random);
  std::vector<Vec2> measured;
  for (const auto& [p, number] : all) {
    const Vec2 at = scale * (p + Vec2(error(random), error(random)));
    measured.push_back(Vec2(3, -70) +
                       Vec2(std::cos(turn) * at.x() - std::sin(turn) * at.y(),
                            std::sin(turn) * at.x() + std::cos(turn) * at.y()));
    numbers.push_back(number);
  }
  return measured;
}

TEST(MarkMatching, FindsEachMarkInAnyTurn) {
  const auto marks = Pattern();
  unsigned seed = 1;
  for (const auto& [turn_deg, scale] :
       {std::pair{0.0, 1.0}, {1.3, 0.99}, {47.0, 1.01}, {180.0, 1.0}, {271.7, 0.99}}) {
    std::vector<int> numbers;
    const auto measured = Measured(marks, turn_deg, scale, ++seed, numbers);
    const auto matched = MatchMarks(marks, measured);
    ASSERT_TRUE(matched) << turn_deg << " " << matched.error().message;
    int wrong = 0, found = 0;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (numbers[i] < 0) continue;  // dust may lie where a lost mark would be
      found += (*matched)[i] == numbers[i] ? 1 : 0;
      wrong += (*matched)[i] >= 0 && (*matched)[i] != numbers[i] ? 1 : 0;
    }
    EXPECT_EQ(wrong, 0) << turn_deg << " " << scale;
    EXPECT_GE(found, 390) << "of 392; dust may be nearer than a mark";
  }
}

TEST(MarkMatching, RefusesWhatIsNotThePattern) {
  const auto marks = Pattern();
  std::vector<int> numbers;
  auto mirrored = Measured(marks, 10, 1, 3, numbers);
  for (Vec2& p : mirrored) p.x() = -p.x();
  const auto matched = MatchMarks(marks, mirrored);
  ASSERT_FALSE(matched);
  EXPECT_THAT(matched.error().message, testing::HasSubstr("seen from above"));
  EXPECT_EQ(MatchMarks(marks, {}).error().code, ErrorCode::kMissing);
  EXPECT_EQ(MatchMarks(marks, std::vector<Vec2>(5 * marks.size())).error().code,
            ErrorCode::kTooLarge);
}

}  // namespace
}  // namespace intaglio::calibrate
