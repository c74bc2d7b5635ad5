// Whole jobs on machines whose axes are not the coordinates of the focus. The virtual
// engraver moves head, block, arm and table by its own forward kinematics; where cracks
// are is read from its glass and compared with the path here, without the product's
// proof.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "engrave/formats/point_file.h"
#include "tests/integration/run_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using testing::Ended;
using testing::Program;
using testing::RunJob;
using testing::Running;

const std::string kMachines = INTAGLIO_SOURCE_DIR "/deploy/machines/";

class KinematicsJob : public RunJob {
 protected:
  /// els-03 with these lines instead of its origin.
  std::string ProfileWith(const std::string& lines) const {
    std::string text = testing::TextIn(kMachines + "els-03.textproto");
    const std::string origin = "\nblock_origin_mm { x: 0 y: 0 z: 0 }\n";
    text.replace(text.find(origin), origin.size(), "\n" + lines + "\n");
    const fs::path file = folder_ / "machine.textproto";
    std::ofstream(file) << text;
    return file.string();
  }
  Ended RunOn(const std::string& machine, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {"--lockstep", "--warm-up", "0",    "--spacing",
                                      "0.8",        "--machine", machine};
    words.insert(words.end(), more.begin(), more.end());
    return Run(std::move(words));
  }
  PointList Path() const {
    const auto table = formats::ReadPly(folder_ / "out/path.ply");
    return table ? table->points_mm : PointList{};
  }
  /// The farthest that a point of the path has its nearest crack, mm.
  double FarthestCrackMm(const PointList& path_mm) const {
    const auto glass = formats::ReadGlassRecord(folder_ / "out/session/glass.rec");
    if (!glass || glass->cracks.empty()) return 1e9;
    double farthest_mm = 0;
    for (const Vec3& point_mm : path_mm) {
      double nearest_mm = 1e9;
      for (const auto& crack : glass->cracks) {
        nearest_mm = std::min(nearest_mm, (crack.position_mm - point_mm).norm());
      }
      farthest_mm = std::max(farthest_mm, nearest_mm);
    }
    return farthest_mm;
  }
  void ExpectAllMadeInPlace(const Ended& run) const {
    ASSERT_TRUE(run.in_time);
    ASSERT_EQ(run.exit_code, 0) << run.output;
    const JobReport report = Report();
    EXPECT_TRUE(report.verdict().good());
    EXPECT_GT(report.points().planned(), 1000u);
    EXPECT_EQ(report.points().made(), report.points().planned());
    EXPECT_EQ(report.points().stray() + report.points().doubled(), 0u);
    EXPECT_LT(report.position_errors().max_um(), 30) << "the machine's tolerance";
    const PointList path_mm = Path();
    ASSERT_EQ(path_mm.size(), report.points().planned());
    EXPECT_LT(FarthestCrackMm(path_mm), 0.03);
  }
};

// The sample is a trefoil knot, which is not its own mirror image.
TEST_F(KinematicsJob, OnAMovingTableIsNotMirrored) {
  ExpectAllMadeInPlace(
      RunOn(ProfileWith("block_origin_mm { x: -100 y: -120 z: 0 }\n"
                        "cartesian { x { moves: AXIS_MOVES_TABLE } "
                        "y { moves: AXIS_MOVES_TABLE } }")));
  PointList mirrored_mm = Path();
  for (Vec3& point_mm : mirrored_mm) point_mm.x() = 50 - point_mm.x();
  EXPECT_GT(FarthestCrackMm(mirrored_mm), 0.5) << "the comparison would see it";
}

// A table that rises to the lens and counts down, and a head whose y counts down.
TEST_F(KinematicsJob, WithAxesThatCountDownIsInPlace) {
  ExpectAllMadeInPlace(
      RunOn(ProfileWith("block_origin_mm { x: 10 y: -80 z: 20 }\n"
                        "cartesian { y { reversed: true } "
                        "z { moves: AXIS_MOVES_TABLE reversed: true } }"),
            {"--profile", "mix"}));
}

TEST_F(KinematicsJob, WithArmAndRotaryTableIsInPlace) {
  ExpectAllMadeInPlace(RunOn(kMachines + "polar.textproto"));
}

// Stopping at each point, by a controller with a clock of its own.
TEST_F(KinematicsJob, WithArmAndRotaryTableOnAClockOfItsOwnIsInPlace) {
  ExpectAllMadeInPlace(
      RunOn(kMachines + "polar.textproto", {"--profile", "mix", "--clock-drift", "50"}));
}

TEST_F(KinematicsJob, WithAPlanarMotorIsInPlace) {
  ExpectAllMadeInPlace(RunOn(kMachines + "planar.textproto"));
}

/// That of the same points without any limit of the stage but its laser's rate.
constexpr double kIdealUtilisation = 1;

// Trochimczuk 2008, ch. 7 and 8: each positioner engraves the whole object, and none
// stands behind the screws by more than its limits make it.
TEST_F(KinematicsJob, EachPositionerEngravesAScan) {
  const char* meshes = std::getenv("INTAGLIO_MESHES");
  if (meshes == nullptr) {
    GTEST_SKIP()
        << "INTAGLIO_MESHES names no folder with bunny.obj; WithArmAndRotaryTable"
           "IsInPlace and WithAPlanarMotorIsInPlace have a knot";
  }
  const fs::path job = folder_ / "bunny.textproto";
  std::ofstream(job) << "models { file: \"" << meshes
                     << "/bunny.obj\" placement { up: UP_AXIS_Y fit_size_mm: 12 "
                        "centre_in_block: true } }\n"
                        "block { size_mm { x: 40 y: 40 z: 30 } }\nglass: \"N-BK7\"\n"
                        "machine_file: \""
                     << kMachines
                     << "els-03.textproto\"\n"
                        "laser { rate_hz: 100 }\n"
                        "discretization { min_spacing_mm: 0.6 }\n";
  for (const char* machine : {"els-03", "planar", "polar"}) {
    Running run(Program("intaglio"),
                Arguments({"--lockstep", "--warm-up", "0", "--machine",
                           kMachines + machine + ".textproto"},
                          job),
                folder_ / "output.txt");
    const Ended ended = run.WaitForEnd(testing::kBound);
    ASSERT_EQ(ended.exit_code, 0) << machine << "\n" << ended.output;
    const JobReport report = Report();
    EXPECT_TRUE(report.verdict().good()) << machine;
    EXPECT_GT(report.points().planned(), 300u);
    EXPECT_EQ(report.points().made(), report.points().planned()) << machine;
    EXPECT_LT(FarthestCrackMm(Path()), 0.03) << machine;
    // As planned: a busy computer may pause a job.
    const double utilisation = static_cast<double>(report.points().planned()) /
                               static_cast<double>(report.engrave().estimate_ticks());
    EXPECT_GT(utilisation, 0.5) << machine;
    EXPECT_LE(utilisation, 1.01 * kIdealUtilisation) << machine;
    std::cout << machine << ": " << report.points().made() << " points, " << utilisation
              << " a tick of an ideal machine's " << kIdealUtilisation << ", "
              << report.position_errors().max_um() << " um at most\n";
    fs::remove_all(folder_ / "out");
  }
}

// The in-position output is measured at the focus: 30 um are 0.2 mrad of the arm.
TEST_F(KinematicsJob, AStuckArmMakesNoStrayCrack) {
  const Ended run = RunOn(kMachines + "polar.textproto", {"--fault", "9000 stick x"});
  ASSERT_TRUE(run.in_time);
  EXPECT_NE(run.exit_code, 0) << run.output;
  const PointCounts points = Report().points();
  EXPECT_GT(points.made(), 100u);
  EXPECT_LT(points.made(), points.planned());
  EXPECT_EQ(points.stray() + points.doubled(), 0u);
  EXPECT_LT(Report().position_errors().max_um(), 30) << "the tolerance";
}

TEST_F(KinematicsJob, OutOfTheArmsReachIsRefusedWithTheRemedy) {
  const Ended run = RunOn(kMachines + "polar.textproto", {"--block", "400", "50", "30"});
  EXPECT_EQ(run.exit_code, 2) << run.output;
  EXPECT_THAT(run.output, ::testing::AllOf(::testing::HasSubstr("block.size_mm"),
                                           ::testing::HasSubstr("the arm serves"),
                                           ::testing::HasSubstr("block_origin_mm")));
}

}  // namespace
}  // namespace intaglio
