// Tabs in programs: what the moves of a program, as LinuxCNC's rs274 and we read them,
// leave of the sheet.

#include "engrave/post/tab_parts.h"

#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "engrave/contour/milling/cut.h"
#include "engrave/post/mill_program.h"
#include "tests/engrave/post/judge_programs.h"
#include "tests/engrave/post/supplied_templates.h"

namespace intaglio::post {
namespace {

constexpr double kToolMm = 2, kTabMm = 3;

/// A plate of 40 x 20 mm cut out of a sheet, with four tabs.
struct TabbedPlate {
  std::vector<ToolPath> paths;
  std::vector<Vec2> tabs_mm;
};

TabbedPlate MakeTabbedPlate() {
  const contour::Region plate{
      {{contour::MakeLine({0, 0}, {40, 0}), contour::MakeLine({40, 0}, {40, 20}),
        contour::MakeLine({40, 20}, {0, 20}), contour::MakeLine({0, 20}, {0, 0})}}};
  contour::CutOptions options;
  options.tool_diameter_mm = kToolMm;
  options.tabs.count = 4;
  options.tabs.width_mm = kTabMm;
  options.lead = contour::LeadKind::kArc;
  const auto cuts = contour::CutOut(plate, options);
  EXPECT_TRUE(cuts) << cuts.error().message;
  TabbedPlate made;
  for (const contour::Cut& cut : *cuts) {
    std::vector<bool> tabs(cut.lead_in.size(), false);
    for (const contour::CutPiece& piece : cut.pieces) tabs.push_back(piece.tab);
    tabs.resize(tabs.size() + cut.lead_out.size(), false);
    made.paths.push_back(PathOf(contour::PathOf(cut), "plate", 0, tabs));
    made.tabs_mm.insert(made.tabs_mm.end(), cut.tabs_mm.begin(), cut.tabs_mm.end());
  }
  return made;
}

struct DeepMove {
  contour::Edge edge;
  double z_mm = 0;
};

/// The moves in the plane below the surface, as rs274 prints them.
std::vector<DeepMove> MovesOfRs274(const std::string& canon) {
  static const std::regex kNumber(R"(-?\d+\.?\d*)");
  std::vector<DeepMove> moves;
  Vec2 at = Vec2::Zero();
  std::istringstream lines(canon);
  for (std::string line; std::getline(lines, line);) {
    const auto begin = line.find('(');
    if (begin == std::string::npos) continue;
    std::vector<double> n;
    for (std::sregex_iterator
             i(line.begin() + static_cast<long>(begin), line.end(), kNumber),
         end;
         i != end; ++i)
      n.push_back(std::stod(i->str()));
    const bool line_feed = line.find("STRAIGHT_FEED") != std::string::npos;
    const bool arc_feed = line.find("ARC_FEED") != std::string::npos;
    if (!line_feed && !arc_feed && line.find("STRAIGHT_TRAVERSE") == std::string::npos)
      continue;
    const Vec2 to(n[0], n[1]);
    if (line_feed && to != at) moves.push_back({contour::MakeLine(at, to), n[2]});
    if (arc_feed)
      moves.push_back({contour::MakeArcBetween(at, to, {n[2], n[3]}, n[4] > 0), n[5]});
    at = to;
  }
  return moves;
}

double DeepestAt(const std::vector<DeepMove>& moves, const Vec2& place) {
  double deepest = 0;
  for (const DeepMove& move : moves) {
    if (contour::DistanceTo(move.edge, place) < 1e-3)
      deepest = std::min(deepest, move.z_mm);
  }
  return deepest;
}

/// No move below the tabs' top touches a tab; all else of the path is cut through.
void ExpectTabsLeft(const TabbedPlate& plate, const std::vector<DeepMove>& moves,
                    double top_mm, double bottom_mm) {
  ASSERT_EQ(plate.tabs_mm.size(), 4U);
  for (const Vec2& tab : plate.tabs_mm) {
    EXPECT_NEAR(DeepestAt(moves, tab), top_mm, 1e-9);
    for (const DeepMove& move : moves) {
      if (move.z_mm > top_mm - 1e-6) continue;
      EXPECT_GT(contour::DistanceTo(move.edge, tab), (kTabMm + kToolMm) / 2 - 1e-3);
    }
  }
  for (const ToolPath& path : plate.paths) {
    for (const contour::Edge& edge : EdgesOf(path)) {
      for (double way = 0; way <= edge.length_mm; way += 0.1) {
        const Vec2 place = contour::PointAt(edge, way);
        double to_tab = 1e9;
        for (const Vec2& tab : plate.tabs_mm)
          to_tab = std::min(to_tab, (place - tab).norm());
        if (to_tab < (kTabMm + kToolMm) / 2 + 1e-3) continue;
        EXPECT_NEAR(DeepestAt(moves, place), bottom_mm, 1e-9);
      }
    }
  }
}

// The top between passes, at one, above the first, and at the surface.
TEST(TabParts, Rs274LeavesTheTabsAndCutsAllElse) {
  if (!fixture::IsInstalled("rs274"))
    GTEST_SKIP() << "no rs274: install the package linuxcnc-uspace";
  const TabbedPlate plate = MakeTabbedPlate();
  const auto file = intaglio::test::FreshFolder() / "plate.ngc";
  for (const double top_mm : {-2.5, -2.0, -0.4, 0.0}) {
    SCOPED_TRACE(top_mm);
    Cutting cutting;
    cutting.depths_mm = {-1, -2, -3};
    cutting.tab_top_mm = top_mm;
    const auto texts =
        MillPrograms(fixture::SuppliedMill("linuxcnc"), plate.paths, cutting);
    ASSERT_TRUE(texts) << texts.error().message;
    std::ofstream(file) << texts->front();
    const std::string canon = fixture::OutputOf("rs274 -g " + file.string());
    ASSERT_NE(canon.find("PROGRAM_END"), std::string::npos);
    ExpectTabsLeft(plate, MovesOfRs274(canon), top_mm, -3);
  }
}

// The same of the parts themselves, and how often each is made.
TEST(TabParts, OfEachPassAreTheWholeOrThePiecesBetweenTabs) {
  const TabbedPlate plate = MakeTabbedPlate();
  const ToolPath& path = plate.paths[0];
  Cutting cutting;
  cutting.depths_mm = {-1, -2, -3};
  for (const double top_mm : {-2.5, -2.0, -0.4, 0.0}) {
    SCOPED_TRACE(top_mm);
    cutting.tab_top_mm = top_mm;
    std::vector<DeepMove> moves;
    std::vector<std::size_t> counts;
    for (std::size_t pass = 0; pass < 3; ++pass) {
      const auto parts = PartsOfPass(path, cutting, pass);
      counts.push_back(parts.size());
      for (const PathPart& part : parts) {
        for (const contour::Edge& edge : EdgesOf(part.path))
          moves.push_back({edge, part.depth_mm});
      }
    }
    ExpectTabsLeft(plate, moves, top_mm, -3);
    // Five pieces between four tabs, nine with them.
    const std::vector<std::size_t> expected =
        top_mm == -2.5   ? std::vector<std::size_t>{1, 1, 9}
        : top_mm == -2.0 ? std::vector<std::size_t>{1, 1, 5}
        : top_mm == -0.4 ? std::vector<std::size_t>{9, 5, 5}
                         : std::vector<std::size_t>{5, 5, 5};
    EXPECT_EQ(counts, expected);
  }
}

TEST(TabParts, ALaserIsOffAtTabsInEveryPass) {
  const TabbedPlate plate = MakeTabbedPlate();
  Cutting cutting;
  cutting.depths_mm = {0, 0};
  cutting.power_ratio = 0.5;
  double length_mm = 0;
  for (std::size_t pass = 0; pass < 2; ++pass) {
    const auto parts = PartsOfPass(plate.paths[0], cutting, pass);
    EXPECT_EQ(parts.size(), 5U);
    for (const PathPart& part : parts) length_mm += contour::LengthOf(EdgesOf(part.path));
  }
  const double whole_mm = contour::LengthOf(EdgesOf(plate.paths[0]));
  EXPECT_NEAR(length_mm, 2 * (whole_mm - 4 * (kTabMm + kToolMm)), 1e-6);
  const auto program =
      MillPrograms(fixture::SuppliedMill("grbl-laser"), plate.paths, cutting);
  EXPECT_TRUE(program) << program.error().message;
}

TEST(TabParts, ChordsKeepTheTabs) {
  const TabbedPlate plate = MakeTabbedPlate();
  const auto tab_mm = [](const ToolPath& path) {
    double sum_mm = 0;
    Vec2 at_mm = path.begin_mm;
    for (const WorkMove& move : path.moves) {
      if (move.tab) sum_mm += (move.end_mm - at_mm).norm();
      at_mm = move.end_mm;
    }
    return sum_mm;
  };
  EXPECT_NEAR(tab_mm(Chorded(plate.paths[0], 0.001)), 4 * (kTabMm + kToolMm), 1e-9);
}

TEST(TabParts, ATemplateWithoutDepthIsRefused) {
  const TabbedPlate plate = MakeTabbedPlate();
  Cutting cutting;
  cutting.depths_mm = {-1};
  cutting.tab_top_mm = -0.5;
  const auto program = MillPrograms(fixture::SuppliedMill("hpgl"), plate.paths, cutting);
  ASSERT_FALSE(program);
  EXPECT_NE(program.error().message.find("without tabs"), std::string::npos)
      << program.error().message;
}

}  // namespace
}  // namespace intaglio::post
