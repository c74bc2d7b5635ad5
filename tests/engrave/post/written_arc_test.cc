// Arcs as controllers read them from programs of every supplied template: the judge is a
// controller of its own that knows nothing of the path, and LinuxCNC's rs274.

#include "engrave/post/written_arc.h"

#include <gtest/gtest.h>

#include <fstream>
#include <numbers>
#include <random>
#include <regex>
#include <sstream>

#include "engrave/contour/isolation.h"
#include "tests/engrave/post/judge_programs.h"
#include "tests/engrave/post/supplied_templates.h"

namespace intaglio::post {
namespace {

using std::numbers::pi;

/// The program of one path by a supplied template.
std::string ProgramOf(const char* name, const std::vector<ToolPath>& paths) {
  MillOptions options;
  options.axis_speed_deg_s = 1e5;
  Cutting cutting{.name = "board"};
  if (std::string_view(name) == "grbl-laser") cutting.power_ratio = 0.5;
  const auto texts = MillPrograms(fixture::SuppliedMill(name), paths, cutting, options);
  EXPECT_TRUE(texts) << texts.error().message;
  return texts ? texts->front() : "";
}

/// G0 .. G3 with X Y I J, as RS-274 defines them: an arc whose ends agree is a whole
/// turn.
contour::Edges MovesOfController(const std::string& program) {
  static const std::regex kMove(
      R"(^(?:N\d+ )?G([0123]) X([-\d.]+) Y([-\d.]+)(?: I([-\d.]+) J([-\d.]+))?)");
  contour::Edges edges;
  Vec2 at = Vec2::Zero();
  std::istringstream lines(program);
  std::smatch found;
  for (std::string line; std::getline(lines, line);) {
    if (!std::regex_search(line, found, kMove)) continue;
    const Vec2 to(std::stod(found[2]), std::stod(found[3]));
    if (found[1] == "2" || found[1] == "3") {
      const Vec2 center = at + Vec2(std::stod(found[4]), std::stod(found[5]));
      edges.push_back(contour::MakeArcBetween(at, to, center, found[1] == "3"));
    } else if (found[1] == "1" && line.find(" Z") == std::string::npos) {
      edges.push_back(contour::MakeLine(at, to));
    }
    at = to;
  }
  return edges;
}

/// A contour of arcs of every size down to a few nm, each from the end of the one before.
ToolPath PathOfSmallArcs(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> exponent(-7, 0.5), angle(-pi, pi);
  contour::Edges edges;
  Vec2 at(3.123456789, -2.987654321);
  for (int k = 0; k < 200; ++k) {
    const double radius = std::pow(10, exponent(random) / 2);
    const double sweep =
        std::min(6.0, std::pow(10, exponent(random))) * (k % 2 == 0 ? 1 : -1);
    const double begin = angle(random);
    const Vec2 center = at - radius * Vec2(std::cos(begin), std::sin(begin));
    contour::Edge arc = contour::MakeArc(center, radius, begin, sweep);
    arc.begin_mm = at;
    at = arc.end_mm;
    edges.push_back(arc);
  }
  return PathOf(edges, "contour 1");
}

double FarthestFromPath(const contour::Edges& made, const contour::Edges& planned) {
  double worst = 0;
  for (const contour::Edge& edge : made) {
    for (int k = 0; k <= 16; ++k) {
      const Vec2 place = contour::PointAt(edge, edge.length_mm * k / 16);
      double nearest = 1e9;
      for (const contour::Edge& own : planned)
        nearest = std::min(nearest, contour::DistanceTo(own, place));
      worst = std::max(worst, nearest);
    }
  }
  return worst;
}

// Ends are wrong by half a decimal, centres by one, and a controller's own radius is that
// to the begin: three decimals are the most.
TEST(WrittenArc, NoControllerLeavesThePath) {
  for (const auto& [name, decimal_mm] :
       {std::pair("linuxcnc", 1e-5), std::pair("grbl", 1e-4),
        std::pair("grbl-laser", 1e-4), std::pair("sinumerik", 1e-6)}) {
    for (unsigned seed = 1; seed <= 10; ++seed) {
      SCOPED_TRACE(std::string(name) + " " + std::to_string(seed));
      const ToolPath path = PathOfSmallArcs(seed);
      const contour::Edges made = MovesOfController(ProgramOf(name, {path}));
      ASSERT_GT(made.size(), 50U);
      EXPECT_LT(FarthestFromPath(made, EdgesOf(path)), 3 * decimal_mm);
      EXPECT_NEAR(contour::LengthOf(made), contour::LengthOf(EdgesOf(path)),
                  3 * decimal_mm * 200);
    }
  }
}

// KRL has the place half way and the end: neither may be the one before it.
TEST(WrittenArc, TheThreePlacesOfARobotDiffer) {
  static const std::regex kPlace(R"(X ([-\d.]+), Y ([-\d.]+))");
  for (const char* name : {"krl", "krl-full"}) {
    const std::string program = ProgramOf(name, {PathOfSmallArcs(3)});
    std::istringstream lines(program);
    std::string before;
    int arcs = 0;
    for (std::string line; std::getline(lines, line);) {
      std::vector<std::string> places;
      for (std::sregex_iterator n(line.begin(), line.end(), kPlace), end; n != end; ++n)
        places.push_back(n->str());
      if (line.starts_with("WCirc(") && places.size() == 2) {
        ++arcs;
        EXPECT_NE(places[0], before) << line;
        EXPECT_NE(places[0], places[1]) << line;
        EXPECT_NE(places[1], before) << line;
      }
      if (!places.empty()) before = places.back();
    }
    EXPECT_GT(arcs, 20) << name;
  }
}

// A track whose lower side bends by 0.006 degrees: the arc around its corner is 20 nm
// long.
std::vector<ToolPath> AroundABentTrack() {
  const Vec2 corners[] = {{0, 0}, {10, -0.001}, {20, 0}, {20, 0.25}, {0, 0.25}};
  contour::Edges loop;
  for (std::size_t k = 0; k < 5; ++k)
    loop.push_back(contour::MakeLine(corners[k], corners[(k + 1) % 5]));
  const auto isolation =
      contour::Isolate(std::vector<contour::Element>{{contour::Outline{{loop}}}}, {0.2});
  EXPECT_TRUE(isolation);
  return {PathOf(isolation->passes[0].contours[0].edges, "contour 1")};
}

TEST(WrittenArc, ABentTrackIsNotMilledAway) {
  const std::vector<ToolPath> paths = AroundABentTrack();
  const double planned_mm = contour::LengthOf(EdgesOf(paths[0]));
  for (const char* name : {"linuxcnc", "grbl", "grbl-laser", "sinumerik"}) {
    SCOPED_TRACE(name);
    const contour::Edges made = MovesOfController(ProgramOf(name, paths));
    EXPECT_NEAR(contour::LengthOf(made), planned_mm, 0.001);
    // The copper is 0.1 from the centre of the tool: a whole turn would enter it by 0.1.
    EXPECT_LT(FarthestFromPath(made, EdgesOf(paths[0])), 2e-4);
  }
}

TEST(WrittenArc, Rs274MakesNoWholeTurn) {
  if (!fixture::IsInstalled("rs274"))
    GTEST_SKIP() << "no rs274: install the package linuxcnc-uspace";
  const auto folder = intaglio::test::FreshFolder();
  static const std::regex kArc(
      R"(ARC_FEED\(([-\d.]+), ([-\d.]+), [-\d.]+, [-\d.]+, (-?\d+))");
  static const std::regex kPlace(R"((?:STRAIGHT_\w+|ARC_FEED)\(([-\d.]+), ([-\d.]+))");
  for (const char* name : {"linuxcnc", "grbl"}) {
    for (const auto& paths : {AroundABentTrack(), {PathOfSmallArcs(5)}}) {
      const std::string file = folder / "board.ngc";
      std::ofstream(file) << ProgramOf(name, paths);
      const std::string canon = fixture::OutputOf("rs274 -g " + file);
      ASSERT_NE(canon.find("PROGRAM_END"), std::string::npos)
          << canon.substr(canon.size() - std::min<std::size_t>(canon.size(), 500));
      std::istringstream lines(canon);
      std::string before;
      for (std::string line; std::getline(lines, line);) {
        std::smatch found, place;
        if (!std::regex_search(line, place, kPlace)) continue;
        const std::string at = place[1].str() + " " + place[2].str();
        // rs274 prints four decimals; a turn of a whole circle comes back to its begin.
        if (std::regex_search(line, found, kArc) && std::string_view(name) == "grbl") {
          EXPECT_NE(at, before) << line;
        }
        before = at;
      }
    }
  }
}

}  // namespace
}  // namespace intaglio::post
