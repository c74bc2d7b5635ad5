// Fields of a profile that the check of the whole profile compares with each other.

#include <gmock/gmock.h>

#include <functional>
#include <string>

#include "services/job/checks/job_check.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/machine/laser_setting.h"
#include "services/job/machine/machine_defaults.h"
#include "tests/services/job/test_job.h"

namespace intaglio {
namespace {

using testing::HasSubstr;

void AddEnergy(MachineSpec& machine, double setting_ratio, double energy_mj) {
  EnergyPoint& point = *machine.mutable_laser()->add_energy_calibration();
  point.set_setting_ratio(setting_ratio);
  point.set_energy_mj(energy_mj);
}

std::string ErrorsOf(const std::function<void(MachineSpec&)>& change) {
  MachineSpec machine = GoodMachine();
  change(machine);
  std::string all;
  for (const Error& error : CheckMachine(machine)) all += error.message + "\n";
  return all;
}

TEST(MachineCheck, LensNamesAreThoseOfTheList) {
  EXPECT_EQ(ErrorsOf([](auto& m) { m.set_mounted_lens("f70"); }), "");
  EXPECT_EQ(ErrorsOf([](auto& m) { m.set_mounted_lens("f50"), m.set_zero_lens("x"); }),
            "mounted_lens: \"f50\" is no lens of this machine; give one of f43, f70\n"
            "zero_lens: \"x\" is no lens of this machine; give one of f43, f70\n");
}

TEST(MachineCheck, TheDefaultRateIsARateOfTheLaser) {
  // The 200 Hz of els-03 were only planned when the source was written.
  const MachineSpec machine = GoodMachine();
  EXPECT_EQ(WithDefaults(GoodJob(), machine).laser().rate_hz(), 100);
  EXPECT_EQ(DefaultRateHz(machine.laser()), 100);
  MachineSpec without = machine;
  without.mutable_laser()->clear_default_rate_hz();
  EXPECT_EQ(WithDefaults(GoodJob(), without).laser().rate_hz(), 200) << "the highest";
  EXPECT_EQ(DefaultRateHz(LaserHead()), 0);
  EXPECT_EQ(
      ErrorsOf([](auto& m) { m.mutable_laser()->set_default_rate_hz(60); }),
      "laser.default_rate_hz: 60 is none of laser.rates_hz, 1 2 5 10 25 50 100 200; "
      "give one of them\n");
}

// Half of the beam's width over the focal length, where the lens has none.
MachineOutput& AddOutput(MachineSpec& machine, const char* name, std::uint32_t output) {
  MachineOutput& added = *machine.add_outputs();
  added.set_name(name);
  added.set_output(output);
  return added;
}

MachineInput& AddInput(MachineSpec& machine, const char* name, std::uint32_t input) {
  MachineInput& added = *machine.add_inputs();
  added.set_name(name);
  added.set_input(input);
  added.set_remedy("close it");
  return added;
}

TEST(MachineCheck, OutputsAndInputsHaveANameAndANumberEach) {
  EXPECT_EQ(ErrorsOf([](auto& m) {
              AddOutput(m, "air", 1), AddOutput(m, "lamp", 8);
              AddInput(m, "air", 1), AddInput(m, "clamp", 8);
            }),
            "");
  EXPECT_EQ(ErrorsOf([](auto& m) { AddOutput(m, "", 1), AddInput(m, "a\n", 2); }),
            "outputs[0].name: is missing; give it a name, as people call it\n"
            "inputs[0].name: \"a\\n\" is not 1 to 40 printable ASCII characters; shorten "
            "or correct it\n");
  EXPECT_EQ(ErrorsOf([](auto& m) { AddOutput(m, "air", 3), AddOutput(m, "air", 3); }),
            "outputs[1].name: \"air\" is already the name of outputs[0]; give another "
            "one\n"
            "outputs[1].output: 3 is already that of outputs[0]; give another one\n");
  EXPECT_THAT(ErrorsOf([](auto& m) { AddOutput(m, "air", 9); }),
              HasSubstr("outputs[0].output: 9 is outside"));
  EXPECT_THAT(ErrorsOf([](auto& m) { AddInput(m, "clamp", 0); }),
              HasSubstr("inputs[0].input: 0 is outside"));
  EXPECT_THAT(ErrorsOf([](auto& m) { AddInput(m, "clamp", 1).clear_remedy(); }),
              HasSubstr("inputs[0].remedy: is missing; give what a person does"));
  EXPECT_THAT(ErrorsOf([](auto& m) {
                AddInput(m, "clamp", 1).set_remedy(std::string(201, 'x'));
              }),
              HasSubstr("is not 1 to 200 printable ASCII characters"));
}

TEST(MachineCheck, OutputsOfAMachineThatMarksAreRefused) {
  const auto marking = [](MachineSpec& m) {
    m.clear_laser_line(), m.clear_motion_line();
    m.mutable_mark_line()->set_protocol("scan-head");
    AddOutput(m, "air", 1), AddInput(m, "clamp", 1);
  };
  EXPECT_THAT(ErrorsOf(marking),
              HasSubstr("outputs: are served by a laser controller alone"));
  EXPECT_THAT(ErrorsOf(marking),
              HasSubstr("inputs: are served by a laser controller alone"));
}

TEST(MachineCheck, AnApertureIsGivenOrFollowsFromTheBeam) {
  const auto clear = [](MachineSpec& m) {
    m.mutable_lenses(0)->clear_numerical_aperture();
  };
  MachineSpec machine = GoodMachine();
  EXPECT_DOUBLE_EQ(machine.lenses(0).numerical_aperture(), 5.0 / 86);
  EXPECT_DOUBLE_EQ(machine.lenses(1).numerical_aperture(), 5.0 / 140);
  machine.mutable_lenses(0)->set_numerical_aperture(0.2);
  clear(machine), machine.mutable_laser()->set_beam_diameter_mm(8.6);
  EXPECT_DOUBLE_EQ(WithMachineDefaults(machine).lenses(0).numerical_aperture(), 0.1);
  EXPECT_DOUBLE_EQ(WithMachineDefaults(machine).lenses(1).numerical_aperture(), 5.0 / 140)
      << "what is given stays";
  EXPECT_EQ(
      ErrorsOf([&](auto& m) { clear(m), m.mutable_laser()->clear_beam_diameter_mm(); }),
      "lenses[0].numerical_aperture: is missing; give it, or "
      "laser.beam_diameter_mm\n");
  EXPECT_EQ(
      ErrorsOf([&](auto& m) { clear(m), m.mutable_laser()->set_beam_diameter_mm(86); }),
      "lenses[0].numerical_aperture: 1 by laser.beam_diameter_mm, 86, and "
      "focal_length_mm, 43, is outside 0.01..0.9; correct these\n");
}

TEST(MachineCheck, EnergiesGrow) {
  EXPECT_EQ(ErrorsOf([](auto& m) { AddEnergy(m, 0.2, 5), AddEnergy(m, 1, 30); }), "");
  EXPECT_THAT(ErrorsOf([](auto& m) { AddEnergy(m, 1, 30); }),
              HasSubstr("laser.energy_calibration[1]: is missing"));
  EXPECT_THAT(ErrorsOf([](auto& m) {
                AddEnergy(m, 0.2, 5), AddEnergy(m, 0.5, 5), AddEnergy(m, 1, 30);
              }),
              HasSubstr("laser.energy_calibration[1]: setting 0.5 with 5 mJ does not "
                        "exceed setting 0.2 with 5 mJ"));
  EXPECT_EQ(ErrorsOf([](auto& m) { AddEnergy(m, 0.2, 5), AddEnergy(m, 1, 20); }),
            "laser.pulse_energy_mj: 30 is outside the calibrated energies, 5..20\n");
}

TEST(MachineCheck, ChannelPositionsAreThoseOfItsChannels) {
  const auto found = ErrorsOf([](MachineSpec& m) {
    m.mutable_laser()->set_channels(2);
    for (const std::uint32_t channel : {2, 2, 3, 7}) {
      m.add_channel_positions()->set_channel(channel);
    }
    for (int i : {0, 1, 2}) m.mutable_channel_positions(i)->mutable_offset_mm();
  });
  EXPECT_THAT(found, HasSubstr("channel_positions[1].channel: 2 occurs twice"));
  EXPECT_THAT(found, HasSubstr("channel_positions[2].channel: 3 is above"));
  EXPECT_THAT(found, HasSubstr("channel_positions[3].channel: 7 is outside 2..4"));
  EXPECT_THAT(found, HasSubstr("channel_positions[3].offset_mm: is missing"));
}

TEST(MachineCheck, CorrectionsAreSmall) {
  EXPECT_EQ(ErrorsOf([](auto& m) {
              m.mutable_cartesian()->mutable_y()->set_scale_ratio(1.2);
              m.mutable_cartesian()->set_squareness_xy_rad(0.5);
            }),
            "cartesian.y.scale_ratio: 1.2 is outside 0.9..1.1\n"
            "cartesian.squareness_xy_rad: 0.5 is outside -0.1..0.1\n");
}

// Trochimczuk 2008, annex D: within 20 us of the lamp sync, at least 100 us long.
TEST(MachineCheck, TheTriggerIsWithinTheLasersTimes) {
  const auto timing = [](MachineSpec& m) { return m.mutable_laser()->mutable_timing(); };
  EXPECT_EQ(ErrorsOf([&](auto& m) { timing(m)->set_qswitch_delay_us(20); }), "");
  EXPECT_THAT(ErrorsOf([&](auto& m) { timing(m)->set_qswitch_delay_us(20.5); }),
              HasSubstr("laser.timing.qswitch_delay_us: 20.5 is later than"));
  EXPECT_THAT(ErrorsOf([&](auto& m) { timing(m)->set_max_qswitch_delay_us(4); }),
              HasSubstr("laser.timing.qswitch_delay_us: 5 is later than"));
  EXPECT_THAT(ErrorsOf([&](auto& m) { timing(m)->set_qswitch_width_us(99); }),
              HasSubstr("laser.timing.qswitch_width_us: 99 is shorter than"));
  EXPECT_THAT(ErrorsOf([&](auto& m) { timing(m)->set_min_qswitch_width_us(121); }),
              HasSubstr("laser.timing.qswitch_width_us: 120 is shorter than"));
  // 4 kHz are 250 us.
  const auto at_4_khz = [&](double width_us) {
    return ErrorsOf([&](auto& m) {
      m.mutable_laser()->add_rates_hz(4000);
      timing(m)->set_qswitch_width_us(width_us);
    });
  };
  EXPECT_EQ(at_4_khz(244), "");
  EXPECT_THAT(at_4_khz(245), HasSubstr("until the next one at 4000 Hz; reduce it"));
  EXPECT_EQ(ErrorsOf([&](auto& m) { timing(m)->set_shutter_time_ms(1001); }),
            "laser.timing.shutter_time_ms: 1001 is outside 0..1000\n");
}

TEST(LaserSetting, IsLinearBetweenTheMeasurements) {
  MachineSpec machine = GoodMachine();
  EXPECT_FALSE(LaserSettingFor(machine.laser(), 10).has_value());
  EXPECT_FALSE(EnergiesOf(machine.laser()).has_value());
  AddEnergy(machine, 0.2, 4), AddEnergy(machine, 0.6, 24), AddEnergy(machine, 1, 30);
  // By hand: 0.2 + 0.4 * (10 - 4) / 20, and 0.6 + 0.4 * (27 - 24) / 6.
  EXPECT_DOUBLE_EQ(*LaserSettingFor(machine.laser(), 10), 0.32);
  EXPECT_DOUBLE_EQ(*LaserSettingFor(machine.laser(), 27), 0.8);
  EXPECT_DOUBLE_EQ(*LaserSettingFor(machine.laser(), 24), 0.6);
  EXPECT_DOUBLE_EQ(*LaserSettingFor(machine.laser(), 3), 0.2);
  EXPECT_DOUBLE_EQ(*LaserSettingFor(machine.laser(), 31), 1);
}

TEST(LaserSetting, JobsAskForCalibratedEnergies) {
  MachineSpec machine = GoodMachine();
  AddEnergy(machine, 0.2, 4), AddEnergy(machine, 1, 30);
  JobSpec job = GoodJob();
  job.mutable_laser()->set_pulse_energy_mj(4);
  EXPECT_TRUE(CheckJobOnMachine(job, machine).empty());
  job.mutable_laser()->set_pulse_energy_mj(3.9);
  const auto found = CheckJobOnMachine(job, machine);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].message,
            "laser.pulse_energy_mj: 3.9 is outside the calibrated energies of els-03, "
            "4..30");
}

TEST(LaserSetting, ALaserAtAnOutputHasOneEnergyUnlessItIsCalibrated) {
  MachineSpec machine = GoodMachine();
  EXPECT_EQ(SettableEnergies(machine).min_mj, 0);
  machine.mutable_laser_line()->set_protocol("motion-output");
  machine.mutable_motion_line()->set_protocol("virtual-cell");
  EXPECT_EQ(SettableEnergies(machine).min_mj, 0) << "its line carries the energy";
  machine.mutable_motion_line()->set_protocol("isel");
  EXPECT_EQ(SettableEnergies(machine).min_mj, 30);
  JobSpec job = GoodJob();
  job.mutable_laser()->set_pulse_energy_mj(3);
  const auto found = CheckJobOnMachine(job, machine);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].message,
              HasSubstr("laser.pulse_energy_mj: 3 cannot be set on els-03, whose "
                        "controller switches the laser and no more: every pulse has 30"));
  job.mutable_laser()->set_pulse_energy_mj(30);
  EXPECT_TRUE(CheckJobOnMachine(job, machine).empty());
  AddEnergy(machine, 0.2, 2), AddEnergy(machine, 1, 30);
  job.mutable_laser()->set_pulse_energy_mj(3);
  EXPECT_TRUE(CheckJobOnMachine(job, machine).empty());
}

// Trochimczuk 2008, table 8: at most 20 J, and E_p f < 1000 W.
TEST(LaserPump, LimitsEnergyAndRate) {
  const auto pump = [](MachineSpec& m) { return m.mutable_laser()->mutable_pump(); };
  EXPECT_EQ(ErrorsOf([&](auto& m) { pump(m)->set_energy_j(20); }), "");
  EXPECT_EQ(ErrorsOf([&](auto& m) { pump(m)->set_energy_j(20.5); }),
            "laser.pump.energy_j: 20.5 is above max_energy_j, 20; reduce it\n");
  MachineSpec machine = GoodMachine();
  JobSpec job = GoodJob();
  const double rate_hz = WithDefaults(job, machine).laser().rate_hz();
  pump(machine)->set_energy_j(999 / rate_hz);
  EXPECT_TRUE(CheckJobOnMachine(WithDefaults(job, machine), machine).empty());
  pump(machine)->set_energy_j(1000 / rate_hz);
  const auto found = CheckJobOnMachine(WithDefaults(job, machine), machine);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_THAT(found[0].message, HasSubstr("1000 W of pump power"));
  EXPECT_THAT(found[0].message, HasSubstr("laser.rate_hz"));
}

// The tolerance is 30 um, and half a step of both axes sqrt(2) times that of one.
TEST(MachineCheck, HalfAStepOfTheAxesLeavesRoomForAPlan) {
  const auto with = [](double steps_per_mm) {
    return ErrorsOf([&](auto& m) {
      m.set_position_tolerance_um(30);
      m.mutable_x()->set_steps_per_mm(steps_per_mm);
      m.mutable_y()->set_steps_per_mm(steps_per_mm);
    });
  };
  EXPECT_EQ(with(30), "") << "23.57 um of the 24 um of a plan";
  EXPECT_EQ(with(20),
            "position_tolerance_um: 30 leaves no room for a plan, which keeps within 0.8 "
            "of it: half a step of the axes is 35.36 um (x.steps_per_mm: 20, "
            "y.steps_per_mm: 20); raise the microsteps of the drive and steps_per_mm, or "
            "the field\n");
}

TEST(MachineCheck, FlashHeightsAreInOrder) {
  EXPECT_EQ(ErrorsOf([](auto& m) {
              m.mutable_laser()->mutable_timing()->set_min_flash_height_mm(5);
              m.mutable_laser()->mutable_timing()->set_max_flash_height_mm(4);
            }),
            "laser.timing.min_flash_height_mm: 5 is above max_flash_height_mm, 4; "
            "exchange them\n");
}

}  // namespace
}  // namespace intaglio
