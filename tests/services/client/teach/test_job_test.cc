#include "services/client/teach/test_job.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>

#include "services/job/files/job_file.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;

class TestJobAtAWavelength : public testing::Test {
 protected:
  TestJobAtAWavelength() {
    fs::create_directories(folder_);
    MachineSpec machine =
        ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto").value();
    LaserWavelength& infrared = *machine.mutable_laser()->add_further_wavelengths();
    infrared.set_wavelength_nm(1064);
    infrared.set_pulse_energy_mj(70);
    EXPECT_TRUE(WriteMachineFile(asked_.machine_file, machine));
    asked_.axes = {25, 25, 25};
    asked_.block_mm = {50, 50, 50};
  }
  ~TestJobAtAWavelength() override { fs::remove_all(folder_); }

  // Each wavelength has its own way of the stage.
  static Result<double> Ratio(const MachineSpec& machine, const MachineLens&,
                              const std::string&) {
    return machine.laser().wavelength_nm() == 1064 ? 0.5 : 0.6;
  }

  const fs::path folder_ =
      fs::path(testing::TempDir()) / ("test-job-" + std::to_string(getpid()));
  client::TestJob asked_{.machine_file = folder_ / "machine.textproto"};
};

TEST_F(TestJobAtAWavelength, HasItsEnergyAndAsksForIt) {
  asked_.wavelength_nm = 1064;
  const auto file = client::WriteFocusSeries(asked_, Ratio, {}, folder_ / "series");
  ASSERT_TRUE(file) << file.error().message;
  const JobSpec job = ReadJobFile(*file).value();
  EXPECT_EQ(job.laser().wavelength_nm(), 1064);
  EXPECT_NEAR(job.laser().pulse_energy_mj(), 7, 1e-9);
}

TEST_F(TestJobAtAWavelength, MovesTheZeroByTheGlassAtIt) {
  const auto moved_by = [&](std::optional<double> wavelength_nm) {
    asked_.wavelength_nm = wavelength_nm;
    EXPECT_TRUE(
        client::WriteFocusSeries(asked_, Ratio, {.step_mm = 0.1}, folder_ / "series"));
    return client::ZeroMoveOfSeries(folder_ / "series", 5, Ratio).value().z_mm;
  };
  EXPECT_NEAR(moved_by({}), -0.6 * 0.45, 1e-9);
  EXPECT_NEAR(moved_by(1064), -0.5 * 0.45, 1e-9);
}

}  // namespace
}  // namespace intaglio
