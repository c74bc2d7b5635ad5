// A scan head over a block with a wrong field, lens and z makes its test cube, is
// measured by it, corrected, and makes the cube again. The virtual glass head has the
// errors by its own physics (services/virtual_engraver positioner.h); its glass is what
// is measured.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <sstream>

#include "proto/machine_report.pb.h"
#include "tests/integration/run_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using testing::Ended;
using ::testing::HasSubstr;

constexpr double kNoiseMm = 0.005;  // of a scan

class HeadMeasure : public testing::RunJob {
 protected:
  HeadMeasure() {
    // The corners need ten times the energy of the supplied laser.
    std::string text = testing::TextIn(fs::path(INTAGLIO_SOURCE_DIR) /
                                       "deploy/machines/galvo-glass.textproto");
    const std::string weak = "pulse_energy_mj: 0.3";
    text.replace(text.find(weak), weak.size(), "pulse_energy_mj: 3");
    // The lens is not above the middle of the block.
    const std::string middle = "x: -30 y: -30 z: 0";
    text.replace(text.find(middle), middle.size(), "x: -29 y: -30.5 z: 0");
    std::ofstream(folder_ / "machine.textproto") << text;
    std::ofstream(folder_ / "truth.textproto")
        << "stage { positioner {\n"
           "  mirrors { pupil_x_mm: 150 pupil_y_mm: 128 crack_energy_mj: 0.08 }\n"
           "  x { travel_ratio: 1.015 turn_rad: 0.004 }\n"
           "  y { travel_ratio: 0.985 turn_rad: 0.002 }\n"
           "  z { travel_ratio: 1.01 } } }\n";
  }
  Ended Intaglio(const std::vector<std::string>& words) const {
    testing::Running program(testing::Program("intaglio"), words, folder_ / "output.txt");
    return program.WaitForEnd(2 * testing::kBound);
  }
  /// The cube of a profile, engraved in `name`.
  void Engrave(const fs::path& profile, const std::string& name) const {
    const fs::path job = folder_ / (name + "-job");
    const Ended made = Intaglio({"machine", "measure", "--machine", profile.string(),
                                 "--block", "60", "60", "60", "--out", job.string()});
    ASSERT_EQ(made.exit_code, 0) << made.output;
    const Ended run = Intaglio(
        {"run", (job / "cube.textproto").string(), "--lockstep", "--warm-up", "0",
         "--no-record", "--truth", (folder_ / "truth.textproto").string(), "--materials",
         (folder_ / "materials.db").string(), "--out", (folder_ / name).string()});
    ASSERT_TRUE(run.in_time);
    ASSERT_TRUE(run.exit_code == 0 || run.exit_code == 3) << run.output;
  }
  /// cube.csv with the nearest crack of each mark, as a scan would list them.
  fs::path Filled(const std::string& name) const {
    const auto glass = formats::ReadGlassRecord(folder_ / name / "session/glass.rec");
    EXPECT_TRUE(glass);
    std::ifstream in(folder_ / (name + "-job") / "cube.csv");
    const fs::path file = folder_ / (name + ".csv");
    std::ofstream out(file);
    std::string line;
    std::getline(in, line);
    out << line << "\n";
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, kNoiseMm);
    while (std::getline(in, line)) {
      Vec3 wanted = Vec3::Zero();
      int mark = 0;
      char comma = 0;
      std::istringstream(line) >> mark >> comma >> wanted[0] >> comma >> wanted[1] >>
          comma >> wanted[2];
      const auto nearest = std::ranges::min_element(
          glass->cracks, {},
          [&](const auto& crack) { return (crack.position_mm - wanted).norm(); });
      const Vec3 at = nearest->position_mm;
      out << fmt::format("{},{},{},{},{},{},{}\n", mark, wanted[0], wanted[1], wanted[2],
                         at[0] + noise(random), at[1] + noise(random),
                         at[2] + noise(random));
    }
    return file;
  }
  MachineMeasurement Measure(const std::string& name) const {
    const Ended measured = Intaglio({"machine", "measure", (folder_ / name).string(),
                                     "--marks", Filled(name).string(), "--json"});
    EXPECT_EQ(measured.exit_code, 0) << measured.output;
    MachineMeasurement report;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(
                    measured.output.substr(measured.output.find('{')), &report)
                    .ok());
    return report;
  }
};

const MeasuredHeadFigure& FigureOf(const MachineMeasurement& report,
                                   const std::string& name) {
  return *std::ranges::find(report.head(), name, &MeasuredHeadFigure::name);
}

TEST_F(HeadMeasure, FindsWhatIsWrongAndTheCorrectedHeadIsRight) {
  ASSERT_NO_FATAL_FAILURE(Engrave(folder_ / "machine.textproto", "first"));
  const MachineMeasurement first = Measure("first");
  ASSERT_EQ(first.head_size(), 15);
  EXPECT_EQ(first.measured_count(), 50u);
  // Twice the intervals that 5 um leave in a cube of 30 mm.
  const auto expect = [&](const std::string& name, double truth, double tolerance) {
    const MeasuredHeadFigure& figure = FigureOf(first, name);
    EXPECT_NEAR(figure.figure().value(), truth, tolerance) << name;
    EXPECT_EQ(figure.state(), "found") << name;
  };
  expect("scale x", 1.015, 4e-4);
  expect("scale y", 0.985, 4e-4);
  expect("rotation", 0.004, 4e-4);
  expect("squareness", 0.002, 6e-4);
  // The marginal rays of the virtual beam have some um of coma and aberration.
  expect("scale z", 1.01, 1e-3);
  expect("pupil x", 1 / 150.0, 2e-4);
  expect("pupil y", 1 / 128.0, 2e-4);
  EXPECT_GT(first.max_deviation_um(), 500);
  EXPECT_LT(first.rms_residual_um(), 12);
  EXPECT_TRUE(fs::exists(first.picture()));

  ASSERT_NO_FATAL_FAILURE(Engrave(first.profile(), "second"));
  const MachineMeasurement second = Measure("second");
  EXPECT_LT(second.max_deviation_um(), 50);
  EXPECT_LT(second.rms_deviation_um(), 20);
}

// A stage has its pattern; what is not of the job is named.
TEST_F(HeadMeasure, RefusesWhatIsNoCube) {
  const Ended none = Intaglio({"machine", "measure", "--machine",
                               (folder_ / "machine.textproto").string(), "--block", "60",
                               "60", "9", "--out", (folder_ / "job").string()});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_THAT(none.output, HasSubstr("no cube is left"));
}

}  // namespace
}  // namespace intaglio
