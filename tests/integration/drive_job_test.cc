// The drives of a profile in the virtual engraver, which integrates its equation in code
// of its own: the points are made within the tolerance, and where the plan predicts.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <regex>

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

class DriveOfAProfile : public RunJob, public ::testing::WithParamInterface<NamedDrive> {
 protected:
  fs::path WriteProfile() const {
    std::string machine =
        testing::TextIn(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
    const std::string line = "\nstage_lag_s: 0.0002";
    std::ofstream(folder_ / "drive.textproto") << machine.replace(
        machine.find(line), line.size(), std::string("\n") + GetParam().profile);
    return folder_ / "drive.textproto";
  }

  /// Of `intaglio plan` for the path of the job, um: rms and largest.
  std::pair<double, double> Predicted(const fs::path& profile) {
    Running run(Program("intaglio"),
                {"plan", "--path", (folder_ / "out/path.ply").string(), "--block", "50",
                 "50", "30", "--machine", profile.string(), "--materials",
                 (folder_ / "materials.db").string(), "--out",
                 (folder_ / "predicted.ply").string()},
                folder_ / "plan.txt");
    const std::string text = run.WaitForEnd(testing::kBound).output;
    static const std::regex kFigures(R"(prediction +([\d.]+) um rms, ([\d.]+) um)");
    std::smatch match;
    EXPECT_TRUE(std::regex_search(text, match, kFigures)) << text;
    return match.empty() ? std::pair(0.0, 0.0)
                         : std::pair(std::stod(match[1]), std::stod(match[2]));
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

TEST_P(DriveOfAProfile, MakesAllPointsWhereThePlanPredicts) {
  const fs::path profile = WriteProfile();
  const Ended run = Run({"--lockstep", "--warm-up", "0", "--spacing", "0.6", "--machine",
                         profile.string()});
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const JobReport report = Report();
  EXPECT_TRUE(report.verdict().good());
  EXPECT_EQ(report.points().made(), report.points().planned());
  const auto [rms_um, max_um] = Predicted(profile);
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
                   "inertia_ratio: 0.3 }"}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace intaglio
