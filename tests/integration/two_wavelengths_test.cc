// Two wavelengths in one profile (Trochimczuk 2008, table 8). The virtual glass bends the
// light by the index at the wavelength that the laser is set to.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/integration/run_job.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using testing::Ended;
using ::testing::HasSubstr;
using testing::RunJob;

class TwoWavelengths : public RunJob {
 protected:
  TwoWavelengths() {
    std::string machine =
        testing::TextIn(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
    const std::string own = "  wavelength_nm: 532\n";
    machine.insert(machine.find(own),
                   "  further_wavelengths { wavelength_nm: 1064 pulse_energy_mj: 70 }\n");
    std::ofstream(folder_ / "two.textproto") << machine;
  }
  Ended RunAt(int wavelength_nm, std::vector<std::string> more = {}) {
    std::vector<std::string> words = {
        "--lockstep",
        "--warm-up",
        "0",
        "--spacing",
        "0.8",
        "--machine",
        (folder_ / "two.textproto").string(),
        "--set",
        "laser.wavelength_nm=" + std::to_string(wavelength_nm)};
    words.insert(words.end(), more.begin(), more.end());
    return Run(words);
  }
};

class Wavelength : public TwoWavelengths, public ::testing::WithParamInterface<int> {};

TEST_P(Wavelength, OfTheJobPutsEveryPointInPlace) {
  const Ended run = RunAt(GetParam());
  ASSERT_TRUE(run.in_time);
  ASSERT_EQ(run.exit_code, 0) << run.output;
  const JobReport report = Report();
  EXPECT_TRUE(report.verdict().good());
  EXPECT_EQ(report.points().made(), report.points().planned());
  EXPECT_LT(report.position_errors().rms_um(), 1);
  const bool is_green = GetParam() == 532;
  // Schott's catalog of N-BK7.
  EXPECT_NEAR(report.optics().refractive_index(), is_green ? 1.51947 : 1.50663, 1e-5);
  EXPECT_EQ(report.optics().wavelength_nm(), GetParam());
  EXPECT_EQ(report.job().laser().pulse_energy_mj(), is_green ? 30 : 70);
}

INSTANTIATE_TEST_SUITE_P(OfTable8, Wavelength, ::testing::Values(532, 1064),
                         ::testing::PrintToStringParamName());

// The doubler was left in: what the glass shows then is not what was asked for.
TEST_F(TwoWavelengths, TheOneThatIsNotTheJobsShowsInTheGlass) {
  const fs::path truth = folder_ / "truth.textproto";
  std::ofstream(truth) << "block { refractive_index: 1.51947 }";
  const Ended run = RunAt(1064, {"--truth", truth.string()});
  ASSERT_TRUE(run.in_time);
  EXPECT_NE(run.exit_code, 0) << run.output;
  const JobReport report = Report();
  EXPECT_FALSE(report.verdict().good());
  // The share (1.51947 - 1.50663) / 1.50663 of the depth of a point, up to 27 mm.
  EXPECT_GT(report.position_errors().max_um(), 150);
  EXPECT_LT(report.position_errors().max_um(), 1e3 * 27 * 0.00853);
}

TEST_F(TwoWavelengths, AThirdOneIsRefused) {
  const Ended run = RunAt(600);
  ASSERT_TRUE(run.in_time);
  EXPECT_NE(run.exit_code, 0);
  EXPECT_THAT(run.output, HasSubstr("laser.wavelength_nm: 600 is none of the wavelengths "
                                    "of els-03, 532 1064"));
}

}  // namespace
}  // namespace intaglio
