// Heights of a probed surface against a plain interpolation, and programs that follow it
// against LinuxCNC's interpreter.

#include "engrave/post/height_map.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "engrave/post/drill_program.h"
#include "engrave/post/mill_program.h"
#include "tests/engrave/post/judge_programs.h"
#include "tests/engrave/post/supplied_templates.h"

namespace intaglio::post {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kStepMm = 7.5;
constexpr int kColumns = 5, kRows = 4;

/// Heights of up to 0.3 mm at the places of a grid from (0, 0) on.
struct Surface {
  std::vector<double> z_mm;
  explicit Surface(unsigned seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> height(-0.3, 0.3);
    for (int i = 0; i < kColumns * kRows; ++i) z_mm.push_back(height(random));
  }
  /// By the four corners' areas, in place of one axis after the other.
  double At(const Vec2& place_mm) const {
    const double x = std::clamp(place_mm.x() / kStepMm, 0.0, kColumns - 1.0);
    const double y = std::clamp(place_mm.y() / kStepMm, 0.0, kRows - 1.0);
    double sum = 0;
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        const double share = std::max(0.0, 1 - std::abs(x - column)) *
                             std::max(0.0, 1 - std::abs(y - row));
        sum += share * z_mm[static_cast<std::size_t>(row * kColumns + column)];
      }
    }
    return sum;
  }
  /// As a probe writes them, in another order than the map's.
  std::string Text(const Vec2& origin_mm = Vec2::Zero()) const {
    std::ostringstream text;
    text.precision(9);
    for (int column = kColumns - 1; column >= 0; --column) {
      for (int row = 0; row < kRows; ++row) {
        text << column * kStepMm + origin_mm.x() << ' ' << row * kStepMm + origin_mm.y()
             << ' ' << z_mm[static_cast<std::size_t>(row * kColumns + column)]
             << " 0 0 0\n";
      }
    }
    return text.str();
  }
  HeightMap Map() const {
    auto map = ParseHeightMap(Text(), "a.txt");
    EXPECT_TRUE(map) << map.error().message;
    return *map;
  }
};

TEST(HeightMap, IsBilinearBetweenItsPlacesAndLevelBeyond) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-3, 33);
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Surface surface(seed);
    const HeightMap map = surface.Map();
    EXPECT_THAT(map.x_mm(), ElementsAre(0, 7.5, 15, 22.5, 30));
    EXPECT_THAT(map.y_mm(), ElementsAre(0, 7.5, 15, 22.5));
    for (int i = 0; i < 100; ++i) {
      const Vec2 at_mm(place(random), place(random));
      EXPECT_NEAR(map.At(at_mm), surface.At(at_mm), 1e-9);
    }
  }
}

TEST(HeightMap, AWayIsDividedUntilItFollowsTheSurface) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> x(0, 30), y(0, 22.5);
  for (unsigned seed = 0; seed < 50; ++seed) {
    const Surface surface(seed);
    const HeightMap map = surface.Map();
    const Vec2 origin_mm(100, -50);
    ToolPath path{"contour 1", Vec2(x(random), y(random)) + origin_mm, {}};
    for (int i = 0; i < 5; ++i)
      path.moves.push_back(LineTo(Vec2(x(random), y(random)) + origin_mm));
    const ToolPath divided = map.Divided(path, origin_mm, 0.001);
    EXPECT_EQ(divided.moves.back().end_mm, path.moves.back().end_mm);
    Vec2 from_mm = divided.begin_mm;
    for (const WorkMove& move : divided.moves) {
      const double from_z = surface.At(from_mm - origin_mm),
                   to_z = surface.At(move.end_mm - origin_mm);
      for (double share = 0; share <= 1; share += 0.1) {
        const Vec2 at_mm = from_mm + share * (move.end_mm - from_mm) - origin_mm;
        EXPECT_NEAR(std::lerp(from_z, to_z, share), surface.At(at_mm), 0.00101);
      }
      from_mm = move.end_mm;
    }
    EXPECT_LT(divided.moves.size(), 300u) << "no more than it needs";
  }
}

// Grbl answers with places of the machine.
TEST(HeightMap, AnswersOfGrblAreMovedToTheWork) {
  const std::string text =
      "ok\n[PRB:100.000,50.000,-30.100:1]\r\n[PRB:110.000,50.000,-30.000:1]\nok\n"
      "[PRB:100.000,60.000,-29.900:1]\n[PRB:110.010,60.000,-29.800:1]\n<Idle|...>\n";
  const auto map = ParseHeightMap(text, "log.txt", {100, 50, -30});
  ASSERT_TRUE(map) << map.error().message;
  EXPECT_NEAR(map->At({0, 0}), -0.1, 1e-9);
  EXPECT_NEAR(map->At({10, 10}), 0.2, 1e-3);
  EXPECT_NEAR(map->max_mm(), 0.2, 1e-9);
  const auto without = ParseHeightMap(text, "log.txt");
  ASSERT_FALSE(without);
  EXPECT_EQ(without.error().code, ErrorCode::kMissing);
  EXPECT_THAT(without.error().message,
              AllOf(HasSubstr("log.txt:2: "), HasSubstr("--height-map-zero")));
}

std::string HeightErrorOf(const std::string& text) {
  const auto map = ParseHeightMap(text, "a.txt", {0, 0, 0});
  return map ? "no error" : map.error().message;
}

TEST(HeightMap, EachMistakeHasItsLine) {
  const std::string square = "0 0 1\n1 0 1\n0 1 1\n1 1 1\n";
  EXPECT_EQ(HeightErrorOf("# a comment\n(another)\n" + square), "no error");
  EXPECT_EQ(HeightErrorOf("\xEF\xBB\xBF" + square), "no error");
  EXPECT_EQ(HeightErrorOf("0,0,1\n1;0;1\n0\t1\t1\n1, 1, 1\n"), "no error");
  EXPECT_THAT(HeightErrorOf(square + "2 zero 1\n"), HasSubstr("a.txt:5: 'zero' is no y"));
  EXPECT_THAT(HeightErrorOf(square + "2 0\n"), HasSubstr("a.txt:5: '' is no z"));
  EXPECT_THAT(HeightErrorOf(square + "2 0 nan\n"), HasSubstr("a.txt:5: 'nan' is no z"));
  EXPECT_THAT(HeightErrorOf(square + "2 0 1e300\n"), HasSubstr("a.txt:5: "));
  EXPECT_THAT(HeightErrorOf(square + "0.01 0 2\n"),
              HasSubstr("a.txt:5: a height of this place"));
  EXPECT_THAT(HeightErrorOf(square + "2 0 1\n"),
              HasSubstr("the height at (2, 1) mm is missing"));
  EXPECT_THAT(HeightErrorOf("0 0 1\n1 0 1\n"), HasSubstr("2 x 1 places"));
  EXPECT_THAT(HeightErrorOf(""), HasSubstr("0 x 0 places"));
  EXPECT_THAT(HeightErrorOf("[PRB:0,0,0:0]\n"), HasSubstr("touched nothing"));
  EXPECT_THAT(HeightErrorOf("[PRB:0,0,0\n"), HasSubstr("without its end"));
  std::string scattered;
  for (int i = 0; i < 1000; ++i)
    scattered += std::to_string(i) + " " + std::to_string(2 * i) + " 0\n";
  EXPECT_THAT(HeightErrorOf(scattered), HasSubstr("form no grid"));
}

TEST(HeightMap, PlacesToProbeCoverTheWorkInRowsForthAndBack) {
  const auto places = ProbePlaces({1, 2}, {11, 6}, 5);
  EXPECT_THAT(places, ElementsAre(Vec2(1, 2), Vec2(6, 2), Vec2(11, 2), Vec2(11, 6),
                                  Vec2(6, 6), Vec2(1, 6)));
  EXPECT_EQ(ProbePlaces({0, 0}, {0, 0}, 5).size(), 4u) << "a point";
}

// What the tool does along the whole program, as LinuxCNC reads it.
TEST(HeightMap, Rs274FollowsTheSurface) {
  if (!fixture::IsInstalled("rs274"))
    GTEST_SKIP() << "no rs274: install the package linuxcnc-uspace";
  const Surface surface(3);
  const HeightMap map = surface.Map();
  const Vec2 origin_mm(10, 20);
  const auto at = [&](double x, double y) { return Vec2(Vec2(x, y) + origin_mm); };
  const std::vector<ToolPath> paths = {
      PathOf({contour::MakeLine(at(1, 1), at(28, 3)),
              contour::MakeLine(at(28, 3), at(2, 20)),
              contour::MakeLine(at(2, 20), at(1, 1))},
             "contour 1"),
      PathOf({contour::MakeArc(at(15, 11), 8, 0, 6)}, "contour 2")};
  for (const char* name : {"linuxcnc", "grbl"}) {
    MillOptions options;
    options.heights = &map;
    options.origin_mm = origin_mm;
    Cutting cutting{.name = "board"};
    cutting.depths_mm = {-0.1, -0.2};
    const auto texts = MillPrograms(fixture::SuppliedMill(name), paths, cutting, options);
    ASSERT_TRUE(texts) << texts.error().message;
    const auto file = intaglio::test::FreshFolder() / (std::string(name) + ".ngc");
    std::ofstream(file) << texts->front();
    std::istringstream canon(fixture::OutputOf("rs274 -g " + file.string()));
    Vec3 at_mm(0, 0, 99);
    int fed = 0, idle = 0;
    double deepest = 0;
    for (std::string line; std::getline(canon, line);) {
      const auto begin = line.find("STRAIGHT_");
      if (begin == std::string::npos || line.find("STRAIGHT_PROBE") != line.npos)
        continue;
      Vec3 to_mm;
      ASSERT_EQ(std::sscanf(line.c_str() + line.find('('), "(%lf, %lf, %lf", &to_mm.x(),
                            &to_mm.y(), &to_mm.z()),
                3);
      const double depth_mm = to_mm.z() - surface.At(to_mm.head<2>());
      if (line.find("STRAIGHT_TRAVERSE") != line.npos) {
        EXPECT_GT(std::min(at_mm.z(), to_mm.z()) -
                      surface.At((at_mm.head<2>() + to_mm.head<2>()) / 2),
                  to_mm.head<2>() == at_mm.head<2>() ? -1.0 : 1.5)
            << "the way between is above the highest place";
        ++idle;
      } else {
        const bool upper = std::abs(depth_mm + 0.1) < std::abs(depth_mm + 0.2);
        EXPECT_NEAR(depth_mm, upper ? -0.1 : -0.2, 0.002) << line;
        if (at_mm.head<2>() != to_mm.head<2>()) {
          const Vec3 middle = (at_mm + to_mm) / 2;
          EXPECT_NEAR(middle.z() - surface.At(middle.head<2>()), upper ? -0.1 : -0.2,
                      0.003);
        }
        deepest = std::min(deepest, depth_mm);
        ++fed;
      }
      at_mm = to_mm;
    }
    EXPECT_GT(fed, 100);
    EXPECT_GT(idle, 4);
    EXPECT_NEAR(deepest, -0.2, 0.002);
  }
}

TEST(HeightMap, HolesAreAsDeepEverywhere) {
  const Surface surface(5);
  const HeightMap map = surface.Map();
  const std::vector<DrillRound> rounds = {{0.8, {{3, 4}, {20, 15}}}};
  Cutting cutting;
  cutting.depths_mm = {-2};
  const auto texts = DrillPrograms(fixture::SuppliedDrill("grbl"), rounds, cutting,
                                   Vec2::Zero(), {}, &map);
  ASSERT_TRUE(texts) << texts.error().message;
  std::istringstream lines(texts->front());
  std::vector<double> depths;
  for (std::string line; std::getline(lines, line);)
    if (line.starts_with("G1 Z")) depths.push_back(std::stod(line.substr(4)));
  ASSERT_EQ(depths.size(), 2u);
  EXPECT_NEAR(depths[0], -2 + surface.At({3, 4}), 0.001);
  EXPECT_NEAR(depths[1], -2 + surface.At({20, 15}), 0.001);
}

TEST(HeightMap, WhatCannotFollowItIsRefused) {
  const Surface surface(1);
  const HeightMap map = surface.Map();
  MillOptions options;
  options.heights = &map;
  const auto far =
      MillPrograms(fixture::SuppliedMill("grbl"),
                   std::vector{PathOf({contour::MakeLine({0, 0}, {34, 0})}, "contour 1")},
                   {}, options);
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().code, ErrorCode::kInvalidValue);
  EXPECT_THAT(far.error().message, AllOf(HasSubstr("contour 1 reaches (34.00, 0.00)"),
                                         HasSubstr("x 0 to 30")));
  const auto flat = MillPrograms(
      fixture::SuppliedMill("sinumerik"),
      std::vector{PathOf({contour::MakeLine({0, 0}, {3, 0})}, "contour 1")}, {}, options);
  ASSERT_FALSE(flat);
  EXPECT_EQ(flat.error().code, ErrorCode::kUnsupported);
  EXPECT_THAT(flat.error().message, HasSubstr("line-z"));
  const std::vector<DrillRound> outside = {{0.8, {{50, 4}}}};
  EXPECT_FALSE(
      DrillPrograms(fixture::SuppliedDrill("grbl"), outside, {}, Vec2::Zero(), {}, &map));
  EXPECT_FALSE(
      DrillPrograms(fixture::SuppliedDrill("krl"), {}, {}, Vec2::Zero(), {}, &map));
}

}  // namespace
}  // namespace intaglio::post
