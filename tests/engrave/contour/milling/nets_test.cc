#include "engrave/contour/milling/nets.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "tests/engrave/contour/boards.h"

namespace intaglio::contour {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

Region BoardBetween(const Vec2& a, const Vec2& b) {
  const auto region =
      RegionOfLoops({{MakeLine(a, {b.x(), a.y()}), MakeLine({b.x(), a.y()}, b),
                      MakeLine(b, {a.x(), b.y()}), MakeLine({a.x(), b.y()}, a)}});
  EXPECT_TRUE(region);
  return *region;
}

std::vector<Element> ElementsOf(const std::vector<NetElement>& drawn) {
  std::vector<Element> elements;
  for (const NetElement& element : drawn) elements.push_back(element.element);
  return elements;
}

Region DrawnCopper(const std::vector<NetElement>& drawn) {
  const auto united = Unite(ElementsOf(drawn));
  EXPECT_TRUE(united) << united.error().message;
  return united ? RegionOf(*united) : Region{};
}

NetReport Compared(const std::vector<Region>& copper,
                   const std::vector<NetElement>& drawn) {
  const auto report = CompareNets(copper, drawn);
  EXPECT_TRUE(report) << report.error().message;
  return report ? *report : NetReport{};
}

/// Two pads of A with a track, two of B with a track beside it.
std::vector<NetElement> TwoNets() {
  return {{{Circle{{0, 0}, 2}, "R1-1"}, "A"},
          {{Circle{{10, 0}, 2}, "R2-1"}, "A"},
          {{Track{{0, 0}, {10, 0}, 0.5}, ""}, "A", false},
          {{Square{{0, 5}, 2}, "R1-2"}, "B"},
          {{Square{{10, 5}, 2}, "R2-2"}, "B"},
          {{Track{{0, 5}, {10, 5}, 0.5}, ""}, "B", false}};
}

TEST(Nets, OfTheDrawingAreIslands) {
  const auto drawn = TwoNets();
  const NetReport report = Compared({DrawnCopper(drawn)}, drawn);
  EXPECT_EQ(report.island_count, 2U);
  EXPECT_EQ(report.net_count, 2U);
  EXPECT_EQ(report.idle_count, 0U);
  EXPECT_THAT(report.faults, IsEmpty());
}

TEST(Nets, AShortIsFoundWhereTheNetsAreNearest) {
  auto drawn = TwoNets();
  // A bridge of solder from track to track at x = 4.
  std::vector<Element> copper = ElementsOf(drawn);
  copper.push_back({Track{{4, 0}, {4, 5}, 0.3}, ""});
  // The pads' sides are nearer to each other: 5 - 1 - 1 at x = 0.
  const NetReport bridged = Compared({RegionOf(*Unite(copper))}, drawn);
  ASSERT_EQ(bridged.faults.size(), 1U);
  EXPECT_EQ(bridged.faults[0].kind, FaultKind::kShort);
  EXPECT_EQ(bridged.faults[0].net, "A");
  EXPECT_EQ(bridged.faults[0].other_net, "B");
  EXPECT_THAT(bridged.faults[0].sentence, HasSubstr("nets A and B are connected near"));
  // A track of B that runs into A: there they touch.
  drawn.push_back({{Track{{7, 5}, {7, 0.1}, 0.3}, ""}, "B", false});
  const NetReport report = Compared({DrawnCopper(drawn)}, drawn);
  EXPECT_EQ(report.net_count, 1U);
  ASSERT_EQ(report.faults.size(), 1U);
  EXPECT_LT((report.faults[0].place_mm - Vec2(7, 0.1)).norm(), 0.4);
}

TEST(Nets, AnOpenIsFoundInTheGap) {
  auto drawn = TwoNets();
  drawn[2].element.shape = Track{{0, 0}, {6, 0}, 0.5};
  drawn.push_back({{Track{{7, 0}, {10, 0}, 0.5}, ""}, "A", false});
  const NetReport report = Compared({DrawnCopper(drawn)}, drawn);
  EXPECT_EQ(report.island_count, 3U);
  ASSERT_EQ(report.faults.size(), 1U);
  EXPECT_EQ(report.faults[0].kind, FaultKind::kOpen);
  EXPECT_EQ(report.faults[0].net, "A");
  EXPECT_LT((report.faults[0].place_mm - Vec2(6.5, 0)).norm(), 1e-6);
  EXPECT_THAT(report.faults[0].sentence, HasSubstr("net A is open near (6.5, 0)"));
}

TEST(Nets, TerminalsWithoutCopperAreLost) {
  auto drawn = TwoNets();
  const Region copper = DrawnCopper(drawn);
  drawn.push_back({{Circle{{30, 30}, 1}, "J1"}, "A"});
  const NetReport report = Compared({copper}, drawn);
  ASSERT_EQ(report.faults.size(), 1U);
  EXPECT_EQ(report.faults[0].kind, FaultKind::kLost);
  EXPECT_THAT(report.faults[0].sentence,
              HasSubstr("J1 of net A has no copper at (30, 30)"));
}

TEST(Nets, ViasConnectLayers) {
  std::vector<NetElement> drawn{{{Circle{{0, 0}, 2}, "P1"}, "A", true, 1},
                                {{Circle{{10, 0}, 2}, "P2"}, "A", true, 2},
                                {{Track{{0, 0}, {5, 0}, 0.5}, ""}, "A", false, 1},
                                {{Track{{5, 0}, {10, 0}, 0.5}, ""}, "A", false, 2}};
  const auto copper = [&] {
    std::vector<Region> layers;
    for (const std::uint32_t bit : {1U, 2U}) {
      std::vector<Element> elements;
      for (const NetElement& e : drawn)
        if ((e.layers & bit) != 0) elements.push_back(e.element);
      layers.push_back(RegionOf(*Unite(elements)));
    }
    return layers;
  };
  const NetReport open = Compared(copper(), drawn);
  EXPECT_EQ(open.net_count, 2U);
  EXPECT_EQ(open.faults.size(), 1U);
  drawn.push_back({{Circle{{5, 0}, 0.8}, "via"}, "A", true, 3});
  const NetReport whole = Compared(copper(), drawn);
  EXPECT_EQ(whole.island_count, 2U);
  EXPECT_EQ(whole.net_count, 1U);
  EXPECT_THAT(whole.faults, IsEmpty());
}

TEST(Nets, AnnularPadsHaveTheirCopperAtTheBorder) {
  const std::vector<NetElement> drawn{{{Circle{{0, 0}, 2}, "P1"}, "A"}};
  const auto ring =
      Difference(DrawnCopper(drawn), {{{MakeArc({0, 0}, 0.5, 0, 6.2831853071795862)}}});
  ASSERT_TRUE(ring);
  EXPECT_THAT(Compared({*ring}, drawn).faults, IsEmpty());
}

// On a sheet wholly of copper the tool leaves the nets, and the rest around them. The
// groups of the union, which know nothing of regions, are the oracle.
TEST(Nets, OfAnIsolatedBoardAreThoseThatWereDrawn) {
  int proved = 0;
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto elements = test::MakeBoard({25, seed, seed % 2 == 0});
    const auto united = Unite(elements, {0, Corners::kRound});
    ASSERT_TRUE(united);
    std::vector<NetElement> drawn;
    for (std::size_t k = 0; k < elements.size(); ++k)
      drawn.push_back({elements[k], "N" + std::to_string(united->groups[k])});
    for (const int passes : {1, 3}) {
      const auto isolation = Isolate(elements, {0.1, passes});
      if (!isolation) continue;  // nets nearer than the tool, named
      const auto copper = CopperLeft(BoardBetween({-5, -5}, {20, 20}), *isolation, 0.1);
      ASSERT_TRUE(copper) << copper.error().message;
      const NetReport report = Compared({*copper}, drawn);
      EXPECT_THAT(report.faults, IsEmpty());
      EXPECT_EQ(report.net_count, united->group_count);
      EXPECT_GE(report.idle_count, 1U);
      ++proved;
    }
  }
  EXPECT_GE(proved, 10);
}

// A pass left out: the nets around that contour are one with the sheet.
TEST(Nets, AContourThatIsNotMilledIsAShort) {
  const auto drawn = TwoNets();
  auto isolation = Isolate(ElementsOf(drawn), {0.2});
  ASSERT_TRUE(isolation);
  const Region board = BoardBetween({-5, -5}, {20, 20});
  auto& contours = isolation->passes[0].contours;
  ASSERT_EQ(contours.size(), 2U);
  contours.pop_back();
  const auto half = CopperLeft(board, *isolation, 0.2);
  ASSERT_TRUE(half);
  EXPECT_THAT(Compared({*half}, drawn).faults,
              IsEmpty());  // B is one with the sheet alone
  EXPECT_EQ(Compared({*half}, drawn).idle_count, 0U);
  contours.clear();
  const auto none = CopperLeft(board, *isolation, 0.2);
  ASSERT_TRUE(none);
  EXPECT_EQ(Compared({*none}, drawn).faults.size(), 1U);
}

TEST(Nets, RefuseLayersThatDoNotExist) {
  const std::vector<NetElement> drawn{{{Circle{{0, 0}, 2}, "P1"}, "A", true, 4}};
  const auto report = CompareNets(std::vector<Region>(2), drawn);
  ASSERT_FALSE(report);
  EXPECT_THAT(report.error().message,
              HasSubstr("a layer that does not exist: there are 2"));
}

}  // namespace
}  // namespace intaglio::contour
