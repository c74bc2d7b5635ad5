#include "engrave/contour/union.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>

#include "tests/engrave/contour/boards.h"
#include "tests/engrave/contour/covered_area.h"
#include "tests/engrave/contour/tables.h"

namespace intaglio::contour {
namespace {

using std::numbers::pi;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Union United(const std::vector<Element>& elements, double radius_mm = 0,
             Corners corners = Corners::kSharp) {
  auto united = Unite(elements, {radius_mm, corners});
  EXPECT_TRUE(united) << united.error().message;
  return united ? *united : Union{};
}

std::string Refused(const std::vector<Element>& elements, double radius_mm = 0) {
  const auto united = Unite(elements, {radius_mm});
  EXPECT_FALSE(united);
  return united ? "" : united.error().message;
}

std::vector<Vec2> VerticesOf(const Union& united) {
  std::vector<Vec2> vertices;
  for (const Contour& contour : united.contours) {
    for (const Edge& edge : contour.edges) vertices.push_back(edge.begin_mm);
  }
  return vertices;
}

double Nearest(const std::vector<Vec2>& vertices, const Vec2& place) {
  double nearest = 1e300;
  for (const Vec2& v : vertices) {
    nearest = std::min(nearest, (v - place).lpNorm<Eigen::Infinity>());
  }
  return nearest;
}

// The vertices that Siwiec 2016 prints in annexes B and D, with six decimals. Those of
// the frame are no better than 2e-5: its second contour ends that far from its start.
TEST(Union, HasThePublishedVertices) {
  const auto cases = test::Table("union_cases.csv");
  std::map<std::string, std::vector<Element>> elements;
  std::map<std::string, double> radius;
  for (const auto& row : cases.rows) {
    const auto number = [&](std::string_view name) {
      return test::NumberOf(cases, row, name);
    };
    const std::string& name = row.fields[0];
    elements[name].push_back(
        test::ElementOf(static_cast<int>(number("element")), {number("x"), number("y")},
                        {number("x2"), number("y2")}, number("size")));
    radius[name] = number("tool_radius");
  }
  std::map<std::string, std::vector<Vec2>> vertices;
  for (const auto& [name, list] : elements)
    vertices[name] = VerticesOf(United(list, radius[name]));
  const auto printed = test::Table("union_vertices.csv");
  ASSERT_EQ(printed.rows.size(), 31U);
  for (const auto& row : printed.rows) {
    const Vec2 place(test::NumberOf(printed, row, "x"),
                     test::NumberOf(printed, row, "y"));
    const double tolerance = row.fields[0] == "annex_b_frame" ? 2e-5 + 5e-7 : 1e-6;
    EXPECT_LT(Nearest(vertices[row.fields[0]], place), tolerance)
        << row.fields[0] << " " << place.transpose();
  }
}

TEST(Union, OfThePublishedFrameHasTwoContoursAndOfThePadOne) {
  const Vec2 k[4] = {{-.315007, 40.320212},
                     {50.321515, 40.319765},
                     {50.309955, -.319296},
                     {-.315806, -.319123}};
  std::vector<Element> frame;
  for (int i = 0; i < 4; ++i) frame.push_back({Track{k[i], k[(i + 1) % 4], 0.2}, {}});
  const Union united = United(frame, 0.1);
  ASSERT_EQ(united.contours.size(), 2U);
  EXPECT_EQ(united.contours[0].edges.size() + united.contours[1].edges.size(), 12U);
  EXPECT_NE(united.contours[0].inner, united.contours[1].inner);
  for (const Contour& contour : united.contours) {
    EXPECT_LT(AreaOf(Clockwise(contour)), 0);
    EXPECT_THAT(contour.elements, ElementsAre(0, 1, 2, 3));
  }
}

TEST(Union, OfElementsThatTouchOrCoincideIsRight) {
  const auto table = test::Table("union_degenerate.csv");
  ASSERT_EQ(table.rows.size(), 10U);
  for (const auto& row : table.rows) {
    const Union united = United(test::ElementsOf(row.fields[1]));
    // The table has nine decimals.
    EXPECT_NEAR(united.area_mm2, test::NumberOf(table, row, "area"), 1e-9)
        << row.fields[0];
    EXPECT_EQ(static_cast<double>(united.contours.size()),
              test::NumberOf(table, row, "contours"))
        << row.fields[0];
  }
}

TEST(Union, JoinsLinesAndArcs) {
  const auto edges = [](const std::string& text) {
    return United(test::ElementsOf(text)).contours.at(0).edges.size();
  };
  EXPECT_EQ(edges("4 155.575 114.3 161.29 114.3 1.27|4 161.29 114.3 167.64 114.3 1.27"),
            4U);
  EXPECT_EQ(edges("2 0 0 2|2 2 0 2"), 4U);
  EXPECT_EQ(edges("1 0 0 1|1 3 1 1|4 0 0 3 1 1"), 4U);
  EXPECT_EQ(edges("1 0 0 2|1 0 0 2"), 1U);
}

TEST(Union, GroupsElementsThatTouch) {
  const Union united =
      United(test::ElementsOf("1 0 0 2|1 5 0 2|4 0 0 0 3 0.4|1 7 0 2|1 0 0 0.5"));
  EXPECT_EQ(united.group_count, 2U);
  EXPECT_THAT(united.groups, ElementsAre(0, 1, 0, 1, 0));
}

TEST(Union, KeepsContoursConnectedEndToEnd) {
  for (const Contour& contour : United(test::MakeBoard({100, 3, true}), 0.1).contours) {
    for (std::size_t k = 0; k < contour.edges.size(); ++k) {
      const Edge& next = contour.edges[(k + 1) % contour.edges.size()];
      EXPECT_LT((contour.edges[k].end_mm - next.begin_mm).norm(), 1e-5);
    }
    EXPECT_EQ(contour.inner, contour.area_mm2 < 0);
  }
}

TEST(Union, GrowsFreeOutlinesWithRoundCorners) {
  // An L of 3 x 3 without its upper right 2 x 2.
  const std::vector<Vec2> corners = {{0, 0}, {3, 0}, {3, 1}, {1, 1}, {1, 3}, {0, 3}};
  Edges loop;
  for (std::size_t k = 0; k < corners.size(); ++k)
    loop.push_back(MakeLine(corners[k], corners[(k + 1) % corners.size()]));
  const Element l{Outline{{loop}}, "L"};
  EXPECT_NEAR(United({l}).area_mm2, 5, 1e-12);
  const double r = 0.25;
  // A band along the sides, quarters of discs at five corners; at the sixth the bands
  // overlap in a square.
  const Union grown = United({l}, r);
  EXPECT_NEAR(grown.area_mm2, 5 + 12 * r + 5 * pi * r * r / 4 - r * r, 1e-9);
  EXPECT_EQ(grown.contours.size(), 1U);
  EXPECT_EQ(grown.contours[0].edges.size(), 11U);
  std::reverse(loop.begin(), loop.end());
  for (Edge& edge : loop) edge = Reversed(edge);
  EXPECT_NEAR(United({{Outline{{loop}}, ""}}, r).area_mm2, grown.area_mm2, 1e-9);
}

TEST(Union, GrowsOutlinesWithHolesAndArcs) {
  // A ring of radii 2 and 1 with an island of radius 0.5.
  const auto circle = [](double radius) {
    return Edges{MakeArc({0, 0}, radius, 0, 2 * pi)};
  };
  const Element ring{Outline{{circle(2), circle(1), circle(0.5)}}, ""};
  EXPECT_NEAR(United({ring}).area_mm2, pi * (4 - 1 + 0.25), 1e-9);
  const Union grown = United({ring}, 0.1);
  EXPECT_NEAR(grown.area_mm2, pi * (2.1 * 2.1 - 0.9 * 0.9 + 0.6 * 0.6), 1e-9);
  EXPECT_EQ(grown.contours.size(), 3U);
  EXPECT_NEAR(United({ring}, 0.3).area_mm2, pi * 2.3 * 2.3, 1e-9);  // filled
}

// Round ends of one circle, of which a third track covers nearly half of the common part:
// it leaves the circle as a tangent there.
TEST(Union, OfTracksFromOneNodeIsProved) {
  const auto tracks = test::ElementsOf(
      "4 7.62 581.66 5.08 581.66 0.4|4 7.62 576.58 7.62 581.66 0.4|"
      "4 7.62 581.66 15.54 573.84 0.4");
  EXPECT_NEAR(United(tracks, 0.1).area_mm2, test::CoveredArea_mm2(tracks, 0.1), 1e-8);
}

TEST(Union, OfArcTracksIsThatOfTheirSweep) {
  const double sweep = 4;
  const Element bent{ArcTrack{MakeArc({1, 2}, 3, 0.5, sweep), 0.6}, ""};
  const Union united = United({bent}, 0.1);
  // Rounding its ends to 1 nm changes its radius and length by as much.
  EXPECT_NEAR(united.area_mm2, sweep * 3 * 0.8 + pi * 0.16, 5e-6);
  EXPECT_EQ(united.contours.size(), 1U);
  EXPECT_EQ(united.contours[0].edges.size(), 4U);
  const Element ring{ArcTrack{MakeArc({1, 2}, 3, 0.5, -2 * pi), 0.6}, ""};
  EXPECT_NEAR(United({ring}).area_mm2, 2 * pi * 3 * 0.6, 5e-6);
  // Wider than its radius: the disc of the outer arc, where it turns far enough.
  const Element wide{ArcTrack{MakeArc({1, 2}, 0.2, 0, 2 * pi), 0.6}, ""};
  EXPECT_NEAR(United({wide}).area_mm2, pi * 0.25, 1e-9);
}

// A full circle ends where it begins to the last bit: beside it, at the height of its
// ends, a point is outside.
TEST(Union, OfARingAndATrackAtTheHeightOfItsCentreIsProved) {
  const Edge circle = MakeArc({21, 9}, 2.5, 0, 2 * pi);
  EXPECT_EQ(circle.begin_mm, circle.end_mm);
  const Union united =
      United({{ArcTrack{circle, 6}, ""}, {Track{{16, 12}, {13, 12}, 6}, ""}});
  EXPECT_EQ(united.group_count, 1U);
}

TEST(Union, RoundCornersAreThoseOfTheTool) {
  const Union united = United(test::ElementsOf("2 0 0 2"), 0.5, Corners::kRound);
  EXPECT_NEAR(united.area_mm2, 4 + 8 * 0.5 + pi * 0.25, 1e-9);
  EXPECT_EQ(united.contours.at(0).edges.size(), 8U);
}

// Against the area by scan lines, which finds its breakpoints and intervals without any
// contour. Tracks that were rounded to 1 nm run along each other to 1e-7 mm, for some
// millimetres.
TEST(Union, HasTheAreaThatElementsCover) {
  for (const bool free_angles : {false, true}) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
      const auto board = test::MakeBoard({40, seed, free_angles});
      const auto rounded = Rounded(board);
      EXPECT_NEAR(United(board, 0.1).area_mm2, test::CoveredArea_mm2(*rounded, 0.1), 5e-7)
          << seed;
    }
  }
}

TEST(Union, IsTheSameEachTime) {
  const auto board = test::MakeBoard({200, 5, true});
  const Union a = United(board, 0.1);
  const Union b = United(board, 0.1);
  ASSERT_EQ(a.contours.size(), b.contours.size());
  EXPECT_EQ(a.area_mm2, b.area_mm2);
  EXPECT_EQ(VerticesOf(a), VerticesOf(b));
}

TEST(Union, RefusesWhatHasNoAreaAndNamesIt) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Refused({{Circle{{nan, 0}, 1}, "P1"}}), HasSubstr("P1"));
  EXPECT_THAT(Refused({{Circle{{2e4, 0}, 1}, "P2"}}), HasSubstr("P2"));
  EXPECT_THAT(Refused({{Square{{0, 0}, -1}, "P3"}}), HasSubstr("P3"));
  EXPECT_THAT(Refused({{Circle{{3, 4}, 0}, ""}}), HasSubstr("(3, 4)"));
  EXPECT_THAT(Refused({{Track{{0, 0}, {1, 0}, 0}, "T"}}), HasSubstr("thinner"));
  EXPECT_THAT(Refused({}, -1), HasSubstr("radius"));
  const Edges bow = {MakeLine({0, 0}, {1, 1}), MakeLine({1, 1}, {1, 0}),
                     MakeLine({1, 0}, {0, 1}), MakeLine({0, 1}, {0, 0})};
  EXPECT_THAT(Refused({{Outline{{bow}}, "bow"}}), HasSubstr("at (0.5, 0.5)"));
  const Edges open = {MakeLine({0, 0}, {1, 1}), MakeLine({1, 1}, {1, 0})};
  EXPECT_THAT(Refused({{Outline{{open}}, "o"}}), HasSubstr("open at (1, 0)"));
  EXPECT_THAT(Refused({{Outline{}, "e"}}), HasSubstr("no edges"));
}

TEST(Union, OfNothingIsEmpty) { EXPECT_TRUE(United({}).contours.empty()); }

TEST(Rounded, MergesNearNodes) {
  const std::vector<Element> elements = {{Circle{{1, 1}, 1}, ""},
                                         {Track{{1.00009, 1}, {5, 5.0000004}, 1}, ""},
                                         {Circle{{1.0002, 1}, 1}, ""}};
  const auto rounded = Rounded(elements);
  ASSERT_TRUE(rounded);
  EXPECT_EQ(std::get<Track>((*rounded)[1].shape).begin_mm, Vec2(1, 1));
  EXPECT_EQ(std::get<Track>((*rounded)[1].shape).end_mm, Vec2(5, 5));
  EXPECT_EQ(std::get<Circle>((*rounded)[2].shape).center_mm, Vec2(1.0002, 1));
}

}  // namespace
}  // namespace intaglio::contour
