// What `intaglio course plan` writes, read again and checked without our code.

#include "services/cli/course/course_command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>

#include "services/cli/course/course_job.h"
#include "services/cli/course/course_program.h"
#include "services/client/exit_codes.h"
#include "services/job/drive/drive_profile.h"
#include "services/job/files/job_file.h"
#include "services/job/plan/course_motion.h"
#include "tests/services/cli/typed_command.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr const char* kProfile = INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto";

class CourseCommand : public TypedCommand {
 protected:
  CourseCommand() {
    // Two rows of lines that meet: a square of 20 mm and a zigzag.
    std::ofstream(drawing_)
        << R"(<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm" viewBox="0 0 60 40">)"
        << R"(<line x1="5" y1="5" x2="25" y2="5"/><line x1="25" y1="5" x2="25" y2="25"/>)"
        << R"(<line x1="25" y1="25" x2="5" y2="25"/><line x1="5" y1="25" x2="5" y2="5"/>)"
        << R"(<polyline points="30,5 35,15 40,5 45,15" fill="none" stroke="black"/></svg>)";
    std::string profile = test::ContentOf(kProfile);
    const std::string lag = "stage_lag_s: 0.0002";
    profile.replace(profile.find(lag), lag.size(),
                    "second_order { natural_frequency_hz: 30 damping_ratio: 0.4 }");
    std::ofstream(soft_) << profile;
  }

  int Type(std::vector<std::string> words) {
    words.insert(words.begin(), {"course", "plan"});
    return TypeTo(AddCourseCommand, words);
  }

  std::string drawing_ = folder_ / "part.svg", soft_ = folder_ / "soft.textproto";
  std::string csv_ = folder_ / "course.csv", picture_ = folder_ / "course.png";
};

/// From the outline of the square; y is that of the page, flipped.
double FromSquare(double x, double y) {
  const double u = std::abs(x - 15) - 10, v = std::abs(y - 25) - 10;
  if (u <= 0 && v <= 0) return -std::max(u, v);
  return std::hypot(std::max(u, 0.0), std::max(v, 0.0));
}

TEST_F(CourseCommand, TheTableKeepsTheTolerance) {
  ASSERT_EQ(Type({drawing_, "--machine", soft_, "--feed", "60", "--tolerance", "80",
                  "--compensate", "--csv", csv_, "--picture", picture_}),
            client::kExitGood)
      << output_ << errors_;
  std::ifstream in(csv_);
  std::string line;
  std::getline(in, line);
  EXPECT_EQ(line,
            "contour,time_s,setpoint_x_mm,setpoint_y_mm,actual_x_mm,actual_y_mm,s_mm,"
            "speed_mm_s,deviation_um");
  int contours = 0, rows = 0;
  double worst_um = 0, greatest_mm_s = 0;
  while (std::getline(in, line)) {
    int contour = 0;
    std::array<double, 8> v{};
    ASSERT_EQ(std::sscanf(line.c_str(), "%d,%lf,%lf,%lf,%lf,%lf,%lf,%lf,%lf", &contour,
                          &v[0], &v[1], &v[2], &v[3], &v[4], &v[5], &v[6], &v[7]),
              9)
        << line;
    contours = std::max(contours, contour);
    ++rows;
    greatest_mm_s = std::max(greatest_mm_s, v[6]);
    EXPECT_LE(v[7], 80.1);
    if (contour != 1) continue;
    const double um = 1000 * FromSquare(v[3], v[4]);
    worst_um = std::max(worst_um, um);
    // The table has the error since the row before where that is greater.
    EXPECT_LE(um, v[7] + 0.01) << line;
  }
  EXPECT_EQ(contours, 2) << "four lines that meet are one contour";
  EXPECT_GT(rows, 1000);
  EXPECT_GT(worst_um, 20) << "corners are rounded, not stopped at";
  EXPECT_NEAR(greatest_mm_s, 60, 1e-6);
  EXPECT_THAT(output_, HasSubstr("contours      2, 7 segments"));
  EXPECT_THAT(output_, HasSubstr("allowed 80.0 um"));
  EXPECT_GT(fs::file_size(picture_), 5000U);
}

TEST_F(CourseCommand, WithAReserveTheMarginHolds) {
  Type({drawing_, "--machine", soft_, "--tolerance", "80", "--compensate"});
  EXPECT_THAT(output_, HasSubstr("margin        does not hold"));
  EXPECT_EQ(Type({drawing_, "--machine", soft_, "--tolerance", "80", "--compensate",
                  "--reserve"}),
            client::kExitGood);
  EXPECT_THAT(output_, HasSubstr("margin        holds"));
}

TEST_F(CourseCommand, ErrorsNameFileAndRemedy) {
  const std::string other = folder_ / "part.stl";
  EXPECT_EQ(Type({other, "--machine", soft_}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("is no drawing; give one that ends in"));
  const std::string absent = folder_ / "absent.dxf";
  EXPECT_EQ(Type({absent, "--machine", soft_}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("absent.dxf"));
  const std::string empty = folder_ / "empty.svg";
  std::ofstream(empty) << R"(<svg xmlns="http://www.w3.org/2000/svg"/>)";
  EXPECT_EQ(Type({empty, "--machine", soft_}), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("empty.svg"));
  EXPECT_EQ(Type({drawing_, "--machine", "polar"}), client::kExitWrongInput);
}

TEST_F(CourseCommand, TheAxesOfADriveProfileFollow) {
  const std::string drive = INTAGLIO_SOURCE_DIR "/deploy/drives/tirnovean-2016.textproto";
  const DriveProfile profile = ReadDriveProfile(drive).value();
  const course::AxisPair axes = CourseAxesOf(profile).value();
  // docs of the drive: K of Kp 20480 in V per mm is 327.5 1/s, and the lag is 1 / K.
  EXPECT_NEAR(axes[0].lag_s(), 1 / 327.5, 1e-3 / 327.5);
  // y carries less on a shorter screw: the same K, faster mechanics.
  EXPECT_NEAR(axes[1].lag_s(), axes[0].lag_s(), 1e-12);
  EXPECT_GT(axes[1].parameters().natural_rad_s, axes[0].parameters().natural_rad_s);
  EXPECT_EQ(Type({drawing_, "--machine", "soft", "--drive", drive}),
            client::kExitWrongInput);
  EXPECT_EQ(Type({drawing_, "--machine", soft_, "--drive", drive, "--feed", "60",
                  "--tolerance", "100", "--acceleration", "1500", "--compensate"}),
            client::kExitGood)
      << output_ << errors_;
  DriveProfile derivative = profile;
  derivative.mutable_axes(1)->mutable_panel()->set_derivative_s(10);
  EXPECT_THAT(CourseAxesOf(derivative).error().message, HasSubstr("axis y: panel"));
}

TEST_F(CourseCommand, AProfileWithoutAxesIsNamedWithWhatIsMissing) {
  const std::string mill = INTAGLIO_SOURCE_DIR "/deploy/machines/mill.textproto";
  const std::string drive = INTAGLIO_SOURCE_DIR "/deploy/drives/tirnovean-2016.textproto";
  std::vector<std::string> words = {drawing_, "--machine", mill, "--feed", "60"};
  EXPECT_EQ(Type(words), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("mill: its profile has no x and y, whose limits and "
                                 "drives a course is planned with; give --acceleration, "
                                 "--tolerance, --drive, or name"));
  words.insert(words.end(), {"--tolerance", "100", "--acceleration", "1500"});
  EXPECT_EQ(Type(words), client::kExitWrongInput);
  EXPECT_THAT(errors_, HasSubstr("give --drive, or name"));
  words.insert(words.end(), {"--drive", drive, "--compensate"});
  EXPECT_EQ(Type(words), client::kExitGood) << output_ << errors_;
}

TEST(CourseJob, AxesAreThoseOfTheProfile) {
  MachineSpec machine = ReadMachineFile(kProfile).value();
  const course::AxisPair lagging = CourseAxesOf(machine).value();
  EXPECT_NEAR(lagging[0].lag_s(), 0.0002, 1e-12);
  machine.mutable_second_order()->set_natural_frequency_hz(30);
  machine.mutable_second_order()->set_damping_ratio(0.4);
  const course::AxisPair elastic = CourseAxesOf(machine).value();
  // The lag of the same drive, by its equation: 2 d / w.
  EXPECT_NEAR(elastic[1].lag_s(), 2 * 0.4 / (2 * 3.14159265358979 * 30), 1e-12);
  CascadeDrive& cascade = *machine.mutable_cascade();
  cascade.set_position_gain_per_s(120);
  cascade.set_natural_frequency_hz(25);
  cascade.set_damping_ratio(0.3);
  const course::AxisPair looped = CourseAxesOf(machine).value();
  EXPECT_EQ(looped[0].product().size(), 6U);
  EXPECT_NEAR(looped[0].lag_s(), 1 / 120.0 + 0.6 / (2 * 3.14159265358979 * 25), 1e-12);
  // A servo alone is of second order; y has the drive that it is given.
  machine.mutable_servo()->set_position_gain_per_s(100);
  machine.mutable_servo()->set_velocity_time_s(0.004);
  AxisDrive& of_y = *machine.add_axis_drives();
  of_y.set_axis("y");
  of_y.set_stage_lag_s(0.003);
  const course::AxisPair mixed = CourseAxesOf(machine).value();
  EXPECT_NEAR(mixed[0].lag_s(), 1 / 100.0, 1e-12);
  EXPECT_NEAR(mixed[0].parameters().natural_rad_s, std::sqrt(100 / 0.004), 1e-9);
  EXPECT_NEAR(mixed[1].lag_s(), 0.003, 1e-12);
  machine.mutable_servo()->set_feed_forward_ratio(1);
  EXPECT_THAT(CourseAxesOf(machine).error().message, HasSubstr("feed_forward_ratio 0"));
  EXPECT_EQ(CourseFeedOf(machine), 80);
  machine.mutable_y()->set_max_acceleration_mm_s2(3000);
  machine.mutable_y()->set_max_jerk_mm_s3(1e5);
  EXPECT_EQ(CourseLimitsOf(machine).acceleration_mm_s2, 3000);
  EXPECT_EQ(CourseLimitsOf(machine).jerk_mm_s3, 1e5);
}

}  // namespace
}  // namespace intaglio::cli
