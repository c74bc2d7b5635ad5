// A job through the product's processes and a controller of isel: the virtual isel in a
// process of its own, whose record of its output is the judge.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <fstream>
#include <map>
#include <sstream>

#include "tests/integration/point_shop.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using testing::Eventually;

constexpr double kIselStepsPerMm = 80;  // of the supplied profile
using Steps = std::array<long, 3>;

class IselJob : public ::testing::Test {
 protected:
  IselJob()
      : shop_({.controller = "isel",
               .profile = "isel",
               .job = testing::KnotOf(2.4, 0.4) +
                      "laser { photosensor_feedback: false rate_hz: 50 }\n"}) {}
  void SetUp() override { ASSERT_TRUE(shop_.Open()) << shop_.Log(); }
  std::vector<Steps> Flashes(bool* moved = nullptr) const {
    std::vector<Steps> flashes;
    std::ifstream record(shop_.record());
    for (std::string line; std::getline(record, line);) {
      std::istringstream in(line);
      std::string kind;
      Steps at{};
      double on_us = 0;
      bool with_motion = false;
      if (!(in >> kind >> at[0] >> at[1] >> at[2] >> on_us >> with_motion)) continue;
      flashes.push_back(at);
      if (moved != nullptr) *moved = *moved || with_motion;
    }
    return flashes;
  }

  struct Judgement {
    std::size_t points = 0, flashes = 0, made = 0, doubled = 0, stray = 0, uncertain = 0;
    bool moved = false;
  };
  Judgement Judge() const;

  testing::PointShop shop_;
};

// In x and y the axes are where the points are. In z glass refracts: points of one height
// have one height of the axis, so each flash is compared with those of its own x and y,
// the deepest first in both.
IselJob::Judgement IselJob::Judge() const {
  Judgement judgement;
  const testing::PointShop::Points job = shop_.PointsOfJob();
  EXPECT_FALSE(job.at_mm.empty());
  using Column = std::pair<long, long>;
  std::map<Column, std::size_t> points;
  std::map<Column, std::map<long, int>> flashes;
  for (const Vec3& point : job.at_mm) {
    ++points[{std::lround(point.x() * kIselStepsPerMm),
              std::lround(point.y() * kIselStepsPerMm)}];
  }
  for (const Steps& flash : Flashes(&judgement.moved)) {
    ++judgement.flashes;
    const Column column{flash[0], flash[1]};
    judgement.stray += points.count(column) == 0;
    judgement.doubled += ++flashes[column][flash[2]] > 1;
  }
  for (const auto& [column, heights] : flashes) judgement.made += heights.size();
  judgement.points = job.at_mm.size();
  judgement.uncertain = job.UncertainCount();
  return judgement;
}

TEST_F(IselJob, EveryPointIsMadeOnceAtItsStepAndAtRest) {
  ASSERT_TRUE(shop_.Submit());
  ASSERT_TRUE(shop_.AwaitDone(240s, false)) << shop_.shown();
  const Judgement judgement = Judge();
  EXPECT_GT(judgement.points, 50U);
  EXPECT_EQ(judgement.made, judgement.points);
  EXPECT_EQ(judgement.flashes, judgement.points);
  EXPECT_EQ(judgement.doubled + judgement.stray + judgement.uncertain, 0U);
  EXPECT_FALSE(judgement.moved);
  std::cout << "  " << judgement.points << " points\n";
}

// A controller that homes is mute for longer than a status is believed: two seconds here.
// On a busy computer the jog, or the home, is let go before: then once more.
TEST_F(IselJob, HomeByHandLastsAsLongAsTheControllerTakes) {
  std::string homed = "not begun", place;
  const auto goes_home = [&] {
    (void)shop_.Type({"teach", "move", "50", "0", "0", "--speed", "30"});
    place = shop_.Type({"teach", "status"});
    if (place.find("x         50.0000 mm") == std::string::npos) return false;
    homed = shop_.Type({"teach", "home"});
    return homed.starts_with("x ");
  };
  ASSERT_TRUE(Eventually(goes_home, 90s)) << homed << place;
  EXPECT_THAT(shop_.Type({"teach", "status"}),
              ::testing::HasSubstr("x          0.0000 mm"));
}

TEST_F(IselJob, KillsOfTheBridgeDoubleNoPoint) {
  ASSERT_TRUE(shop_.Submit());
  std::size_t killed = 0;
  for (int i = 0; i < 3; ++i) {
    const std::size_t before = Flashes().size();
    if (!Eventually([&] { return Flashes().size() > before + 7; }, 30s)) break;
    killed += static_cast<std::size_t>(shop_.Kill("intaglio-motion-bridge"));
    (void)shop_.AwaitDone(3s, true);
  }
  ASSERT_TRUE(shop_.AwaitDone(240s, true)) << shop_.shown();
  const Judgement judgement = Judge();
  EXPECT_GT(killed, 0U);
  EXPECT_EQ(judgement.doubled + judgement.stray, 0U);
  // A kill leaves those that were armed and not reported, at most
  // laser.max_unsettled_points of the profile. A line between bridge and controller that
  // is lost without a kill would add the one pulse that was sent (L6); so the controller
  // runs in real time, as the bridge does.
  constexpr std::size_t kOpenPoints = 4;
  EXPECT_LE(judgement.uncertain, kOpenPoints * killed);
  EXPECT_GE(judgement.made + judgement.uncertain, judgement.points);
  EXPECT_FALSE(judgement.moved);
  std::cout << "  " << killed << " kills, " << judgement.points << " points, "
            << judgement.made << " made, " << judgement.uncertain << " uncertain\n";
}

}  // namespace
}  // namespace intaglio
