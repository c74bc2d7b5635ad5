// What an isolation leaves has the nets that were drawn, also where a gap is as wide as
// the tool: found by geometry, with the copper that the tool leaves.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "engrave/contour/isolation.h"
#include "engrave/contour/milling/nets.h"

namespace intaglio::contour {
namespace {

using ::testing::HasSubstr;

Region Sheet(double half_mm) {
  const Vec2 a(-half_mm, -half_mm), b(half_mm, -half_mm), c(half_mm, half_mm),
      d(-half_mm, half_mm);
  return {{{MakeLine(a, b), MakeLine(b, c), MakeLine(c, d), MakeLine(d, a)}}};
}

/// Parts of what is left that hold the centre of an element.
std::size_t PiecesWithCopper(const Isolation& isolation, double tool_mm,
                             const std::vector<Vec2>& centers_mm) {
  const auto left = CopperLeft(Sheet(60), isolation, tool_mm);
  EXPECT_TRUE(left) << left.error().message;
  if (!left) return 0;
  std::size_t count = 0;
  for (const Region& part : ConnectedParts(*left)) {
    const bool holds = std::ranges::any_of(
        centers_mm, [&](const Vec2& place) { return IsInside(part, place); });
    if (holds) ++count;
  }
  return count;
}

// Tools and gaps in whole steps of mils and of 10 um, as boards have them.
TEST(IsolatedPieces, AGapAsWideAsTheToolIsCut) {
  std::mt19937 random(13);
  std::uniform_int_distribution<int> steps(5, 60), sides(10, 80);
  for (int k = 0; k < 300; ++k) {
    const double step_mm = k % 2 == 0 ? 0.01 : 0.0254;
    const double tool_mm = steps(random) * step_mm;
    const double side_mm = sides(random) * step_mm;
    const double pitch_mm = side_mm + tool_mm;
    std::vector<Element> elements;
    std::vector<Vec2> centers;
    for (int x = 0; x < 3; ++x) {
      for (int y = 0; y < 2; ++y) {
        const Vec2 at(x * pitch_mm, y * pitch_mm);
        if (k % 3 == 0)
          elements.push_back({Circle{at, side_mm}});
        else
          elements.push_back({Square{at, side_mm}});
        centers.push_back(at);
      }
    }
    SCOPED_TRACE(testing::Message() << "tool " << tool_mm << ", side " << side_mm);
    const int passes = k % 4 == 0 ? 2 : 1;
    const auto isolation = Isolate(elements, {tool_mm, passes});
    ASSERT_TRUE(isolation) << isolation.error().message;
    EXPECT_EQ(isolation->net_count, centers.size());
    EXPECT_EQ(isolation->piece_count, centers.size());
    EXPECT_EQ(isolation->passes[0].contours.size(), centers.size());
    if (k % 10 < 3) {
      EXPECT_EQ(PiecesWithCopper(*isolation, tool_mm, centers), centers.size());
    }
  }
}

// A ring around a pad, with a gap as wide as the tool all around.
TEST(IsolatedPieces, AGapAroundAPadIsCut) {
  const std::vector<Element> elements{
      {Circle{{0, 0}, 1}, "pad"}, {ArcTrack{MakeArc({0, 0}, 1, 0, kTwoPi), 0.6}, "ring"}};
  const auto isolation = Isolate(elements, {0.2});
  ASSERT_TRUE(isolation) << isolation.error().message;
  EXPECT_EQ(isolation->piece_count, 2U);
  EXPECT_EQ(PiecesWithCopper(*isolation, 0.2, {{0, 0}, {1, 0}}), 2U);
}

TEST(IsolatedPieces, OneNetNeedsNoGapToItself) {
  std::vector<Element> elements{{Circle{{0, 0}, 1}, "R1-1", "GND"},
                                {Circle{{1.15, 0}, 1}, "R2-1", "GND"},
                                {Circle{{0, 3}, 1}, "R1-2", "VCC"}};
  const auto isolation = Isolate(elements, {0.2});
  ASSERT_TRUE(isolation) << isolation.error().message;
  EXPECT_EQ(isolation->net_count, 3U);
  EXPECT_EQ(isolation->piece_count, 2U);
  elements[1].net = "VCC";
  const auto refused = Isolate(elements, {0.2});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("cannot isolate R1-1 from R2-1"));
  // Names that are none are not one net.
  elements[0].net = elements[1].net = "";
  EXPECT_FALSE(Isolate(elements, {0.2}));
}

}  // namespace
}  // namespace intaglio::contour
