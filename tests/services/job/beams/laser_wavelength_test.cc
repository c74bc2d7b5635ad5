// A laser with the two wavelengths of Trochimczuk 2008, table 8, each with its energy.

#include "services/job/beams/laser_wavelength.h"

#include <gmock/gmock.h>
#include <google/protobuf/util/message_differencer.h>

#include "materials_db/material_store.h"
#include "services/job/checks/job_check.h"
#include "services/job/files/freeze.h"
#include "services/job/machine/mounted_parts.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using google::protobuf::util::MessageDifferencer;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

void AddWavelength(double wavelength_nm, double energy_mj, MachineSpec& machine) {
  LaserWavelength& added = *machine.mutable_laser()->add_further_wavelengths();
  added.set_wavelength_nm(wavelength_nm);
  added.set_pulse_energy_mj(energy_mj);
}

MachineSpec TwoWavelengths() {
  MachineSpec machine = GoodMachine();
  AddWavelength(1064, 70, machine);
  return machine;
}

JobSpec JobAt(double wavelength_nm) {
  JobSpec job = GoodJob();
  job.mutable_laser()->clear_pulse_energy_mj();
  job.mutable_laser()->set_wavelength_nm(wavelength_nm);
  return job;
}

Result<FrozenJob> FrozenOn(const MachineSpec& machine, const JobSpec& job) {
  const auto glasses = materials_db::MaterialStore::Open(":memory:");
  return FreezeJob(job, machine, glasses->Find("N-BK7").value(), {"uid", 1, "", "test"});
}

std::string WrongOn(const MachineSpec& machine, const JobSpec& job) {
  std::string all;
  for (const Finding& finding : CheckAll(job, machine)) all += finding.message + "\n";
  return all;
}

std::string WrongWith(const MachineSpec& machine) {
  std::string all;
  for (const Error& error : CheckMachine(machine)) all += error.message + "\n";
  return all;
}

TEST(LaserWavelength, TheChosenOneAndWhatBelongsToItAreTheHeads) {
  MachineSpec machine = TwoWavelengths();
  machine.mutable_laser()->set_pulse_duration_ns(12);
  const LaserHead head = ForWavelength(1064.2, machine).laser();
  EXPECT_EQ(head.wavelength_nm(), 1064);
  EXPECT_EQ(head.pulse_energy_mj(), 70);
  EXPECT_FALSE(head.has_pulse_duration_ns()) << "that of another wavelength is not it";
  ASSERT_EQ(head.further_wavelengths_size(), 1);
  EXPECT_EQ(head.further_wavelengths(0).wavelength_nm(), 532);
  EXPECT_EQ(head.further_wavelengths(0).pulse_energy_mj(), 30);
  EXPECT_EQ(head.further_wavelengths(0).pulse_duration_ns(), 12);
  EXPECT_EQ(FullEnergiesOf(head).min_mj, 30);
  EXPECT_EQ(FullEnergiesOf(head).max_mj, 70);
}

// The machine of a job is compared with the profile of the cell, and chosen from again.
TEST(LaserWavelength, FromEveryMachineThatItReturnsItMakesTheSame) {
  MachineSpec machine = TwoWavelengths();
  AddWavelength(355, 10, machine);
  const auto all_nm = WavelengthsOf(machine.laser());
  EXPECT_THAT(all_nm, ElementsAre(532, 1064, 355));
  for (const double before_nm : all_nm) {
    for (const double wavelength_nm : all_nm) {
      const auto direct = ForWavelength(wavelength_nm, machine);
      EXPECT_EQ(direct.laser().wavelength_nm(), wavelength_nm);
      EXPECT_TRUE(MessageDifferencer::Equals(
          ForWavelength(wavelength_nm, ForWavelength(before_nm, machine)), direct));
    }
  }
}

TEST(LaserWavelength, AJobHasTheIndexAndTheEnergyOfItsOwn) {
  JobSpec unnamed = GoodJob();
  unnamed.mutable_laser()->clear_wavelength_nm();
  unnamed.mutable_laser()->clear_pulse_energy_mj();
  const auto green = FrozenOn(TwoWavelengths(), unnamed);
  const auto infrared = FrozenOn(TwoWavelengths(), JobAt(1064));
  ASSERT_TRUE(green) << green.error().message;
  ASSERT_TRUE(infrared) << infrared.error().message;
  // Schott's catalog gives 1.51947 and 1.50663.
  EXPECT_NEAR(green->optics().refractive_index(), 1.51947, 1e-5);
  EXPECT_NEAR(infrared->optics().refractive_index(), 1.50663, 1e-5);
  EXPECT_EQ(infrared->optics().wavelength_nm(), 1064);
  EXPECT_EQ(green->job().laser().pulse_energy_mj(), 30);
  EXPECT_EQ(infrared->job().laser().pulse_energy_mj(), 70);
  for (const FrozenJob& job : {*green, *infrared}) {
    EXPECT_EQ(job.machine().laser().wavelength_nm(), job.job().laser().wavelength_nm());
    EXPECT_EQ(job.machine().laser().pulse_energy_mj(),
              job.job().laser().pulse_energy_mj());
  }
}

TEST(LaserWavelength, OfAnotherOneThoseOfTheMachineAreNamed) {
  EXPECT_THAT(WrongOn(TwoWavelengths(), JobAt(600)),
              HasSubstr("laser.wavelength_nm: 600 is none of the wavelengths of els-03, "
                        "532 1064"));
  EXPECT_THAT(
      WrongOn(GoodMachine(), JobAt(1064)),
      HasSubstr("laser.wavelength_nm: 1064 is not the wavelength of els-03, 532"));
}

TEST(LaserWavelength, TheEnergyOfOneIsNotThatOfTheOther) {
  JobSpec job = JobAt(1064);
  job.mutable_laser()->set_pulse_energy_mj(70);
  EXPECT_EQ(WrongOn(TwoWavelengths(), job), "");
  job.mutable_laser()->set_wavelength_nm(532);
  EXPECT_THAT(WrongOn(TwoWavelengths(), job),
              HasSubstr("laser.pulse_energy_mj: 70 is above the pulse energy of els-03, "
                        "30"));
}

TEST(LaserWavelength, AProfileNamesEachOnceAndMeasuresNothingForAll) {
  EXPECT_EQ(WrongWith(TwoWavelengths()), "");
  MachineSpec twice = TwoWavelengths();
  AddWavelength(532.3, 20, twice);
  EXPECT_THAT(WrongWith(twice), HasSubstr("laser.further_wavelengths[1].wavelength_nm: "
                                          "532.3 is given before"));
  MachineSpec calibrated = TwoWavelengths();
  for (const double ratio : {0.1, 1.0}) {
    EnergyPoint& point = *calibrated.mutable_laser()->add_energy_calibration();
    point.set_setting_ratio(ratio);
    point.set_energy_mj(30 * ratio);
  }
  EXPECT_THAT(WrongWith(calibrated),
              HasSubstr("laser.further_wavelengths: the calibrated energies"));
  MachineSpec many = TwoWavelengths();
  for (int i = 0; i < 7; ++i) AddWavelength(700 + 10 * i, 5, many);
  EXPECT_THAT(WrongWith(many), HasSubstr("laser.further_wavelengths: 8 are more than 7"));
}

// What is mounted is known by its index, which is another one at each wavelength.
TEST(LaserWavelength, AnArmNamesTheOneThatTheLaserHasToBeSetTo) {
  const FrozenJob job = FrozenOn(TwoWavelengths(), JobAt(1064)).value();
  EXPECT_THAT(
      MountMisfit(job, {.refractive_index = 1.51947}),
      AllOf(HasSubstr("1.50663 at 1064 nm)"), HasSubstr("set the laser to 1064 nm and"),
            HasSubstr("--glass N-BK7 --wavelength 1064`")));
  EXPECT_EQ(MountMisfit(job, {.refractive_index = 1.50663}), "");
  EXPECT_THAT(WantedTextOf(job), HasSubstr(", laser at 1064 nm"));
  EXPECT_THAT(MountCommandFor(job), HasSubstr("--glass N-BK7 --wavelength 1064"));
  const FrozenJob one = FrozenOn(GoodMachine(), JobAt(532)).value();
  EXPECT_THAT(MountCommandFor(one), testing::Not(HasSubstr("--wavelength")));
}

}  // namespace
}  // namespace intaglio
