// The job of a test cube, its table, and the profile that follows from a measurement.

#include "services/client/machine/cube_measurement.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "engrave/optics/focus.h"
#include "services/client/machine/corrected_head.h"
#include "services/client/machine/cube_job.h"
#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/files/job_file.h"
#include "services/job/machine/machine_defaults.h"
#include "tests/test_folder.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string Supplied(const std::string& name) {
  return INTAGLIO_SOURCE_DIR "/deploy/machines/" + name + ".textproto";
}

class TestCube : public ::testing::Test {
 protected:
  Result<std::vector<MeasuredCubeMark>> Read(const std::string& text) {
    std::ofstream(folder_ / "cube.csv") << text;
    return ReadMeasuredCube(folder_ / "cube.csv");
  }
  fs::path folder_ = test::FreshFolder();
};

constexpr const char* kNames =
    "mark,x_mm,y_mm,z_mm,measured_x_mm,measured_y_mm,measured_z_mm\n";

TEST_F(TestCube, ItsJobFillsWhatTheLaserReaches) {
  const auto job = WriteCubeJob({Supplied("galvo-glass"), Vec3(60, 60, 60)}, folder_);
  ASSERT_TRUE(job) << job.error().message;
  EXPECT_TRUE(fs::exists(folder_ / "cube.ply"));
  std::ifstream table(folder_ / "cube.csv");
  std::string line;
  double farthest_mm = 0;
  int rows = 0;
  std::getline(table, line);
  EXPECT_EQ(line + "\n", kNames);
  while (std::getline(table, line)) {
    double x = 0, y = 0, z = 0;
    int mark = 0;
    ASSERT_EQ(std::sscanf(line.c_str(), "%d,%lf,%lf,%lf,,,", &mark, &x, &y, &z), 4);
    EXPECT_EQ(mark, ++rows);
    EXPECT_TRUE(z == 5 || z == 55) << z;
    farthest_mm = std::max(farthest_mm, std::hypot(x - 30, y - 30));
  }
  EXPECT_EQ(rows, 50);
  // The docs have .53 of the intensity at 8 degrees and 60 mm: 0.3 mJ are enough there,
  // some 20 mm from the axis.
  EXPECT_GT(farthest_mm, 10);
  EXPECT_LT(farthest_mm, 22);
  const auto spec = ReadJobFile(*job);
  ASSERT_TRUE(spec) << spec.error().message;
  EXPECT_TRUE(spec->models(0).placement().has_centre_in_block());
  EXPECT_FALSE(spec->models(0).placement().centre_in_block());

  EXPECT_THAT(WriteCubeJob({Supplied("els-03")}, folder_).error().message,
              HasSubstr("for scan heads over a block"));
  EXPECT_EQ(
      WriteCubeJob({Supplied("galvo-glass"), Vec3(60, 60, 9)}, folder_).error().code,
      ErrorCode::kOutsideBlock);
}

TEST_F(TestCube, ItsTableHasWhatWasMeasured) {
  const auto marks = Read(std::string(kNames) +
                          "1,5,5,5,5.01,,4.9\n2,15,5,5,,,\n3,25,5,5,25.1,5.2,5.3\n");
  ASSERT_TRUE(marks) << marks.error().message;
  ASSERT_EQ(marks->size(), 2u);
  EXPECT_EQ(marks->at(0).wanted_mm, Vec3(5, 5, 5));
  EXPECT_EQ(marks->at(0).measured_mm.x(), 5.01);
  EXPECT_TRUE(std::isnan(marks->at(0).measured_mm.y()));
  EXPECT_EQ(marks->at(1).number, 3);
  const auto german = Read(
      "mark;x_mm;y_mm;z_mm;measured_x_mm;measured_y_mm;measured_z_mm\n1;5;5;5;5,01;;\n");
  ASSERT_TRUE(german);
  EXPECT_EQ(german->at(0).measured_mm.x(), 5.01);
  EXPECT_THAT(Read("mark,x_mm,y_mm\n1,2,3\n").error().message,
              HasSubstr("has no column z_mm; fill in the table cube.csv"));
  EXPECT_THAT(Read(std::string(kNames) + "1,5,5,5,two,,\n").error().message,
              HasSubstr("line 2, measured_x_mm: 'two' is not a number"));
  EXPECT_THAT(Read(std::string(kNames) + "0,5,5,5,1,,\n").error().message,
              HasSubstr("line 2, mark: 0 is no number of a mark"));
}

FrozenJob Frozen() {
  FrozenJob frozen;
  *frozen.mutable_machine() =
      WithMachineDefaults(ReadMachineFile(Supplied("galvo-glass")).value());
  JobSpec job;
  for (const auto set : {&Vector3::set_x, &Vector3::set_y, &Vector3::set_z}) {
    (job.mutable_block()->mutable_size_mm()->*set)(60);
  }
  *frozen.mutable_job() = WithDefaults(job, frozen.machine());
  frozen.mutable_optics()->set_stage_per_glass_ratio(
      optics::StagePerGlassRatio(1.519473, 0.03));
  return frozen;
}

calibrate::CubeFit RightFit() {
  calibrate::CubeFit fit;
  const calibrate::HeadState known = KnownHeadOf(Frozen());
  for (std::size_t i = 0; i < known.size(); ++i) {
    fit.figures[i] = {{known[i], 1e-5}, calibrate::FigureState::kAsKnown};
  }
  return fit;
}

void Find(calibrate::CubeFit& fit, calibrate::HeadUnknown unknown, double value) {
  fit.figures[unknown] = {{value, 1e-5}, calibrate::FigureState::kFound};
}

TEST_F(TestCube, ARightHeadKeepsItsProfile) {
  const auto corrected = CorrectHead(Frozen(), RightFit());
  EXPECT_THAT(corrected.corrections, IsEmpty());
  EXPECT_THAT(corrected.remarks, IsEmpty());
  EXPECT_EQ(corrected.machine.SerializeAsString(),
            Frozen().machine().SerializeAsString());
  const calibrate::HeadState known = KnownHeadOf(Frozen());
  EXPECT_NEAR(known[calibrate::kIndex], 1.519473, 1e-6);
  EXPECT_EQ(known[calibrate::kTop], 60);
  EXPECT_NEAR(known[calibrate::kPupilY], 1 / 135.0, 1e-12);
}

TEST_F(TestCube, TheProfileHasWhatWasFound) {
  calibrate::CubeFit fit = RightFit();
  Find(fit, calibrate::kXScale, 1.0123);
  Find(fit, calibrate::kRotation, -0.004);
  Find(fit, calibrate::kPupilX, 1 / 148.0);
  Find(fit, calibrate::kZRatio, 1.02);
  Find(fit, calibrate::kTop, 60.5);
  Find(fit, calibrate::kTiltX, 0.003);
  Find(fit, calibrate::kLeanY, -0.002);
  fit.figures[calibrate::kTiltY].state = calibrate::FigureState::kUndetermined;
  const auto corrected = CorrectHead(Frozen(), fit);
  EXPECT_THAT(corrected.corrections,
              ElementsAre("head_over_block.field.x_scale_ratio: 1 -> 1.0123",
                          "head_over_block.field.rotation_rad: 0 -> -0.004",
                          "head_over_block.pupil_x_mm: 140 -> 148",
                          "head_over_block.z.scale_ratio: 1 -> 1.02",
                          "block_origin_mm.z: 0 -> 0.5"));
  EXPECT_THAT(corrected.remarks,
              ElementsAre(HasSubstr("rises by 0.300 mm in 100 mm of +x"),
                          HasSubstr("goes 0.200 mm to -y while z rises"),
                          HasSubstr("not determined: tilt y:")));
  EXPECT_THAT(CheckMachine(corrected.machine), IsEmpty());
  EXPECT_EQ(corrected.machine.head_over_block().pupil_y_mm(), 135);
}

// Beyond what a profile may have the machine itself is to be corrected.
TEST_F(TestCube, ARatioOutsideItsRangeIsARemark) {
  calibrate::CubeFit fit = RightFit();
  Find(fit, calibrate::kZRatio, 1.4);
  EXPECT_THAT(CorrectHead(Frozen(), fit).remarks,
              Contains(HasSubstr("correct the machine first")));
}

}  // namespace
}  // namespace intaglio::client
