#include "engrave/course/path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace intaglio::course {
namespace {

// A slot: two lines and two half circles of radius 5.
Path Slot() {
  const std::vector<Piece> pieces{{Vec2(30, 0), 50},
                                  {Vec2(30, 10), 20, std::numbers::pi},
                                  {Vec2(0, 10), 50},
                                  {Vec2(0, 0), 20, std::numbers::pi}};
  return Path::Make(Vec2(0, 0), pieces).value();
}

TEST(Path, DividesArcsAndKeepsThem) {
  const Path path = Slot();
  EXPECT_NEAR(path.length_mm(), 60 + 10 * std::numbers::pi, 1e-12);
  for (std::size_t k = 1; k + 1 < path.node_count(); ++k)
    EXPECT_NEAR(path.TurnAt(k), 0, 1e-9) << k;
  for (const Segment& segment : path.segments()) {
    EXPECT_LE(std::abs(segment.sweep_rad), kMaxSegmentTurnRad);
    if (segment.straight()) continue;
    const Vec2 center = segment.begin_mm.x() > 15 ? Vec2(30, 5) : Vec2(0, 5);
    EXPECT_NEAR((segment.PointAt(segment.length_mm / 3) - center).norm(), 5, 1e-9);
    EXPECT_NEAR((segment.PointAt(segment.length_mm) - segment.end_mm).norm(), 0, 1e-9);
    EXPECT_EQ(segment.feed_mm_s, 20);
  }
}

TEST(Path, CursorMovesWithTheArcLength) {
  const Path path = Slot();
  PathCursor cursor(path);
  Vec2 last = cursor.PointAt(-1);
  EXPECT_NEAR((last - Vec2(-1, 0)).norm(), 0, 1e-12);
  for (double s = -0.99; s < path.length_mm() + 1; s += 0.01) {
    const Vec2 p = cursor.PointAt(s);
    // A chord of .01 mm on a radius of 5 mm is shorter than its arc by 2e-9.
    ASSERT_NEAR((p - last).norm(), 0.01, 1e-8) << s;
    last = p;
  }
}

TEST(NearestOn, IsTheNearestOfManyPoints) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> x(-10, 40), y(-10, 20);
  const Path path = Slot();
  for (int i = 0; i < 200; ++i) {
    const Vec2 p(x(random), y(random));
    for (const Segment& segment : path.segments()) {
      double nearest = 1e9;
      for (int k = 0; k <= 2000; ++k)
        nearest =
            std::min(nearest, (segment.PointAt(segment.length_mm * k / 2000) - p).norm());
      const Foot foot = NearestOn(segment, p);
      ASSERT_LE(foot.distance_mm, nearest + 1e-12);
      // Steps of at most 15 um.
      ASSERT_GE(foot.distance_mm, nearest - 0.0076);
      ASSERT_NEAR((segment.PointAt(foot.at_mm) - p).norm(), foot.distance_mm, 1e-9);
    }
  }
}

TEST(Path, RefusesWhatIsNoPieceAndNamesIt) {
  const auto message_of = [](const Piece& piece) {
    const std::vector<Piece> pieces{{Vec2(1, 0), 10}, piece};
    const auto path = Path::Make(Vec2(0, 0), pieces);
    return path ? "accepted" : path.error().message;
  };
  EXPECT_EQ(message_of({Vec2(1, 0), 10}),
            "piece 2: is 0 mm long, less than 1e-06; leave it out");
  EXPECT_EQ(message_of({Vec2(2, 0), 0}), "piece 2: feed_mm_s 0 is outside 0.01..10000");
  EXPECT_EQ(message_of({Vec2(2, NAN), 10}),
            "piece 2: the coordinate nan mm is outside -1000000..1000000");
  EXPECT_EQ(message_of({Vec2(2, 0), 10, 7}), "piece 2: sweep_rad 7 is not within 2 pi");
  EXPECT_EQ(Path::Make(Vec2(0, 0), {}).error().code, ErrorCode::kMissing);
}

}  // namespace
}  // namespace intaglio::course
