// `intaglio teach outline` through all processes at a virtual BJJCZ board, whose own
// record has each way of the mirrors with the guide laser on.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "engrave/formats/point_file.h"
#include "tests/integration/bjjcz_glass.h"
#include "tests/integration/guide_ways.h"
#include "tests/integration/point_shop.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using testing::Ended;
using testing::Eventually;
using testing::GuideWay;
using ::testing::HasSubstr;
using testing::Running;

constexpr double kPlaceMm = testing::kBoardFieldMm / 65536;

/// Where the mirrors aim for a point: FocusInGlass inverted step by step. It converges by
/// a factor of about 10 a step.
Vec2 FieldOf(const Vec3& glass_mm) {
  Vec2 field = glass_mm.head<2>() - Vec2::Constant(testing::kHalfBlockMm);
  double below = (testing::kBlockHeightMm - glass_mm.z()) / testing::kBoardIndex;
  for (int i = 0; i < 20; ++i) {
    const Vec3 by_mm = glass_mm - testing::FocusInGlass(field, below);
    field += by_mm.head<2>();
    below -= by_mm.z() / testing::kBoardIndex;
  }
  return field;
}

class BoardOutline : public ::testing::Test {
 protected:
  BoardOutline()
      : shop_({.controller = "bjjcz",
               .profile = "bjjcz-glass",
               .controller_options = {"--axis", "400", "--guide", "8"},
               .has_panel = true,
               .job = testing::KnotOf(6, 0.3) +
                      "laser { photosensor_feedback: false }\n"}) {}
  void SetUp() override { ASSERT_TRUE(shop_.Open()) << shop_.Log(); }

  void AtPanel(const std::string& command) const {
    EXPECT_EQ(testing::AskPanel(shop_.folder(), command), "ok\n") << command;
  }
  std::vector<GuideWay> Ways() const {
    return testing::GuideWaysOf(shop_.record(), testing::kBoardFieldMm);
  }
  bool HasPulses() const {
    const std::string record = testing::TextIn(shop_.record());
    return record.find("flash") != std::string::npos ||
           record.find("mark") != std::string::npos;
  }
  std::unique_ptr<Running> Outline() const {
    return shop_.Start({"teach", "outline", shop_.job().string()});
  }
  std::unique_ptr<Running> Drawing() const {
    return testing::AwaitDrawing([&] { return Outline(); },
                                 [&] { return Ways().size(); });
  }
  bool Rests() const {
    return testing::GuideRests([&] { return Ways().size(); });
  }
  PointList PointsOfJob() const {
    const auto file = shop_.folder() / "points.ply";
    Running run(testing::Program("intaglio"),
                {"discretize", shop_.job().string(), "--out", file.string()},
                shop_.folder() / "discretize.txt");
    EXPECT_EQ(run.WaitForEnd(60s).exit_code, 0) << run.Output();
    const auto cloud = formats::ReadPly(file);
    return cloud ? cloud->points_mm : PointList();
  }

  testing::PointShop shop_;
};

TEST_F(BoardOutline, HasAllPointsOfTheJobWithinItAndItsCornersAtPoints) {
  const auto client = Drawing();
  std::this_thread::sleep_for(2s);
  client->Signal(SIGINT);
  const Ended ended = client->WaitForEnd(20s);
  EXPECT_EQ(ended.exit_code, 0) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("the guide laser draws"));
  EXPECT_TRUE(Rests());
  EXPECT_FALSE(HasPulses());
  std::vector<Vec2> aims;
  for (const Vec3& point : PointsOfJob()) aims.push_back(FieldOf(point));
  ASSERT_GT(aims.size(), 300u);
  // Half a place on both axes, and what the polygon of 64 corners leaves out.
  constexpr double kRounded = 0.71 * kPlaceMm, kLeftOut = 0.01;
  // The same ways come again and again.
  std::vector<GuideWay> ways = Ways();
  ASSERT_GT(ways.size(), 70u);
  ways.resize(70);
  for (const GuideWay& way : ways) {
    const Vec2 along = way.to_mm - way.from_mm;
    const auto at_corner = std::ranges::any_of(aims, [&](const Vec2& aim) {
      return (aim - way.to_mm).norm() <= kRounded + 1e-4;
    });
    EXPECT_TRUE(at_corner) << way.to_mm.transpose() << " is at no point";
    if (along.norm() < 10 * kPlaceMm) continue;  // its direction is that of rounding
    for (const Vec2& aim : aims) {
      const Vec2 to = aim - way.from_mm;
      const double left_mm = (along.x() * to.y() - along.y() * to.x()) / along.norm();
      ASSERT_GE(left_mm, -kLeftOut) << aim.transpose() << " is outside";
    }
  }
}

TEST_F(BoardOutline, EndsWithAStop) {
  const auto client = Drawing();
  shop_.Type({"stop"});
  EXPECT_TRUE(Rests());
  const Ended ended = client->WaitForEnd(20s);
  EXPECT_EQ(ended.exit_code, 4) << ended.output;
  EXPECT_THAT(ended.output, HasSubstr("stop"));
  shop_.Type({"stop", "--reset"});
  EXPECT_TRUE(Rests()) << "it begins again by itself";
  EXPECT_FALSE(HasPulses());
}

TEST_F(BoardOutline, EndsWithItsPersonAndWithTheMachinesState) {
  const auto nothing = [](Running&) {};
  const std::vector<testing::OutlineEnding> endings = {
      {"Ctrl-C", [](Running& client) { client.Signal(SIGINT); }, nothing},
      {"client killed", [](Running& client) { client.Signal(SIGKILL); }, nothing},
      {"client hangs", [](Running& client) { client.Signal(SIGSTOP); },
       [](Running& client) { client.Signal(SIGKILL); }},
      {"door", [&](Running&) { AtPanel("door open"); },
       [&](Running&) { AtPanel("door close"); }, "door"},
      {"synchronizer killed",
       [&](Running&) { EXPECT_GT(shop_.Kill("intaglio-synchronizer"), 0); }, nothing,
       "key and door are not known"},
      {"bridge killed",
       [&](Running&) { EXPECT_GT(shop_.Kill("intaglio-motion-bridge"), 0); }, nothing},
      {"job armed", [&](Running&) { EXPECT_TRUE(shop_.Submit()); }, nothing, "", true},
  };
  testing::ExpectEachEndsIt(
      endings, [&] { return Drawing(); }, [&] { return Rests(); },
      [&] { return HasPulses(); });
  EXPECT_TRUE(Eventually([&] { return HasPulses(); }, 60s)) << "the job is not made";
}

}  // namespace
}  // namespace intaglio
