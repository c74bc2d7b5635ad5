// The drives of a profile in the virtual engraver, which integrates its equation in code
// of its own: the points are made within the tolerance, and where the plan predicts.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <regex>
#include <string>

#include "engrave/formats/glass_record.h"
#include "engrave/formats/point_file.h"
#include "tests/integration/run_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using testing::Ended;
using testing::Program;
using testing::RunJob;
using testing::Running;

struct NamedDrive {
  const char* name;
  const char* profile;
};

/// What `intaglio plan` predicts, um.
struct Prediction {
  double rms_um = 0, max_um = 0;
  double wrong_mechanics_max_um = 0;
  std::string text;
};

class JobWithADrive : public RunJob {
 protected:
  fs::path WriteProfile(const std::string& drive) const {
    std::string machine =
        testing::TextIn(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
    const std::string line = "\nstage_lag_s: 0.0002";
    std::ofstream(folder_ / "drive.textproto")
        << machine.replace(machine.find(line), line.size(), "\n" + drive);
    return folder_ / "drive.textproto";
  }

  /// For the path of the job.
  Prediction Predicted(const fs::path& profile) {
    Running run(Program("intaglio"),
                {"plan", "--path", (folder_ / "out/path.ply").string(), "--block", "50",
                 "50", "30", "--machine", profile.string(), "--materials",
                 (folder_ / "materials.db").string(), "--out",
                 (folder_ / "predicted.ply").string()},
                folder_ / "plan.txt");
    const std::string text = run.WaitForEnd(testing::kBound).output;
    static const std::regex kFigures(
        R"(prediction +([\d.]+) um rms, ([\d.]+) um[^\n]*\nmargin +([\d.]+) um)");
    std::smatch match;
    EXPECT_TRUE(std::regex_search(text, match, kFigures)) << text;
    if (match.empty()) return {};
    return {std::stod(match[1]), std::stod(match[2]), std::stod(match[3]), text};
  }

  /// Rms of the column of the copy that `plan --out` has written, um.
  double OfEachPoint() const {
    const auto table = formats::ReadPly(folder_ / "predicted.ply");
    EXPECT_TRUE(table.has_value());
    for (const formats::NamedColumn& column : table->columns) {
      if (column.name != "predicted_error_um") continue;
      double sum = 0;
      const auto& errors_um = std::get<std::vector<double>>(column.values);
      for (const double error_um : errors_um) sum += error_um * error_um;
      return std::sqrt(sum / static_cast<double>(errors_um.size()));
    }
    return -1;
  }
};

class DriveOfAProfile : public JobWithADrive,
                        public ::testing::WithParamInterface<NamedDrive> {};

TEST_P(DriveOfAProfile, MakesAllPointsWhereThePlanPredicts) {
  const fs::path profile = WriteProfile(GetParam().profile);
  const Ended run = Run({"--lockstep", "--warm-up", "0", "--spacing", "0.6", "--machine",
                         profile.string()});
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const JobReport report = Report();
  EXPECT_TRUE(report.verdict().good());
  EXPECT_EQ(report.points().made(), report.points().planned());
  const Prediction predicted = Predicted(profile);
  const double rms_um = predicted.rms_um, max_um = predicted.max_um;
  EXPECT_GT(rms_um, 0.1) << "a drive that leaves nothing predicts nothing";
  EXPECT_NEAR(OfEachPoint(), rms_um, 0.006) << "of all points, as printed";
  EXPECT_NEAR(report.position_errors().rms_um(), rms_um, 0.1 * rms_um);
  EXPECT_NEAR(report.position_errors().max_um(), max_um, 0.2 * max_um);
}

INSTANTIATE_TEST_SUITE_P(
    Of, DriveOfAProfile,
    ::testing::Values(
        NamedDrive{"SecondOrder",
                   "second_order { natural_frequency_hz: 120 damping_ratio: 0.7 }"},
        NamedDrive{"Servo", "servo { position_gain_per_s: 500 velocity_time_s: 0.0004 }"},
        NamedDrive{"ServoWithFeedForward",
                   "servo { position_gain_per_s: 150 velocity_time_s: 0.002 "
                   "derivative_ratio: 0.2 feed_forward_ratio: 1 }"},
        NamedDrive{"Cascade",
                   "cascade { position_gain_per_s: 1000 natural_frequency_hz: 300 "
                   "damping_ratio: 0.5 }"},
        NamedDrive{"StepperScrew",
                   "stepper_screw { rotor_frequency_hz: 150 rotor_damping_ratio: 0.5 "
                   "carriage_frequency_hz: 500 carriage_damping_ratio: 0.1 "
                   "inertia_ratio: 0.3 }"},
        // Sampled every 0.2 ms.
        NamedDrive{"Planar",
                   "planar_drive { natural_frequency_hz: 80 damping_ratio: 0.7 "
                   "integral_rate_per_s: 20 }"},
        NamedDrive{"OfEachAxis",
                   "second_order { natural_frequency_hz: 120 damping_ratio: 0.7 } "
                   "axis_drives { axis: 'y' servo { position_gain_per_s: 500 "
                   "velocity_time_s: 0.0004 } } axis_drives { axis: 'z' stage_lag_s: "
                   "0.001 }"},
        // So weak that the plan has to slow down.
        NamedDrive{"Weak",
                   "second_order { natural_frequency_hz: 50 damping_ratio: 0.7 }"}),
    [](const auto& tested) { return tested.param.name; });

// The machine is not as its profile says: what the plan gives as its margin bounds what
// the glass has.
class WrongMechanics : public JobWithADrive {
 protected:
  /// The largest error in the glass, um.
  double InTheGlassUm(const fs::path& profile, const std::string& drive) {
    const fs::path truth = folder_ / "truth.textproto";
    std::ofstream(truth) << "stage { " << drive << " }";
    const Ended run = Run({"--lockstep", "--warm-up", "0", "--spacing", "0.8",
                           "--machine", profile.string(), "--truth", truth.string()});
    EXPECT_TRUE(run.in_time);
    return Report().position_errors().max_um();
  }
};

TEST_F(WrongMechanics, ThePlansMarginHolds) {
  const fs::path profile =
      WriteProfile("second_order { natural_frequency_hz: 300 damping_ratio: 0.7 }");
  double largest_um = 0;
  for (const char* wrong : {"natural_frequency_hz: 285 damping_ratio: 0.7",
                            "natural_frequency_hz: 315 damping_ratio: 0.7",
                            "natural_frequency_hz: 300 damping_ratio: 0.56",
                            "natural_frequency_hz: 300 damping_ratio: 0.84"}) {
    largest_um = std::max(
        largest_um, InTheGlassUm(profile, std::string("second_order { ") + wrong + " }"));
  }
  EXPECT_TRUE(Report().verdict().good());
  const Prediction predicted = Predicted(profile);
  EXPECT_NE(predicted.text.find("within the tolerance"), std::string::npos)
      << predicted.text;
  EXPECT_GT(predicted.wrong_mechanics_max_um, predicted.max_um);
  EXPECT_NEAR(largest_um, predicted.wrong_mechanics_max_um,
              0.1 * predicted.wrong_mechanics_max_um);
}

TEST_F(WrongMechanics, ThePlanReportsThatItsMarginWillNotHold) {
  const fs::path profile =
      WriteProfile("second_order { natural_frequency_hz: 80 damping_ratio: 0.7 }");
  const double in_glass_um = InTheGlassUm(
      profile, "second_order { natural_frequency_hz: 80 damping_ratio: 0.56 }");
  const Prediction predicted = Predicted(profile);
  EXPECT_NE(predicted.text.find("BEYOND the tolerance"), std::string::npos)
      << predicted.text;
  EXPECT_LT(predicted.max_um, 30) << "with the mechanics of the profile it holds";
  EXPECT_GT(in_glass_um, 30) << "the machine's tolerance";
}

// Steps of 10 um, the coarsest resolution of a planar drive in Trochimczuk 2008, table 5.
class StepsOfAProfile : public JobWithADrive {
 protected:
  fs::path WriteProfileWithSteps(const std::string& drive, int steps_per_mm) {
    const fs::path file = WriteProfile(drive);
    const std::string steps = " steps_per_mm: " + std::to_string(steps_per_mm);
    std::string machine = testing::TextIn(file);
    for (const char* axis : {"\nx {", "\ny {"})
      machine.insert(machine.find(axis) + 4, steps);
    std::ofstream(file) << machine;
    return file;
  }
};

// A stage that stops at each point makes its crack where both axes have a step, wherever
// the point is: uniform within half a step on each, so that the distances have
// 10 um / sqrt(6) rms, and what the stop leaves is below 0.1 um.
TEST_F(StepsOfAProfile, AreInTheGlassAndInTheProof) {
  const fs::path profile = WriteProfileWithSteps("stage_lag_s: 0", 100);
  const Ended run = Run({"--lockstep", "--warm-up", "0", "--spacing", "0.8", "--profile",
                         "mix", "--machine", profile.string()});
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const JobReport report = Report();
  EXPECT_TRUE(report.verdict().good());
  EXPECT_EQ(report.points().made(), report.points().planned());
  EXPECT_NEAR(report.position_errors().rms_um(), 10 / std::sqrt(6), 0.2);
  EXPECT_LE(report.position_errors().max_um(), std::hypot(5, 5) + 0.1);
  const auto glass = formats::ReadGlassRecord(folder_ / "out/session/glass.rec");
  ASSERT_TRUE(glass.has_value());
  ASSERT_EQ(glass->cracks.size(), report.points().planned());
  for (const formats::GlassCrack& crack : glass->cracks) {
    for (int axis = 0; axis < 2; ++axis) {
      const double steps = crack.position_mm[axis] * 100;
      ASSERT_NEAR(steps, std::round(steps), 0.01) << "the block's corner is at zero";
    }
  }
}

TEST_F(StepsOfAProfile, AreInTheMarginOfThePlan) {
  const fs::path without = WriteProfile("stage_lag_s: 0.0002");
  ASSERT_EQ(Run({"--lockstep", "--warm-up", "0", "--spacing", "0.8"}).exit_code, 0);
  const Prediction smooth = Predicted(without);
  const Prediction stepped = Predicted(WriteProfileWithSteps("stage_lag_s: 0.0002", 100));
  EXPECT_NEAR(stepped.wrong_mechanics_max_um - smooth.wrong_mechanics_max_um,
              std::hypot(5, 5), 0.011);
  EXPECT_EQ(stepped.max_um, smooth.max_um) << "that of the drive alone";
}

TEST_F(StepsOfAProfile, ThatLeaveNoRoomAreRefused) {
  const Ended run =
      Run({"--machine", WriteProfileWithSteps("stage_lag_s: 0", 20).string()});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.output, ::testing::HasSubstr("x.steps_per_mm: 20"));
}

// Under way a planar drive of a servo cycle of 0.2 ms passes the points between its
// steps.
TEST_F(StepsOfAProfile, OfAPlanarDriveKeepThePointsInTheirPlaces) {
  const std::string drive =
      "planar_drive { natural_frequency_hz: 100 damping_ratio: 0.7 "
      "integral_rate_per_s: 20 period_s: 0.0002 }";
  const auto rms_um = [&](const fs::path& profile) {
    const Ended run = Run({"--lockstep", "--warm-up", "0", "--spacing", "0.8",
                           "--machine", profile.string()});
    EXPECT_EQ(run.exit_code, 0) << run.output;
    EXPECT_TRUE(Report().verdict().good());
    EXPECT_EQ(Report().points().made(), Report().points().planned());
    return Report().position_errors().rms_um();
  };
  const double smooth_um = rms_um(WriteProfile(drive));
  const double stepped_um = rms_um(WriteProfileWithSteps(drive, 100));
  RecordProperty("smooth_um", std::to_string(smooth_um));
  RecordProperty("stepped_um", std::to_string(stepped_um));
  EXPECT_GT(stepped_um, smooth_um);
  EXPECT_LT(stepped_um, std::hypot(smooth_um, std::hypot(5, 5)));
}

// The positions that the controller reports at every tick of a job give the drive back.
TEST_F(JobWithADrive, IsIdentifiedFromTheRecordingOfAJob) {
  const fs::path truth = folder_ / "truth.textproto";
  std::ofstream(truth)
      << "stage { second_order { natural_frequency_hz: 130 damping_ratio: 0.6 } }";
  const fs::path profile =
      WriteProfile("second_order { natural_frequency_hz: 120 damping_ratio: 0.7 }");
  const Ended job = Run({"--lockstep", "--warm-up", "0", "--spacing", "0.8", "--record",
                         "--machine", profile.string(), "--truth", truth.string()});
  ASSERT_TRUE(job.in_time);
  fs::path recording;
  for (const auto& entry : fs::recursive_directory_iterator(folder_ / "out")) {
    if (entry.path().extension() == ".mcap") recording = entry.path();
  }
  ASSERT_FALSE(recording.empty()) << job.output;
  Running run(Program("intaglio"),
              {"drive", "identify", recording.string(), "--axis", "y"},
              folder_ / "identified.txt");
  const Ended identified = run.WaitForEnd(testing::kBound);
  ASSERT_EQ(identified.exit_code, 0) << identified.output;
  static const std::regex kFound(
      R"(natural_frequency_hz +([\d.]+)[^\n]*\ndamping_ratio +([\d.]+))");
  std::smatch match;
  ASSERT_TRUE(std::regex_search(identified.output, match, kFound)) << identified.output;
  EXPECT_NEAR(std::stod(match[1]), 130, 0.02 * 130);
  EXPECT_NEAR(std::stod(match[2]), 0.6, 0.1 * 0.6);
}

}  // namespace
}  // namespace intaglio
