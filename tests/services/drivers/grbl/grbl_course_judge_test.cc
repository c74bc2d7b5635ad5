// LinuxCNC's rs274 judges the lines that the driver of marks sends: it accepts them, and
// traces the marks.

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <regex>
#include <sstream>

#include "tests/engrave/post/judge_programs.h"
#include "tests/services/drivers/grbl/course_rig.h"
#include "tests/test_folder.h"

namespace intaglio::drivers {
namespace {

// Places are printed to 0.1 um, and centres of arcs, too.
constexpr double kPrinted_mm = 0.0005;

mark::MarkSet RandomMarks(const mark::Pen& pen) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> place(-40, 40), bulge(-2, 2);
  mark::MarkSet set{{pen}, {}};
  for (int i = 0; i < 40; ++i) {
    mark::Mark mark;
    mark.closed = i % 2 == 0;
    for (int k = 0; k < 3 + i % 4; ++k) {
      const bool line = random() % 3 == 0;
      mark.places.push_back({{place(random), place(random)}, line ? 0.0 : bulge(random)});
    }
    set.marks.push_back(std::move(mark));
  }
  return set;
}

/// What the driver would send of all marks, as a program.
std::string ProgramOfMarks(const mark::MarkSet& set, const CourseToolOptions& options) {
  GrblCourseProgram program(options);
  GrblTraits traits;
  traits.steps_per_mm = Vec3::Constant(250);
  traits.max_speed_mm_s = Vec3::Constant(50);
  traits.max_power = 1000;
  program.SetController(traits);
  program.RestAt(Vec3::Zero());
  std::string text = "G21G90G94G54\n";
  for (const mark::Mark& mark : set.marks) {
    program.Begin(mark, set.pens[mark.pen]);
    while (const auto line = program.Next()) {
      EXPECT_LE(line->text.size(), 78U);
      EXPECT_LE(line->seconds, GrblCourseProgram::kPiece_s * 1.01);
      text += line->text + "\n";
    }
  }
  return text + "M2\n";
}

struct Traced {
  double worst_mm = 0;   ///< of a place at work from the nearest mark
  double length_mm = 0;  ///< at work, in the plane
  double deepest_mm = 0;
};

std::vector<double> NumbersIn(const std::string& text) {
  static const std::regex kNumber(R"(-?\d+\.?\d*)");
  std::vector<double> numbers;
  for (std::sregex_iterator n(text.begin(), text.end(), kNumber), end; n != end; ++n)
    numbers.push_back(std::stod(n->str()));
  return numbers;
}

double NearestMark(const Vec2& place,
                   const std::vector<std::vector<contour::Edge>>& all) {
  double nearest = 1e9;
  for (const auto& edges : all) {
    for (const contour::Edge& edge : edges)
      nearest = std::min(nearest, contour::DistanceTo(edge, place));
  }
  return nearest;
}

Traced TraceOf(const std::string& canon, const mark::MarkSet& set) {
  std::vector<std::vector<contour::Edge>> all;
  for (const mark::Mark& mark : set.marks) all.push_back(EdgesOfMark(mark));
  Traced traced;
  Vec2 at = Vec2::Zero();
  std::istringstream lines(canon);
  for (std::string line; std::getline(lines, line);) {
    const auto begin = line.find('(');
    if (begin == std::string::npos) continue;
    const auto numbers = NumbersIn(line.substr(begin));
    const bool arc = line.find("ARC_FEED") != std::string::npos;
    if (line.find("STRAIGHT_TRAVERSE") != std::string::npos)
      at = {numbers[0], numbers[1]};
    if (!arc && line.find("STRAIGHT_FEED") == std::string::npos) continue;
    const Vec2 to(numbers[0], numbers[1]);
    const contour::Edge edge =
        arc ? contour::MakeArcBetween(at, to, {numbers[2], numbers[3]}, numbers[4] > 0)
            : contour::MakeLine(at, to);
    traced.deepest_mm = std::min(traced.deepest_mm, numbers[arc ? 5 : 2]);
    traced.length_mm += edge.length_mm;
    for (const double part : {0.0, 0.3, 0.7, 1.0}) {
      if (edge.length_mm == 0) continue;  // a plunge
      const Vec2 place = contour::PointAt(edge, part * edge.length_mm);
      traced.worst_mm = std::max(traced.worst_mm, NearestMark(place, all));
    }
    at = to;
  }
  return traced;
}

void Judge(const mark::MarkSet& set, const CourseToolOptions& options,
           double tolerance_mm, double deepest_mm) {
  if (!post::fixture::IsInstalled("rs274"))
    GTEST_SKIP() << "no rs274: install the package linuxcnc-uspace";
  const auto file = intaglio::test::FreshFolder() / "marks.ngc";
  std::ofstream(file) << ProgramOfMarks(set, options);
  const auto canon = post::fixture::OutputOf("rs274 -g " + file.string());
  const Traced traced = TraceOf(canon, set);
  double length_mm = 0;
  for (const mark::Mark& mark : set.marks)
    length_mm += set.pens[0].pass_count * mark::LengthOf(mark);
  EXPECT_LE(traced.worst_mm, tolerance_mm) << canon.substr(0, 1000);
  EXPECT_NEAR(traced.length_mm, length_mm, 1e-4 * length_mm);
  EXPECT_NEAR(traced.deepest_mm, deepest_mm, 1e-6);
}

TEST(GrblCourseJudge, Rs274TracesTheMarksOfALaser) {
  Judge(RandomMarks(LaserPen()), {}, kPrinted_mm, 0);
}

TEST(GrblCourseJudge, Rs274TracesThePassesOfASpindle) {
  CourseToolOptions options;
  options.tool = GrblTool::kSpindle;
  Judge(RandomMarks(MillPen()), options, kPrinted_mm, -0.6);
}

TEST(GrblCourseJudge, Rs274TracesChords) {
  CourseToolOptions options;
  options.lines_only = true;
  Judge(RandomMarks(LaserPen()), options, GrblCourseProgram::kChord_mm + kPrinted_mm, 0);
}

}  // namespace
}  // namespace intaglio::drivers
