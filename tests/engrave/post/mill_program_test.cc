#include "engrave/post/mill_program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <set>

#include "engrave/post/lathe_reach.h"
#include "tests/engrave/post/supplied_templates.h"

namespace intaglio::post {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr std::string_view kPlain =
    "#number X Y decimals=1\n#fragment start\nstart @NAME@ @N@\n"
    "#fragment approach\nto @X@ @Y@ @N@\n#fragment line\nline @X@ @Y@ @N@\n"
    "#fragment retract\nup @X@ @Y@ @N@\n#fragment end\nend @N@\n";

Template MillFrom(std::string_view text) {
  auto parsed = ParseMillTemplate(text, "a.post");
  EXPECT_TRUE(parsed) << (parsed ? "" : parsed.error().message);
  return parsed.value_or(Template{});
}

std::string MillErrorOf(std::string_view text) {
  const auto parsed = ParseMillTemplate(text, "a.post");
  return parsed ? "no error" : parsed.error().message;
}

ToolPath Triangle() {
  return PathOf({contour::MakeLine({0, 0}, {10, 0}), contour::MakeLine({10, 0}, {0, 10}),
                 contour::MakeLine({0, 10}, {0, 0})},
                "contour 1");
}

TEST(MillProgram, ExpandsAContour) {
  const auto texts =
      MillPrograms(MillFrom(kPlain), std::vector{Triangle()}, {.name = "my board-1"});
  ASSERT_TRUE(texts) << texts.error().message;
  EXPECT_THAT(*texts, ElementsAre("start my_board_1 1\nto 0.0 0.0 2\nline 10.0 0.0 3\n"
                                  "line 0.0 10.0 4\nline 0.0 0.0 5\nup 0.0 0.0 6\n"
                                  "end 7\n"));
}

// A speed is written where it changes, the tool rests at both ends, and a part that goes
// on begins with the speed of the work.
TEST(MillProgram, WritesTheSpeedsOfMoves) {
  const std::string slow =
      "#number SPEED decimals=0\n#fragment speed\nF@SPEED@\n#fragment rest\nrest\n" +
      std::string(kPlain);
  ToolPath path = Triangle();
  path.moves[1].speed_mm_s = 3;
  path.moves[2].speed_mm_s = 3;
  const auto texts = MillPrograms(MillFrom(slow), std::vector{path, Triangle()},
                                  {.name = "a", .speed_mm_s = 5});
  ASSERT_TRUE(texts) << texts.error().message;
  EXPECT_THAT(*texts, ElementsAre("start a 1\nto 0.0 0.0 2\nrest\nline 10.0 0.0 3\nF3\n"
                                  "line 0.0 10.0 4\nline 0.0 0.0 5\nrest\nup 0.0 0.0 6\n"
                                  "to 0.0 0.0 7\nline 10.0 0.0 8\nline 0.0 10.0 9\n"
                                  "line 0.0 0.0 10\nup 0.0 0.0 11\nend 12\n"));
  const auto refused = MillPrograms(MillFrom(kPlain), std::vector{path}, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("'speed' and 'rest'"));

  MillOptions parts;
  parts.max_bytes = 200;
  ToolPath longer = path;
  for (int i = 0; i < 4; ++i)
    longer.moves.insert(longer.moves.end(), path.moves.begin() + 1, path.moves.end());
  const auto divided = MillPrograms(MillFrom(slow), std::vector{longer}, {}, parts);
  ASSERT_TRUE(divided) << divided.error().message;
  ASSERT_GT(divided->size(), 1U);
  for (const std::string& text : *divided) {
    EXPECT_LE(text.size(), 200U);
    EXPECT_THAT(text, HasSubstr("F3\n"));
  }
}

TEST(MillProgram, RefusesNamesThatTheControllerDoesNotTake) {
  const Template program = fixture::SuppliedMill("krl");
  const std::string name(24, 'n');
  EXPECT_TRUE(MillPrograms(program, std::vector{Triangle()}, {.name = name}));
  const auto refused =
      MillPrograms(program, std::vector{Triangle()}, {.name = name + "n"});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("has 25 characters"));
  // Parts have longer names.
  MillOptions parts;
  parts.max_bytes = 800;
  EXPECT_FALSE(MillPrograms(program, std::vector<ToolPath>(20, Triangle()),
                            {.name = name}, parts));
}

TEST(MillProgram, SubtractsTheOrigin) {
  const std::string shifted = "#origin-x 100\n#origin-y -1\n" + std::string(kPlain);
  MillOptions options;
  options.origin_mm = {0.5, 0};
  const auto texts =
      MillPrograms(MillFrom(shifted), std::vector{Triangle()}, {}, options);
  ASSERT_TRUE(texts);
  EXPECT_THAT(texts->front(), HasSubstr("line -90.5 1.0"));
}

TEST(MillProgram, AnArcHasTheVariablesOfItsGeometry) {
  const Template program = MillFrom(
      "#number X Y AX AY I J R CR P decimals=4\n#fragment approach\n@X@ @Y@\n"
      "#fragment line\n@X@ @Y@\n"
      "#fragment arc-clockwise\ncw @X@ @Y@ @AX@ @AY@ @I@ @J@ @R@ @CR@ @P@\n"
      "#fragment arc-counterclockwise\nccw @X@ @Y@ @AX@ @AY@ @I@ @J@ @R@ @CR@ @P@\n"
      "#fragment retract\nup\n");
  // A quarter to the left about (0, 0), then three quarters to the right about (0, 4).
  const ToolPath path = PathOf({contour::MakeArcBetween({2, 0}, {0, 2}, {0, 0}, true),
                                contour::MakeArcBetween({0, 2}, {2, 4}, {0, 4}, false)},
                               "a");
  const auto texts = MillPrograms(program, std::vector{path}, {});
  ASSERT_TRUE(texts);
  EXPECT_EQ(texts->front(),
            "2.0000 0.0000\n"
            "ccw 0.0000 2.0000 1.4142 1.4142 -2.0000 0.0000 2.0000 2.0000 90.0000\n"
            "cw 2.0000 4.0000 -1.4142 5.4142 0.0000 2.0000 2.0000 -2.0000 270.0000\n"
            "up\n");
}

TEST(MillProgram, ACircleBecomesTwoArcs) {
  const ToolPath path =
      PathOf({contour::MakeArc({1, 1}, 3, 0.3, 2 * std::numbers::pi)}, "a");
  ASSERT_EQ(path.moves.size(), 2U);
  EXPECT_NEAR(path.moves[0].sweep_rad, std::numbers::pi, 1e-12);
  EXPECT_LT((path.moves[1].end_mm - path.begin_mm).norm(), 1e-12);
  EXPECT_NEAR((path.moves[0].end_mm - path.begin_mm).norm(), 6, 1e-12);
}

// Against places of the arc, sampled: the distance of each from the chords.
TEST(MillProgram, ChordsKeepTheirTolerance) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> number(0.02, 6);
  for (int round = 0; round < 50; ++round) {
    const double radius = number(random), sweep = number(random), tolerance = 0.005;
    const contour::Edge arc =
        contour::MakeArc({1, 2}, radius, number(random), round % 2 ? sweep : -sweep);
    const contour::Edges chords = EdgesOf(PathOf({arc}, "a", tolerance));
    double worst = 0;
    for (int k = 0; k <= 2000; ++k) {
      const Vec2 place = contour::PointAt(arc, arc.length_mm * k / 2000);
      double nearest = 1e9;
      for (const contour::Edge& chord : chords)
        nearest = std::min(nearest, contour::DistanceTo(chord, place));
      worst = std::max(worst, nearest);
    }
    EXPECT_LE(worst, tolerance * (1 + 1e-9));
    if (chords.size() > 3) {
      EXPECT_GT(worst, 0.2 * tolerance) << "more chords than needed";
    }
    EXPECT_LT((chords.back().end_mm - arc.end_mm).norm(), 1e-12);
  }
}

TEST(MillProgram, RepeatsEachContourDeeper) {
  const Template program = MillFrom(
      "#number DEPTH decimals=2\n#fragment approach\n@X@ @Y@ @DEPTH@\n"
      "#fragment line\n@X@ @Y@\n#fragment retract\nup\n");
  const auto texts =
      MillPrograms(program, std::vector{Triangle()}, {.depths_mm = {-0.5, -1, -1.5}});
  ASSERT_TRUE(texts);
  for (const char* depth : {"-0.50\n", "-1.00\n", "-1.50\n"}) {
    EXPECT_THAT(texts->front(), HasSubstr("0.000 0.000 " + std::string(depth)));
  }
  const auto refused = MillPrograms(fixture::SuppliedMill("krl"), std::vector{Triangle()},
                                    {.depths_mm = {-0.5, -1}});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("fragment 'start' alone uses @DEPTH@"));
}

TEST(MillProgram, WhatIsGivenIsNotLost) {
  const auto lost =
      MillPrograms(MillFrom(kPlain), std::vector{Triangle()}, {.given = {"SPEED"}});
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().message,
            "a.post: no fragment uses @SPEED@, which is given and would be lost; do not "
            "give it, or choose or write a template that uses it");
  const auto dark =
      MillPrograms(fixture::SuppliedMill("grbl-laser"), std::vector{Triangle()}, {});
  ASSERT_FALSE(dark);
  EXPECT_THAT(dark.error().message, HasSubstr("uses @POWER@; give the power"));
}

/// Every part is a program within the limit; together they make the same moves.
TEST(MillProgram, DividesLongProgramsForSmallMemories) {
  std::vector<ToolPath> paths(5, Triangle());
  contour::Edges way;
  for (int i = 0; i < 40; ++i) way.push_back(contour::MakeLine({i, 0}, {i + 1, 0}));
  paths.push_back(PathOf(way, "contour 6"));
  MillOptions options;
  options.max_bytes = 200;
  const auto texts = MillPrograms(MillFrom(kPlain), paths, {.name = "board"}, options);
  ASSERT_TRUE(texts) << texts.error().message;
  ASSERT_GT(texts->size(), 5U);
  std::multiset<std::string> moves;
  for (std::size_t k = 0; k < texts->size(); ++k) {
    const std::string& text = (*texts)[k];
    EXPECT_LE(text.size(), 200U);
    const std::string name = k == 0 ? "board" : "board_" + std::to_string(k + 1);
    EXPECT_TRUE(text.starts_with("start " + name + " 1\nto ")) << text;
    EXPECT_THAT(text, HasSubstr("\nend "));
    std::istringstream lines(text);
    std::string up;
    for (std::string line; std::getline(lines, line);) {
      if (line.starts_with("line")) moves.insert(line.substr(0, line.rfind(' ')));
    }
  }
  EXPECT_EQ(moves.size(), 5 * 3 + 40U);
  EXPECT_EQ(moves.count("line 10.0 0.0"), 6U);
  // Contours that fit in a program are whole: none begins in the middle of a triangle.
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_THAT((*texts)[k], HasSubstr("\nto 0.0 0.0 2\nline 10.0 0.0 3"));
  options.max_bytes = 60;
  const auto small = MillPrograms(MillFrom(kPlain), paths, {}, options);
  ASSERT_FALSE(small);
  EXPECT_THAT(small.error().message, HasSubstr("holds not even one move of contour 1"));
}

TEST(MillProgram, NamesFileAndFaultOfATemplate) {
  EXPECT_EQ(
      MillErrorOf("#fragment approach\n@X@ @Y@ @Q@\n"),
      "a.post: line 2: unknown variable @Q@; fragment 'approach' has NAME, N, SPEED, "
      "TRAVEL, PLUNGE, DEPTH, SAFE, POWER, DIAMETER, X, Y");
  EXPECT_EQ(MillErrorOf("#fragment approach\n@X@ @Y@\n#fragment line\n@X@\n"
                        "#fragment retract\nup\n"),
            "a.post: line 6: fragment 'line' does not use @Y@, which would be lost");
  EXPECT_EQ(MillErrorOf("#fragment approach\n@X@ @Y@\n#fragment line\n@AX@\n"),
            "a.post: line 4: unknown variable @AX@; fragment 'line' has NAME, N, SPEED, "
            "TRAVEL, PLUNGE, DEPTH, SAFE, POWER, DIAMETER, X, Y");
  const std::string lines =
      "#fragment approach\n@X@ @Y@\n#fragment line\n@X@ @Y@\n#fragment retract\nup\n";
  EXPECT_THAT(MillErrorOf(lines + "#fragment arc-clockwise\n@X@ @Y@ @CR@\n"),
              HasSubstr("'arc-clockwise' is given and its counterpart"));
  EXPECT_THAT(MillErrorOf(lines + "#fragment arc-clockwise\n@X@ @Y@ @R@\n"
                                  "#fragment arc-counterclockwise\n@X@ @Y@ @CR@\n"),
              HasSubstr("'arc-clockwise' does not determine an arc"));
}

// The axis speed against the angle of the place, sampled finely along the edge.
TEST(MillProgram, AxisSpeedIsThatOfTheAngle) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> number(-3, 3);
  for (int round = 0; round < 200; ++round) {
    const contour::Edge edge = round % 2 == 0
                                   ? contour::MakeLine({number(random), number(random)},
                                                       {number(random), number(random)})
                                   : contour::MakeArc({number(random), number(random)},
                                                      0.1 + std::abs(number(random)),
                                                      number(random), 2 * number(random));
    const int count = 20000;
    double sampled = 0, nearest = 1e9;
    for (int k = 0; k < count; ++k) {
      const Vec2 a = contour::PointAt(edge, edge.length_mm * k / count);
      const Vec2 b = contour::PointAt(edge, edge.length_mm * (k + 1) / count);
      nearest = std::min(nearest, a.norm());
      const double angle = std::atan2(contour::Cross(a, b), a.dot(b));
      sampled = std::max(sampled, std::abs(angle) * 2.5 / (edge.length_mm / count));
    }
    if (nearest < 0.05) continue;  // the samples are too far apart there
    EXPECT_NEAR(AxisSpeed_rad_s(edge, 2.5), sampled, 2e-3 * sampled) << round;
  }
}

TEST(MillProgram, TheLatheNamesTheContourItCannotFollow) {
  // Siwiec 2016: 2.5 mm/s at 0.2 mm need 716 deg/s, at 80 mm 1.8.
  const ToolPath near = PathOf({contour::MakeLine({-1, 0.2}, {1, 0.2})}, "contour 2");
  const ToolPath far = PathOf({contour::MakeLine({-1, 80}, {1, 80})}, "contour 1");
  EXPECT_NEAR(AxisSpeed_rad_s(EdgesOf(near)[0], 2.5) * 180 / std::numbers::pi, 716.2,
              0.1);
  EXPECT_NEAR(AxisSpeed_rad_s(EdgesOf(far)[0], 2.5) * 180 / std::numbers::pi, 1.79, 0.01);
  EXPECT_TRUE(std::isinf(AxisSpeed_rad_s(contour::MakeLine({-1, 0}, {1, 0}), 2.5)));
  const std::vector<ToolPath> both = {far, near};
  EXPECT_TRUE(RequireReachableOnLathe(both, {0, 0}, 2.5, 720));
  const Status status = RequireReachableOnLathe(both, {0, 0}, 2.5, 700);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message,
            "contour 2 passes the turning axis at 0.2 mm, which needs 716.2 deg/s at 2.5 "
            "mm/s, and the axis has 700; reduce the speed to 2.44 mm/s, or move the work "
            "away from the axis");
  // The supplied template has its axis at -80: the same contour there is refused.
  const ToolPath moved = PathOf({contour::MakeLine({-81, 0.2}, {-79, 0.2})}, "contour 9");
  const auto texts = MillPrograms(fixture::SuppliedMill("sinumerik"), std::vector{moved},
                                  {.speed_mm_s = 2.5});
  ASSERT_FALSE(texts);
  EXPECT_THAT(texts.error().message,
              HasSubstr("contour 9 passes the turning axis at 0.2"));
}

TEST(MillProgram, SuppliedTemplatesAreGood) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(
           std::filesystem::path(INTAGLIO_SOURCE_DIR) / "deploy/post/mill")) {
    const Template program = fixture::SuppliedMill(entry.path().stem().string());
    EXPECT_FALSE(program.extension.empty()) << entry.path();
    Cutting cutting;
    if (entry.path().stem() == "grbl-laser") cutting.power_ratio = 0.5;
    const auto texts = MillPrograms(program, std::vector{Triangle()}, cutting);
    ASSERT_TRUE(texts) << texts.error().message;
    EXPECT_GT(texts->front().size(), 60U);
    ++count;
  }
  EXPECT_EQ(count, 7);
}

TEST(DrillProgram, ChangesTheToolOrBeginsAnotherProgram) {
  const std::vector<DrillRound> rounds = {{0.8, {{1, 2}, {3, 4}}}, {1.2, {{5, 6}}}};
  const auto one = DrillPrograms(fixture::SuppliedDrill("linuxcnc"), rounds,
                                 {.name = "b", .depths_mm = {-1.6}});
  ASSERT_TRUE(one) << one.error().message;
  ASSERT_EQ(one->size(), 1U);
  EXPECT_THAT(one->front(), HasSubstr("(drill of 1.200 mm)\nT2 M6"));
  EXPECT_THAT(one->front(), HasSubstr("G81 X5.00000 Y6.00000 Z-1.6000 R2.0000"));
  const auto two = DrillPrograms(fixture::SuppliedDrill("grbl"), rounds, {.name = "b"});
  ASSERT_TRUE(two);
  ASSERT_EQ(two->size(), 2U);
  EXPECT_THAT((*two)[0], HasSubstr("; b, drill of 0.800 mm"));
  EXPECT_THAT((*two)[1], HasSubstr("; b_2, drill of 1.200 mm"));
  EXPECT_THAT((*two)[1], HasSubstr("G0 X5.0000 Y6.0000"));
  const auto small =
      DrillPrograms(fixture::SuppliedDrill("grbl"), rounds, {}, {0, 0}, 100);
  ASSERT_FALSE(small);
  EXPECT_THAT(small.error().message, HasSubstr("holds not even one hole"));
}

}  // namespace
}  // namespace intaglio::post
