// Interpreters of others judge the programs of the supplied templates: LinuxCNC's rs274
// and hp2xx, both of Debian. The path that they trace has to be ours.

#include <gtest/gtest.h>

#include <random>
#include <regex>
#include <sstream>

#include "engrave/post/point_program.h"
#include "tests/engrave/post/judge_programs.h"
#include "tests/test_folder.h"

namespace intaglio::post {
namespace {

namespace fs = std::filesystem;

/// Steps of at least `min_mm`, so that directions are well defined.
PointList RandomPath(int count, double z_mm) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> place(-40, 80);
  PointList path;
  for (int i = 0; i < count; ++i) {
    path.emplace_back(place(random), place(random), z_mm > 0 ? place(random) : 0.0);
  }
  return path;
}

fs::path ProgramOf(const std::string& family, const PointList& axes) {
  const fs::path source =
      fs::path(INTAGLIO_SOURCE_DIR) / "deploy/post" / (family + ".post");
  const auto parsed =
      ParsePointTemplate(intaglio::test::ContentOf(source), source.string());
  EXPECT_TRUE(parsed) << (parsed ? "" : parsed.error().message);
  const fs::path file = intaglio::test::FreshFolder() / ("path." + parsed->extension);
  const Status written = WritePointProgram(file, *parsed, {"judged", axes});
  EXPECT_TRUE(written) << (written ? "" : written.error().message);
  return file;
}

struct Move {
  bool rapid = false;
  Vec3 to_mm = Vec3::Zero();
  bool lit = false;  ///< under way
  int pulses = 0;    ///< at its end
};

/// The canonical commands that rs274 prints: moves, the digital output 0, the power.
std::vector<Move> MovesOf(const std::string& canon) {
  static const std::regex kMove(
      R"(STRAIGHT_(TRAVERSE|FEED)\(([-\d.]+), ([-\d.]+), ([-\d.]+))");
  static const std::regex kPower(R"(SET_SPINDLE_SPEED\(0, ([\d.]+)\))");
  std::vector<Move> moves;
  double power = 0;
  std::istringstream lines(canon);
  std::smatch found;
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_search(line, found, kMove)) {
      moves.push_back(
          {found[1] == "TRAVERSE",
           Vec3(std::stod(found[2]), std::stod(found[3]), std::stod(found[4])),
           found[1] == "FEED" && power > 0, 0});
    } else if (std::regex_search(line, found, kPower)) {
      power = std::stod(found[1]);
    } else if (line.find("SET_AUX_OUTPUT_BIT(0)") != std::string::npos) {
      if (!moves.empty()) ++moves.back().pulses;
    }
  }
  return moves;
}

TEST(Judges, Rs274TracesThePathOfLinuxCnc) {
  if (!fixture::IsInstalled("rs274"))
    GTEST_SKIP() << "no rs274: install the package linuxcnc-uspace";
  const PointList path = RandomPath(2000, 1);
  const auto canon =
      fixture::OutputOf("rs274 -g " + ProgramOf("linuxcnc", path).string());
  const std::vector<Move> moves = MovesOf(canon);
  ASSERT_EQ(moves.size(), path.size()) << canon.substr(0, 2000);
  for (std::size_t i = 0; i < path.size(); ++i) {
    // Four decimals of a millimetre.
    ASSERT_LT((moves[i].to_mm - path[i]).cwiseAbs().maxCoeff(), 0.6e-4) << i;
    ASSERT_EQ(moves[i].pulses, 1) << i;
    ASSERT_FALSE(moves[i].lit) << i;
  }
}

TEST(Judges, Rs274TracesTheMarksOfGrbl) {
  if (!fixture::IsInstalled("rs274"))
    GTEST_SKIP() << "no rs274: install the package linuxcnc-uspace";
  const PointList path = RandomPath(2000, 1);
  const auto canon = fixture::OutputOf("rs274 -g " + ProgramOf("grbl", path).string());
  const std::vector<Move> moves = MovesOf(canon);
  ASSERT_EQ(moves.size(), 2 * path.size()) << canon.substr(0, 2000);
  for (std::size_t i = 0; i < path.size(); ++i) {
    const Move& dark = moves[2 * i];
    const Move& mark = moves[2 * i + 1];
    ASSERT_FALSE(dark.lit) << i;
    ASSERT_TRUE(mark.lit) << i;
    const Vec3 middle = 0.5 * (dark.to_mm + mark.to_mm);
    ASSERT_LT((middle - path[i]).cwiseAbs().maxCoeff(), 0.6e-4) << i;
    ASSERT_NEAR((mark.to_mm - dark.to_mm).norm(), 0.02, 2e-4) << i;
  }
}

TEST(Judges, Hp2xxTracesThePathOfHpgl) {
  if (!fixture::IsInstalled("hp2xx"))
    GTEST_SKIP() << "no hp2xx: install the package hp2xx";
  const PointList path = RandomPath(500, 0);
  const std::string file = ProgramOf("hpgl", path).string();
  const std::string verdict =
      fixture::OutputOf("hp2xx -t -m nc -f " + file + ".nc " + file);
  EXPECT_NE(verdict.find("ignored: 0"), std::string::npos) << verdict;
  EXPECT_NE(verdict.find("Unexpected event(s):  0"), std::string::npos) << verdict;
  // Its dots, from the lowest corner of all; 0.025 mm a unit.
  Vec3 corner = path[0];
  for (const Vec3& p : path) corner = corner.cwiseMin(p);
  static const std::regex kDown(R"(G00 X ([-\d.]+) Y ([-\d.]+))");
  std::istringstream lines(intaglio::test::ContentOf(file + ".nc"));
  std::size_t i = 0;
  std::smatch found;
  for (std::string line; std::getline(lines, line);) {
    if (!std::regex_search(line, found, kDown)) continue;
    ASSERT_LT(i, path.size());
    EXPECT_NEAR(std::stod(found[1]), path[i].x() - corner.x(), 0.026) << i;
    EXPECT_NEAR(std::stod(found[2]), path[i].y() - corner.y(), 0.026) << i;
    ++i;
  }
  EXPECT_EQ(i, path.size());
}

}  // namespace
}  // namespace intaglio::post
