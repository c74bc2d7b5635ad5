// The commands without processes, chained by files, make what `intaglio run` makes with
// six processes: the same points in the same order, bit for bit.

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <regex>

#include "engrave/formats/point_file.h"
#include "proto/plan_report.pb.h"
#include "proto/report.pb.h"
#include "tests/integration/run_program.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using testing::Ended;
using ::testing::HasSubstr;
using testing::Program;
using testing::Running;
using testing::TextIn;

using Tokens = std::vector<std::string>;

/// A cube of 8 mm, twelve triangles, outside to the right.
void WriteCube(const fs::path& file) {
  const auto corner = [](int i) {
    return std::array<int, 3>{i & 1 ? 8 : 0, i & 2 ? 8 : 0, i & 4 ? 8 : 0};
  };
  constexpr int kFaces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  std::ofstream out(file);
  out << "solid cube\n";
  for (const auto& face : kFaces) {
    for (const auto& triangle : {std::array<int, 3>{face[0], face[1], face[2]},
                                 std::array<int, 3>{face[0], face[2], face[3]}}) {
      out << "facet normal 0 0 0\nouter loop\n";
      for (const int i : triangle) {
        const auto [x, y, z] = corner(i);
        out << "vertex " << x << " " << y << " " << z << "\n";
      }
      out << "endloop\nendfacet\n";
    }
  }
  out << "endsolid cube\n";
}

/// Options of the points and of their order.
struct Chain {
  Tokens points, order;
};

Tokens Joined(Tokens words, const Tokens& more) {
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

class OfflineChain : public ::testing::TestWithParam<Chain> {
 protected:
  OfflineChain() { WriteCube(folder_ / "cube.stl"); }
  /// Options of a command that makes the points.
  Tokens WithModel(const Tokens& words) const {
    return Joined(
        Joined(words, {"--mesh", (folder_ / "cube.stl").string(), "--block", "20", "20",
                       "20", "--rotate", "30", "20", "10", "--spacing", "0.5"}),
        GetParam().points);
  }
  /// Adds the order to one that has points.
  static Tokens WithOrder(const Tokens& words) {
    return Joined(Joined(words, {"--block", "20", "20", "20", "--spacing", "0.5"}),
                  GetParam().order);
  }
  Tokens WithMaterials(Tokens words) const {
    words.insert(words.end(), {"--materials", (folder_ / "materials.db").string()});
    return words;
  }
  Ended Type(const Tokens& words) {
    Running run(Program("intaglio"), words, folder_ / (words.front() + ".txt"));
    Ended ended = run.WaitForEnd(60s);
    EXPECT_EQ(ended.exit_code, 0) << ended.output;
    return ended;
  }
  static std::string ChecksumIn(const std::string& output) {
    std::smatch found;
    const bool there =
        std::regex_search(output, found, std::regex("checksum ([0-9a-f]{8})"));
    EXPECT_TRUE(there) << output;
    return there ? found[1].str() : "";
  }
  static std::vector<std::array<double, 3>> SortedPoints(const fs::path& file) {
    const auto table = formats::ReadPly(file);
    EXPECT_TRUE(table) << file;
    std::vector<std::array<double, 3>> points;
    if (!table) return points;
    for (const Vec3& p : table->points_mm) points.push_back({p.x(), p.y(), p.z()});
    std::sort(points.begin(), points.end());
    return points;
  }

  fs::path folder_ = test::FreshFolder();
};

TEST_P(OfflineChain, GivesWhatRunGives) {
  const std::string out = (folder_ / "out").string();
  const std::string cloud = (folder_ / "cloud.ply").string();
  const std::string path = (folder_ / "path.ply").string();
  const std::string picture = (folder_ / "picture.png").string();
  Type(WithMaterials(
      Joined(WithModel({"run", "--lockstep", "--out", out}), GetParam().order)));
  Type(WithModel({"discretize", "--out", cloud}));
  const Ended sorted =
      Type(WithMaterials(WithOrder({"sort", "--cloud", cloud, "--out", path})));
  EXPECT_THAT(sorted.output, HasSubstr(" 0 fired through an earlier crack"));

  const auto made = SortedPoints(fs::path(out) / "path.ply");
  EXPECT_GT(made.size(), 100u);
  EXPECT_EQ(SortedPoints(cloud), made) << "the same points";
  const Ended verified = Type({"verify", out, "--json"});
  JobReport report;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(verified.output, &report).ok())
      << verified.output;
  EXPECT_TRUE(report.verdict().good());
  EXPECT_EQ(ChecksumIn(sorted.output), report.checksums().at("path")) << "in one order";
  EXPECT_THAT(Type({"verify", out}).output, HasSubstr("verdict     GOOD"));

  const Ended planned = Type(
      WithMaterials({"plan", "--path", path, "--block", "20", "20", "20", "--json"}));
  JobReport ran;
  PlanReport plan;
  ASSERT_TRUE(
      google::protobuf::util::JsonStringToMessage(TextIn(out + "/report.json"), &ran)
          .ok());
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(
                  planned.output.substr(planned.output.find("{\n")), &plan)
                  .ok())
      << planned.output;
  EXPECT_EQ(plan.checksum(), report.checksums().at("path"));
  EXPECT_EQ(plan.motions(0).ticks(), ran.engrave().estimate_ticks());
  EXPECT_EQ(plan.motions(0).violation_count(), 0u);

  Type({"render", cloud, "--block", "20", "20", "20", "--out", picture});
  std::ifstream png(picture, std::ios::binary);
  std::string begin(4, '\0');
  png.read(begin.data(), 4);
  EXPECT_EQ(begin, "\x89PNG");
}

INSTANTIATE_TEST_SUITE_P(Methods, OfflineChain,
                         ::testing::Values(Chain{}, Chain{{"--method", "fill"}, {}},
                                           Chain{{"--method", "rays"},
                                                 {"--order", "layers"}}));

}  // namespace
}  // namespace intaglio
