// The command as a person calls it, on clouds whose figures are known.

#include "services/cli/offline/measure_command.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "engrave/formats/point_file.h"
#include "proto/quality.pb.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

class MeasureCommand : public ::testing::Test {
 protected:
  MeasureCommand() {
    // A cube of 10 mm in an OBJ, and a lattice of 0.5 mm on all its faces but the upper
    // one, where the product puts it: in the middle of a block of 20 mm.
    std::ofstream(folder_ / "cube.obj")
        << "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n"
           "f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    for (int i = 0; i <= 20; ++i) {
      for (int j = 0; j <= 20; ++j) {
        for (int k = 0; k <= 20; ++k) {
          const bool side = i % 20 == 0 || j % 20 == 0 || k == 0;
          if (side) points_.points_mm.push_back(Vec3(5, 5, 5) + 0.5 * Vec3(i, j, k));
        }
      }
    }
  }

  int Run(std::vector<std::string> arguments) {
    EXPECT_TRUE(formats::WritePly(folder_ / "cloud.ply", points_));
    command_line::Program program("intaglio", "");
    AddMeasureCommand(program.root());
    arguments.insert(arguments.begin(), {"measure", (folder_ / "cloud.ply").string()});
    EXPECT_TRUE(program.Parse(arguments));
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    const int code = program.Run();
    out_ = ::testing::internal::GetCapturedStdout();
    err_ = ::testing::internal::GetCapturedStderr();
    return code;
  }

  std::vector<std::string> OfCube(std::vector<std::string> more) const {
    std::vector<std::string> all = {"--mesh",    (folder_ / "cube.obj").string(),
                                    "--size",    "10",
                                    "--block",   "20",
                                    "20",        "20",
                                    "--spacing", "0.5"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  fs::path folder_ = test::FreshFolder();
  formats::PointTable points_;
  std::string out_, err_;
};

TEST_F(MeasureCommand, FindsTheLostFaceOfAPlacedCube) {
  EXPECT_EQ(Run(OfCube({"--json"})), 0) << err_;
  CloudQuality quality;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(out_, &quality).ok()) << out_;
  EXPECT_EQ(quality.point_count(), points_.points_mm.size());
  EXPECT_TRUE(quality.keeps_spacing());
  EXPECT_DOUBLE_EQ(quality.min_spacing_mm(), 0.5);
  EXPECT_NEAR(quality.nearest().mean_mm(), 0.5, 1e-9);
  EXPECT_EQ(quality.nearest().bins(20), points_.points_mm.size());
  EXPECT_NEAR(quality.surface().area_mm2(), 600, 1e-6);
  EXPECT_NEAR(quality.surface().greatest_distance_mm(), 0, 1e-9);
  // The face's middle is 5 mm from the points of its rim.
  EXPECT_NEAR(quality.surface().uncovered_radius_mm(), 5, 0.005);
  EXPECT_NEAR(quality.surface().uncovered_place_mm().z(), 15, 1e-9);
  EXPECT_GT(quality.cracks().crack_diameter_mm(), 0);
  ASSERT_EQ(quality.warnings_size(), 1);
  EXPECT_THAT(quality.warnings(0).text(), HasSubstr("hole of radius 5.00 mm"));
}

TEST_F(MeasureCommand, EndsWithOneWhenPointsAreTooNear) {
  points_.points_mm.push_back(points_.points_mm[7] + Vec3(0.1, 0, 0));
  EXPECT_EQ(Run({"--spacing", "0.5"}), 3);
  EXPECT_THAT(out_, HasSubstr("2 pairs below 0.5 mm"));
  EXPECT_THAT(out_, HasSubstr("minimum 0.100000 mm"));
  EXPECT_THAT(out_, HasSubstr("\nwarning"));
  EXPECT_EQ(Run({"--spacing", "0.09"}), 0);
  // In z cracks are longer: what is 0.5 mm apart there counts as 0.25.
  EXPECT_EQ(Run({"--spacing", "0.09", "--height-ratio", "6"}), 3);
  EXPECT_THAT(out_, HasSubstr("heights divided by 6"));
}

TEST_F(MeasureCommand, TakesTheJobForItsModelsAndSpacing) {
  std::ofstream(folder_ / "job.textproto")
      << "name: \"cube\" models { file: \"cube.obj\" placement { fit_size_mm: 10 } }\n"
         "block { size_mm { x: 20 y: 20 z: 20 } } glass: \"N-BK7\"\n"
         "discretization { min_spacing_mm: 0.6 }\n"
         "machine_file: \"" INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto\"\n";
  EXPECT_EQ(Run({"--job", (folder_ / "job.textproto").string(), "--csv"}), 3) << err_;
  EXPECT_THAT(out_, HasSubstr("figure,value\n"));
  EXPECT_THAT(out_, HasSubstr("\nmin_spacing_mm,0.6\n"));
  EXPECT_THAT(out_, HasSubstr("\nkeeps_spacing,0\n"));
  EXPECT_THAT(out_, HasSubstr("\nsurface.triangle_count,12\n"));
}

// Two cubes in one place, but in different blocks.
TEST_F(MeasureCommand, OfSeveralBlocksItMeasuresTheOneAskedFor) {
  const std::string model = "models { file: \"cube.obj\" placement { fit_size_mm: 10 } ";
  std::ofstream(folder_ / "job.textproto")
      << "name: \"cubes\" " << model << "channels: 1 } " << model << "channels: 2 }\n"
      << "block { size_mm { x: 20 y: 20 z: 20 } } glass: \"N-BK7\"\n"
         "discretization { min_spacing_mm: 0.5 } laser { channels: [1, 2] }\n"
         "machine_file: \"" INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto\"\n";
  const PointList one_mm = points_.points_mm;
  std::vector<std::uint32_t> source(one_mm.size(), 0);
  std::vector<std::uint8_t> channel(one_mm.size(), 0);
  points_.points_mm.push_back(one_mm[0]);
  source.push_back(1);
  channel.push_back(1);
  points_.points_mm.push_back(one_mm[1]);
  source.push_back(1);
  channel.push_back(1);
  const std::vector<std::string> job = {"--job", (folder_ / "job.textproto").string()};
  const auto run = [&](std::vector<std::string> more) {
    more.insert(more.begin(), job.begin(), job.end());
    return Run(more);
  };
  for (const bool cracks : {false, true}) {
    points_.columns = {{"source", source}};
    if (cracks) points_.columns = {{"channel", channel}};
    EXPECT_EQ(run({}), 2);
    EXPECT_THAT(err_, HasSubstr("--channel: is missing"));
    EXPECT_EQ(run({"--channel", "1", "--csv"}), 0) << err_ << out_;
    EXPECT_THAT(out_, HasSubstr("\nsurface.triangle_count,12\n")) << "of one cube";
    EXPECT_EQ(run({"--channel", "2", "--csv"}), 0) << err_;
    EXPECT_THAT(out_, HasSubstr("point_count,2\n"));
    EXPECT_EQ(run({"--channel", "3"}), 2);
    EXPECT_THAT(err_, HasSubstr("3 has no points"));
  }
}

// A place that is nowhere in the file, and a distance of 0, would be false.
TEST_F(MeasureCommand, OnePointHasNoNearestOne) {
  points_.points_mm = {Vec3(7, 8, 9)};
  EXPECT_EQ(Run({"--spacing", "0.5"}), 0) << err_;
  EXPECT_THAT(out_, HasSubstr("\nnearest       none: one point\nsources "));
  EXPECT_EQ(Run({"--spacing", "0.5", "--json"}), 0) << err_;
  CloudQuality quality;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(out_, &quality).ok()) << out_;
  EXPECT_FALSE(quality.has_nearest());
  EXPECT_TRUE(quality.keeps_spacing());
}

TEST_F(MeasureCommand, DrawsThePicture) {
  EXPECT_EQ(Run({"--picture", (folder_ / "map.png").string(), "--spacing", "0.5"}), 0);
  EXPECT_GT(fs::file_size(folder_ / "map.png"), 10000u);
  EXPECT_EQ(Run({"--picture", (folder_ / "no" / "map.png").string()}), 2);
}

TEST_F(MeasureCommand, RefusesWrongInput) {
  EXPECT_EQ(Run({"--mesh", (folder_ / "none.obj").string()}), 2);
  EXPECT_THAT(err_, HasSubstr("none.obj"));
  points_.points_mm.clear();
  EXPECT_EQ(Run({}), 2);
  EXPECT_THAT(err_, HasSubstr("has no points"));
}

}  // namespace
}  // namespace intaglio::cli
