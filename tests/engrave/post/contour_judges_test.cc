// LinuxCNC's rs274 and hp2xx judge the programs of contours and holes of twenty boards:
// they accept them, and trace the path that was planned, to 1 um.

#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <sstream>

#include "engrave/contour/contour_order.h"
#include "engrave/contour/union.h"
#include "tests/engrave/contour/boards.h"
#include "tests/engrave/post/judge_programs.h"
#include "tests/engrave/post/supplied_templates.h"

namespace intaglio::post {
namespace {

namespace fs = std::filesystem;
constexpr double kOneUm = 1e-3;
constexpr int kBoards = 20;

/// The contours of a board of 30 to 125 elements, in their order.
std::vector<ToolPath> PathsOfBoard(int number) {
  const auto board = contour::test::MakeBoard({.count = 30 + 5 * number,
                                               .seed = static_cast<unsigned>(number + 1),
                                               .free_angles = number % 2 == 1});
  const auto copper = contour::Unite(
      board,
      {0.1, number % 3 == 0 ? contour::Corners::kRound : contour::Corners::kSharp});
  EXPECT_TRUE(copper) << copper.error().message;
  std::vector<ToolPath> paths;
  for (const auto& visit : contour::NearestContours(copper->contours, Vec2::Zero())) {
    paths.push_back(
        PathOf(contour::EdgesFrom(copper->contours[visit.contour].edges, visit),
               "contour " + std::to_string(paths.size() + 1)));
  }
  return paths;
}

/// Edges of several paths; a new path begins with each approach.
using TracedPaths = std::vector<contour::Edges>;

/// What rs274 prints for moves below the surface.
TracedPaths TracedByRs274(const std::string& canon) {
  static const std::regex kNumber(R"(-?\d+\.?\d*)");
  TracedPaths paths;
  Vec2 at = Vec2::Zero();
  std::istringstream lines(canon);
  for (std::string line; std::getline(lines, line);) {
    const auto begin = line.find('(');
    if (begin == std::string::npos) continue;
    std::vector<double> numbers;
    for (std::sregex_iterator
             n(line.begin() + static_cast<long>(begin), line.end(), kNumber),
         end;
         n != end; ++n)
      numbers.push_back(std::stod(n->str()));
    if (line.find("STRAIGHT_TRAVERSE") != std::string::npos) {
      at = {numbers[0], numbers[1]};
    } else if (line.find("STRAIGHT_FEED") != std::string::npos) {
      const Vec2 to(numbers[0], numbers[1]);
      if (to == at) {  // the plunge
        paths.emplace_back();
        continue;
      }
      paths.back().push_back(contour::MakeLine(at, to));
      at = to;
    } else if (line.find("ARC_FEED") != std::string::npos) {
      const Vec2 to(numbers[0], numbers[1]);
      paths.back().push_back(
          contour::MakeArcBetween(at, to, {numbers[2], numbers[3]}, numbers[4] > 0));
      at = to;
    }
  }
  return paths;
}

/// Moves and idle ways of hp2xx's output, from the corner of all places.
TracedPaths TracedByHp2xx(const std::string& program, const Vec2& corner_mm) {
  static const std::regex kMove(R"(G0([01]) X ([-\d.e]+) Y ([-\d.e]+))");
  TracedPaths paths;
  Vec2 at = Vec2::Zero();
  std::istringstream lines(program);
  std::smatch found;
  for (std::string line; std::getline(lines, line);) {
    if (!std::regex_search(line, found, kMove)) continue;
    const Vec2 to = corner_mm + Vec2(std::stod(found[2]), std::stod(found[3]));
    if (found[1] == "0") {
      paths.emplace_back();
    } else if ((to - at).norm() > 0) {
      paths.back().push_back(contour::MakeLine(at, to));
    }
    at = to;
  }
  return paths;
}

double FarthestFrom(const contour::Edges& theirs, const contour::Edges& ours) {
  double worst = 0;
  for (const contour::Edge& edge : theirs) {
    constexpr int kSamples = 8;
    for (int k = 0; k <= kSamples; ++k) {
      const Vec2 place = contour::PointAt(edge, edge.length_mm * k / kSamples);
      double nearest = 1e9;
      for (const contour::Edge& own : ours)
        nearest = std::min(nearest, contour::DistanceTo(own, place));
      worst = std::max(worst, nearest);
    }
  }
  return worst;
}

/// About its own begin: places far from the origin would enlarge what is rounded.
double AreaOfPath(contour::Edges edges) {
  const Vec2 origin = edges.front().begin_mm;
  for (contour::Edge& edge : edges) {
    for (Vec2* place : {&edge.begin_mm, &edge.end_mm, &edge.center_mm}) *place -= origin;
  }
  return contour::AreaOf(edges);
}

void ExpectSamePaths(const TracedPaths& traced, const std::vector<ToolPath>& paths) {
  ASSERT_EQ(traced.size(), paths.size());
  for (std::size_t k = 0; k < paths.size(); ++k) {
    const contour::Edges ours = EdgesOf(paths[k]);
    ASSERT_FALSE(traced[k].empty());
    EXPECT_LT(FarthestFrom(traced[k], ours), kOneUm) << k;
    EXPECT_LT(FarthestFrom(ours, traced[k]), kOneUm) << k;
    // Once around, in the same direction.
    EXPECT_NEAR(contour::LengthOf(traced[k]), contour::LengthOf(ours),
                kOneUm * static_cast<double>(traced[k].size()));
    EXPECT_NEAR(AreaOfPath(traced[k]), AreaOfPath(ours),
                kOneUm * contour::LengthOf(ours));
  }
}

TEST(ContourJudges, Rs274TracesTwentyBoards) {
  if (!fixture::IsInstalled("rs274"))
    GTEST_SKIP() << "no rs274: install the package linuxcnc-uspace";
  const fs::path folder = intaglio::test::FreshFolder();
  for (const char* name : {"linuxcnc", "grbl"}) {
    const Template program = fixture::SuppliedMill(name);
    for (int number = 0; number < kBoards; ++number) {
      SCOPED_TRACE(std::string(name) + " " + std::to_string(number));
      const auto paths = PathsOfBoard(number);
      const auto texts = MillPrograms(program, paths, {.name = "board"});
      ASSERT_TRUE(texts) << texts.error().message;
      const fs::path file = folder / "board.ngc";
      std::ofstream(file) << texts->front();
      const std::string canon = fixture::OutputOf("rs274 -g " + file.string());
      ASSERT_NE(canon.find("PROGRAM_END"), std::string::npos)
          << canon.substr(canon.size() - std::min<std::size_t>(canon.size(), 500));
      ExpectSamePaths(TracedByRs274(canon), paths);
    }
  }
}

TEST(ContourJudges, Rs274DrillsTheHoles) {
  if (!fixture::IsInstalled("rs274"))
    GTEST_SKIP() << "no rs274: install the package linuxcnc-uspace";
  const std::vector<DrillRound> rounds = {{0.8, {{1.23456, 2}, {3, 4}}}, {1.2, {{5, 6}}}};
  const auto texts = DrillPrograms(fixture::SuppliedDrill("linuxcnc"), rounds, {});
  ASSERT_TRUE(texts);
  const fs::path file = intaglio::test::FreshFolder() / "holes.ngc";
  std::ofstream(file) << texts->front();
  const std::string canon = fixture::OutputOf("rs274 -g " + file.string());
  EXPECT_NE(canon.find("PROGRAM_END"), std::string::npos) << canon;
  for (const char* bottom :
       {"STRAIGHT_FEED(1.2346, 2.0000, -0.2000", "STRAIGHT_FEED(3.0000, 4.0000, -0.2000",
        "STRAIGHT_FEED(5.0000, 6.0000, -0.2000"})
    EXPECT_NE(canon.find(bottom), std::string::npos) << canon;
}

TEST(ContourJudges, Hp2xxTracesTwentyBoards) {
  if (!fixture::IsInstalled("hp2xx"))
    GTEST_SKIP() << "no hp2xx: install the package hp2xx";
  const fs::path folder = intaglio::test::FreshFolder();
  const Template program = fixture::SuppliedMill("hpgl");
  MillOptions options;
  options.chord_tolerance_mm = 0.0005;
  for (int number = 0; number < kBoards; ++number) {
    SCOPED_TRACE(number);
    const auto paths = PathsOfBoard(number);
    const auto texts = MillPrograms(program, paths, {}, options);
    ASSERT_TRUE(texts) << texts.error().message;
    const std::string file = folder / "board.plt";
    std::ofstream(file) << texts->front();
    const std::string verdict =
        fixture::OutputOf("hp2xx -t -m nc -f " + file + ".nc " + file);
    ASSERT_NE(verdict.find("ignored: 0"), std::string::npos) << verdict;
    ASSERT_NE(verdict.find("Unexpected event(s):  0"), std::string::npos) << verdict;
    Vec2 corner(1e9, 1e9);
    for (const ToolPath& path : paths) {
      for (const contour::Edge& edge : EdgesOf(Chorded(path, 0.0005)))
        corner = corner.cwiseMin(edge.begin_mm);
    }
    ExpectSamePaths(TracedByHp2xx(intaglio::test::ContentOf(file + ".nc"), corner),
                    paths);
  }
}

}  // namespace
}  // namespace intaglio::post
