// Jobs of contours through all processes, on a mill and on a laser cutter. The judge is
// the way that the controller really went: what of the plate, of the board and of the
// sheet is left by it.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numbers>

#include "engrave/contour/milling/nets.h"
#include "engrave/contour/region/region.h"
#include "tests/engrave/contour/files/kicad_text.h"
#include "tests/integration/course/course_shop.h"
#include "tests/integration/course/left_copper.h"

namespace intaglio::testing {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

// Half a step of the virtual grbl (1 / 250 mm) in x and in y, and its chords: within $12
// = 0.002 mm of an arc, but it rounds their number down.
constexpr double kPath_mm = 0.5 * 0.004 * std::numbers::sqrt2 + 0.0026;

/// A plate of 30 x 20 mm, its corner at (5, 5), with a hole of 8 mm.
constexpr const char* kPlate =
    R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="30mm" )"
    R"(viewBox="0 0 40 30"><rect x="5" y="5" width="30" height="20"/>)"
    R"(<circle cx="14" cy="18" r="4"/></svg>)";

/// The distance from that plate; below zero inside the part.
double DistanceFromPlate(const Vec2& place_mm) {
  const Vec2 beyond = (place_mm - Vec2(20, 15)).cwiseAbs() - Vec2(15, 10);
  const double outside =
      beyond.cwiseMax(0).norm() + std::min(0.0, std::max(beyond.x(), beyond.y()));
  return std::max(outside, 4 - (place_mm - Vec2(14, 12)).norm());
}

std::vector<Vec2> BorderOfPlate() {
  std::vector<Vec2> places;
  for (double along = 0; along <= 1; along += 0.001) {
    places.insert(places.end(), {{5 + 30 * along, 5},
                                 {5 + 30 * along, 25},
                                 {5, 5 + 20 * along},
                                 {35, 5 + 20 * along}});
    const double angle = 2 * std::numbers::pi * along;
    places.push_back(Vec2(14, 12) + 4 * Vec2(std::cos(angle), std::sin(angle)));
  }
  return places;
}

struct PlateJudgement {
  double nearest_mm = 1e9;     ///< of the tool's middle to the part
  double farthest_mm = 0;      ///< of the part's border from the tool's middle
  double dark_work_mm = 0;     ///< cut without a spindle or a beam
  double idle_in_work_mm = 0;  ///< not at work, and not above what is clamped
};

/// `work`: all steps that cut; `through`: those that cut the plate through.
PlateJudgement JudgePlate(const std::vector<ToolStep>& work,
                          const std::vector<ToolStep>& through) {
  PlateJudgement judgement;
  for (const ToolStep& step : work) {
    if (!step.on) judgement.dark_work_mm += step.length_mm();
    for (const Vec2& place : PlacesOn(step, 0.01))
      judgement.nearest_mm = std::min(judgement.nearest_mm, DistanceFromPlate(place));
  }
  for (const Vec2& place : BorderOfPlate())
    judgement.farthest_mm =
        std::max(judgement.farthest_mm, DistanceToWay(place, through));
  return judgement;
}

/// At work in a sheet whose surface is z = 0; -1 mm is its bottom.
std::vector<ToolStep> StepsBelow(const std::vector<ToolStep>& way, double z_mm) {
  std::vector<ToolStep> below;
  for (const ToolStep& step : way)
    if (step.lowest_mm() < z_mm) below.push_back(step);
  return below;
}

TEST(CourseJob, AMillCutsAPlateOutAndLeavesItWhole) {
  CourseShop shop(CourseShop::Machine::kMill);
  shop.Write("plate.svg", kPlate);
  ASSERT_TRUE(shop.Open()) << shop.Log();
  ASSERT_TRUE(shop.Submit(shop.WriteJob(
      "plate",
      "files: \"plate.svg\" make: COURSE_MAKE_CUT tool_diameter_mm: 2 depth_mm: 1 "
      "repeat_count: 2 speed_mm_s: 50 plunge_mm_s: 10")));
  ASSERT_TRUE(shop.AwaitDone(kJobBound)) << shop.shown() << shop.Log();
  const std::vector<ToolStep> way = shop.Way();
  const PlateJudgement plate =
      JudgePlate(StepsBelow(way, -1e-3), StepsBelow(way, -0.999));
  EXPECT_GE(plate.nearest_mm, 1 - kPath_mm) << "the tool is in the part";
  EXPECT_LE(plate.farthest_mm, 1 + kPath_mm) << "the part hangs on the sheet";
  EXPECT_EQ(plate.dark_work_mm, 0);
  double lowest_mm = 0;
  for (const ToolStep& step : way) {
    lowest_mm = std::min(lowest_mm, step.lowest_mm());
    const bool goes_aside = (step.to_mm - step.from_mm).head<2>().norm() > 0;
    const double z = step.lowest_mm();
    EXPECT_TRUE(!goes_aside || step.from_mm == Vec3::Zero() || z < -0.4 || z > 4.99)
        << "to " << step.to_mm.transpose();
    EXPECT_TRUE(!step.on || step.power == 10000) << step.power;
    if (step.to_mm.z() < -1e-3 && step.from_mm.z() > step.to_mm.z()) {
      EXPECT_GE(step.end_us - step.begin_us, 0.99e6 * step.length_mm() / 10)
          << "faster down than plunge_mm_s";
    }
  }
  EXPECT_NEAR(lowest_mm, -1, 0.002);
}

TEST(CourseJob, ALaserCutsAPlateOutAndIsDarkOnTheWay) {
  CourseShop shop(CourseShop::Machine::kLaser);
  shop.Write("plate.svg", kPlate);
  ASSERT_TRUE(shop.Open()) << shop.Log();
  ASSERT_TRUE(shop.Submit(
      shop.WriteJob("plate",
                    "files: \"plate.svg\" make: COURSE_MAKE_CUT tool_diameter_mm: 0.2 "
                    "power_ratio: 0.6 speed_mm_s: 40")));
  ASSERT_TRUE(shop.AwaitDone(kJobBound)) << shop.shown() << shop.Log();
  const std::vector<ToolStep> way = shop.Way();
  std::vector<ToolStep> lit;
  double lit_mm = 0, dark_mm = 0;
  for (const ToolStep& step : way) {
    (step.on ? lit_mm : dark_mm) += step.length_mm();
    if (!step.on) continue;
    lit.push_back(step);
    EXPECT_EQ(step.power, 600);
  }
  const PlateJudgement plate = JudgePlate(lit, lit);
  EXPECT_GE(plate.nearest_mm, 0.1 - kPath_mm);
  EXPECT_LE(plate.farthest_mm, 0.1 + kPath_mm);
  // Each border once, half the kerf beside it: 100 mm and four quarters of a circle, and
  // the hole. Chords and roundings shorten it.
  const double wanted_mm = 100 + 2 * std::numbers::pi * (0.1 + 3.9);
  EXPECT_NEAR(lit_mm, wanted_mm, 0.05);
  EXPECT_GT(dark_mm, 5);
}

/// Two pads of each of two nets, the one joined in front, the other behind.
std::string Board() {
  contour::test::KicadText text;
  text.Outline(0, 0, 20, 10);
  text.Footprint("R1", 0, 0);
  text.Pad("1", "circle", 3, 3, 2, 2, "A", 0.8);
  text.Pad("2", "circle", 17, 3, 2, 2, "A", 0.8);
  text.Pad("3", "circle", 3, 7, 2, 2, "B", 0.8);
  text.Pad("4", "rect", 17, 7, 2, 2, "B", 0.8);
  text.EndFootprint();
  text.Segment(3, 3, 10, 4.5, 0.5, "A");
  text.Segment(10, 4.5, 17, 3, 0.5, "A");
  text.Segment(3, 7, 17, 7, 0.5, "B", "B.Cu");
  return text.Text();
}
/// y goes down in KiCad.
const std::map<std::string, Vec2> kPads_mm = {
    {"A1", {3, -3}}, {"A2", {17, -3}}, {"B3", {3, -7}}, {"B4", {17, -7}}};

/// By engrave/contour: the sheet without what the tool swept, against the nets drawn.
contour::NetReport NetsLeft(const std::vector<ToolStep>& work) {
  std::vector<contour::Edges> paths;
  for (const ToolStep& step : work) {
    const Vec2 from = step.from_mm.head<2>(), to = step.to_mm.head<2>();
    if (from == to) continue;
    if (paths.empty() || paths.back().back().end_mm != from) paths.emplace_back();
    paths.back().push_back(contour::MakeLine(from, to));
  }
  const auto swept = contour::Swept(paths, 0.3);
  EXPECT_TRUE(swept) << swept.error().message;
  const Vec2 corners[] = {{-1, -11}, {21, -11}, {21, 1}, {-1, 1}};
  contour::Edges sheet;
  for (int i = 0; i < 4; ++i)
    sheet.push_back(contour::MakeLine(corners[i], corners[(i + 1) % 4]));
  const auto all = contour::RegionOfLoops({sheet});
  EXPECT_TRUE(all);
  if (!swept || !all) return {};
  const auto left = contour::Difference(*all, *swept);
  EXPECT_TRUE(left) << left.error().message;
  std::vector<contour::NetElement> drawn;
  for (const auto& [name, place] : kPads_mm) {
    contour::NetElement pad;
    pad.element = {contour::Circle{place, 2}, name};
    pad.net = name.starts_with("A") ? "A" : name;
    drawn.push_back(pad);
  }
  const std::vector<contour::Region> layers = {left ? *left : contour::Region()};
  const auto report = contour::CompareNets(layers, drawn);
  EXPECT_TRUE(report);
  return report ? *report : contour::NetReport();
}

TEST(CourseJob, AMillIsolatesABoardAndDrillsIt) {
  CourseShop shop(CourseShop::Machine::kMill);
  shop.Write("board.kicad_pcb", Board());
  ASSERT_TRUE(shop.Open()) << shop.Log();
  ASSERT_TRUE(shop.Submit(shop.WriteJob(
      "isolation",
      "files: \"board.kicad_pcb\" tool_diameter_mm: 0.3 pass_count: 2 depth_mm: 0.1 "
      "speed_mm_s: 60 plunge_mm_s: 10 drill_diameter_mm: 0")));
  ASSERT_TRUE(shop.AwaitDone(kJobBound)) << shop.shown() << shop.Log();
  const std::vector<ToolStep> work = StepsBelow(shop.Way(), -0.05);
  ASSERT_FALSE(work.empty());
  const LeftCopper copper(work, 0.15);
  std::map<std::string, int> island;
  for (const auto& [name, place] : kPads_mm) {
    island[name] = copper.IslandAt(place + Vec2(0.7, 0));
    EXPECT_GT(island[name], 0) << name << " is cut away";
  }
  EXPECT_EQ(island["A1"], island["A2"]);
  EXPECT_NE(island["A1"], island["B3"]);
  EXPECT_NE(island["A1"], island["B4"]);
  EXPECT_NE(island["B3"], island["B4"]) << "they are joined behind";
  const int sheet = copper.IslandAt({-0.9, 0.9});
  for (const auto& [name, number] : island) EXPECT_NE(number, sheet) << name;
  const contour::NetReport nets = NetsLeft(work);
  EXPECT_EQ(nets.net_count, 3U);
  EXPECT_TRUE(nets.faults.empty()) << nets.faults[0].sentence;

  // The next tool: a job of its own.
  const std::size_t before = shop.Way().size();
  ASSERT_TRUE(shop.Submit(shop.WriteJob(
      "holes",
      "files: \"board.kicad_pcb\" drill_diameter_mm: 0.8 drill_depth_mm: 1.8 "
      "speed_mm_s: 20")));
  ASSERT_TRUE(Eventually(
      [&] {
        return shop.Type({"show", "2"}).find("done") != std::string::npos;
      },
      kJobBound));
  std::vector<ToolStep> way = shop.Way();
  way.erase(way.begin(), way.begin() + static_cast<std::ptrdiff_t>(before));
  std::map<std::string, int> drilled;
  for (const ToolStep& step : StepsBelow(way, -1.799)) {
    for (const auto& [name, place] : kPads_mm) {
      const bool here = (step.to_mm.head<2>() - place).norm() <= kPath_mm;
      drilled[name] += here && step.to_mm.z() < step.from_mm.z();
    }
  }
  for (const auto& [name, place] : kPads_mm) EXPECT_EQ(drilled[name], 1) << name;
  for (const ToolStep& step : StepsBelow(way, -1e-3))
    EXPECT_LE((step.to_mm - step.from_mm).head<2>().norm(), 1e-9) << "aside in the board";
}

}  // namespace
}  // namespace intaglio::testing
