// A machine with wrong axes is measured by its test pattern, corrected, and measured
// again. The virtual engraver has the errors by its own physics
// (services/virtual_engraver positioner.h, backlash.h); its glass is what is measured.

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "engrave/formats/glass_record.h"
#include "proto/machine_report.pb.h"
#include "tests/integration/run_program.h"
#include "tests/integration/scan_picture.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using testing::Ended;
using ::testing::HasSubstr;

constexpr double kXScale = 1.0004, kYScale = 0.9993, kSquareness = 0.0005;
constexpr double kXBacklashUm = 8, kYBacklashUm = 5, kTrueLagUs = 400;
constexpr double kProfileLagUs = 200;   // of els-03
constexpr double kRepeatabilityUm = 4;  // uniform: a deviation of 4 / sqrt(3)

class MachineMeasure : public ::testing::Test {
 protected:
  MachineMeasure() {
    std::ofstream(folder_ / "truth.textproto")
        << "stage { first_order_lag_s: 0.0004 repeatability_um: 4\n"
           "  backlash_um { x: 8 y: 5 }\n"
           "  positioner { x { travel_ratio: 1.0004 }\n"
           "               y { travel_ratio: 0.9993 turn_rad: -0.0005 } } }\n"
           "seed: 7\n";
  }
  Ended Intaglio(const std::vector<std::string>& words) const {
    testing::Running program(testing::Program("intaglio"), words, folder_ / "output.txt");
    return program.WaitForEnd(std::chrono::seconds(120));
  }
  /// The pattern of a profile, engraved in `name`. Its cracks are not where they should
  /// be, so the verdict may be that it is not good.
  void Engrave(const std::string& profile, const std::string& name) const {
    const fs::path job = folder_ / (name + "-job");
    const Ended made = Intaglio({"machine", "measure", "--machine", profile, "--block",
                                 "50", "50", "20", "--out", job.string()});
    ASSERT_EQ(made.exit_code, 0) << made.output;
    const Ended run =
        Intaglio({"run", (job / "pattern.textproto").string(), "--lockstep", "--warm-up",
                  "0", "--no-record", "--truth", (folder_ / "truth.textproto").string(),
                  "--out", (folder_ / name).string()});
    ASSERT_TRUE(run.in_time);
    ASSERT_TRUE(run.exit_code == 0 || run.exit_code == 3) << run.output;
  }
  MachineMeasurement Measure(const std::string& name, const fs::path& marks,
                             std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {
        "machine", "measure",      (folder_ / name).string(),
        "--marks", marks.string(), "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const Ended measured = Intaglio(words);
    EXPECT_EQ(measured.exit_code, 0) << measured.output;
    MachineMeasurement report;
    EXPECT_TRUE(google::protobuf::util::JsonStringToMessage(
                    measured.output.substr(measured.output.find('{')), &report)
                    .ok());
    return report;
  }
  /// What a microscope would list: numbers by the glass itself, turned and shifted.
  fs::path Table(const std::string& name) const {
    const auto glass = formats::ReadGlassRecord(folder_ / name / "session/glass.rec");
    EXPECT_TRUE(glass);
    const fs::path file = folder_ / (name + ".csv");
    std::ofstream out(file);
    out.precision(9);
    out << "x_mm,y_mm\n";
    for (const auto& crack : glass->cracks) {
      const double x = crack.position_mm.x(), y = crack.position_mm.y();
      out << 12 + 0.8 * x - 0.6 * y << "," << -3 + 0.6 * x + 0.8 * y << "\n";
    }
    return file;
  }

  /// A picture of 20 um a pixel, turned by 2 degrees: dark spots of 95 um with soft edges
  /// before the ground of scan_picture.h.
  fs::path Photo(const std::string& name) const {
    constexpr int kSide = 2600;
    constexpr double kPixelMm = 0.02, kRadiusPx = 2.4, kTurn = 0.0349;
    const auto glass = formats::ReadGlassRecord(folder_ / name / "session/glass.rec");
    EXPECT_TRUE(glass);
    std::vector<float> covered(kSide * kSide);
    for (const auto& crack : glass->cracks) {
      const double x = crack.position_mm.x() - 25, y = crack.position_mm.y() - 25;
      const double u = (std::cos(kTurn) * x - std::sin(kTurn) * y) / kPixelMm + kSide / 2;
      const double v = (std::sin(kTurn) * x + std::cos(kTurn) * y) / kPixelMm + kSide / 2;
      for (int j = static_cast<int>(v) - 7; j <= static_cast<int>(v) + 7; ++j) {
        for (int i = static_cast<int>(u) - 7; i <= static_cast<int>(u) + 7; ++i) {
          for (int k = 0; k < 25; ++k) {
            const double r =
                std::hypot(i + (k % 5 - 2) / 5.0 - u, j + (k / 5 - 2) / 5.0 - v);
            covered[static_cast<std::size_t>(j * kSide + i)] +=
                static_cast<float>(0.5 * std::erfc(r - kRadiusPx) / 25);
          }
        }
      }
    }
    const fs::path file = folder_ / (name + ".bmp");
    testing::WriteScan(file, covered);
    return file;
  }

  fs::path folder_ = test::FreshFolder();
};

void ExpectWithin(const MeasuredFigure& figure, double truth, double largest_interval) {
  // Twice the interval: of eight figures all are within it in 999 of 1000 machines.
  EXPECT_NEAR(figure.value(), truth, 2 * figure.interval95());
  EXPECT_LT(figure.interval95(), largest_interval) << "it would hold anything";
}

TEST_F(MachineMeasure, FindsTheErrorsAndTheCorrectedMachineIsRight) {
  const std::string els03 = INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto";
  ASSERT_NO_FATAL_FAILURE(Engrave(els03, "first"));
  const MachineMeasurement first = Measure("first", Table("first"));
  EXPECT_EQ(first.pattern_count(), 432u);
  EXPECT_GE(first.matched_count(), 430u);
  ASSERT_EQ(first.axes_size(), 2);
  const MeasuredAxis &x = first.axes(0), &y = first.axes(1);
  ExpectWithin(x.scale_ratio(), kXScale, 3e-5);
  ExpectWithin(y.scale_ratio(), kYScale, 3e-5);
  ExpectWithin(first.squareness_xy_rad(), kSquareness, 5e-5);
  ExpectWithin(x.backlash_um(), kXBacklashUm, 2);
  ExpectWithin(y.backlash_um(), kYBacklashUm, 2);
  ExpectWithin(x.lag_us(), kTrueLagUs - kProfileLagUs, 40);
  ExpectWithin(y.lag_us(), kTrueLagUs - kProfileLagUs, 40);
  const double deviation_um = kRepeatabilityUm / std::sqrt(3.0);
  EXPECT_NEAR(x.repeatability_um().value(), deviation_um, 0.25 * deviation_um);
  EXPECT_NEAR(y.repeatability_um().value(), deviation_um, 0.25 * deviation_um);
  EXPECT_GT(first.max_deviation_um(), 15);
  EXPECT_TRUE(fs::exists(first.picture()));

  const MachineMeasurement seen = Measure(
      "first", Photo("first"), {"--pixel", "20", "--out", (folder_ / "seen").string()});
  EXPECT_GE(seen.matched_count(), 430u);
  ASSERT_EQ(seen.axes_size(), 2);
  ExpectWithin(seen.axes(0).scale_ratio(), kXScale, 4e-5);
  ExpectWithin(seen.axes(1).scale_ratio(), kYScale, 4e-5);
  ExpectWithin(seen.squareness_xy_rad(), kSquareness, 6e-5);
  ExpectWithin(seen.axes(0).backlash_um(), kXBacklashUm, 2.5);
  ExpectWithin(seen.axes(1).lag_us(), kTrueLagUs - kProfileLagUs, 40);

  ASSERT_NO_FATAL_FAILURE(Engrave(first.profile(), "second"));
  const MachineMeasurement second = Measure("second", Table("second"));
  // Backlash and repeatability stay; half the backlash each way and four times the
  // deviation of both.
  EXPECT_LT(second.rms_deviation_um(),
            0.5 * std::hypot(kXBacklashUm, kYBacklashUm) + 2 * deviation_um);
  EXPECT_LT(second.rms_deviation_um(), 0.6 * first.rms_deviation_um());
  ExpectWithin(second.axes(0).scale_ratio(), kXScale, 3e-5);
  ExpectWithin(second.axes(1).scale_ratio(), kYScale, 3e-5);
  ExpectWithin(second.squareness_xy_rad(), kSquareness, 5e-5);
  ExpectWithin(second.axes(0).lag_us(), 0, 40);
  ExpectWithin(second.axes(1).lag_us(), 0, 40);
}

}  // namespace
}  // namespace intaglio
