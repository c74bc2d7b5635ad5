#include "services/synchronizer/task_check.h"

#include <gmock/gmock.h>

#include <functional>
#include <limits>

#include "tests/services/synchronizer/good_task.h"

namespace intaglio::synchronizer {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string kFile = "/etc/intaglio/els-03.textproto";

std::string RefusalOf(const FrozenJob& task, const MachineSpec& own = GoodMachine()) {
  const Status status = CheckTask(task, own, kFile);
  if (status) return "";
  EXPECT_EQ(status.error().code, ErrorCode::kRefused);
  return status.error().message;
}

TEST(TaskCheck, ATaskMadeWithThisProfilePasses) { EXPECT_EQ(RefusalOf(GoodTask()), ""); }

TEST(TaskCheck, HowLinesAreWiredIsNotCompared) {
  FrozenJob task = GoodTask();
  task.mutable_machine()->mutable_laser_line()->set_device("/dev/other");
  task.mutable_machine()->mutable_laser_line()->set_baud(9600);
  task.mutable_machine()->mutable_motion_line()->set_protocol("another");
  EXPECT_EQ(RefusalOf(task), "");
}

// A queue or a recording outlives versions, and each adds fields.
TEST(TaskCheck, AFieldThatTheJobDoesNotHaveIsTheDefault) {
  FrozenJob task = GoodTask();
  task.mutable_machine()->mutable_laser()->clear_max_missed_in_a_row();
  EXPECT_EQ(RefusalOf(task), "");
  MachineSpec own = GoodMachine();
  own.mutable_laser()->set_max_missed_in_a_row(3);
  EXPECT_THAT(RefusalOf(task, own), HasSubstr("laser.max_missed_in_a_row is 5"));
}

// The laser of the task is at another wavelength than the one that the profile names
// first.
TEST(TaskCheck, ATaskForAnyWavelengthOfTheProfilePasses) {
  MachineSpec own = GoodMachine();
  LaserWavelength& infrared = *own.mutable_laser()->add_further_wavelengths();
  infrared.set_wavelength_nm(1064);
  infrared.set_pulse_energy_mj(70);
  const auto glasses = materials_db::MaterialStore::Open(":memory:");
  JobSpec job = GoodJob();
  job.mutable_laser()->set_pulse_energy_mj(30);
  for (const double wavelength_nm : {532, 1064}) {
    job.mutable_laser()->set_wavelength_nm(wavelength_nm);
    const auto task =
        FreezeJob(job, own, glasses->Find("N-BK7").value(), {"job", 1, "", "test"});
    ASSERT_TRUE(task) << task.error().message;
    EXPECT_EQ(RefusalOf(*task, own), "");
    EXPECT_NE(RefusalOf(*task), "") << "this profile does not have it";
  }
}

struct Change {
  const char* field;
  std::function<void(MachineSpec&)> change;
};

class OtherMachine : public testing::TestWithParam<Change> {};

TEST_P(OtherMachine, IsRefusedAndNamed) {
  FrozenJob task = GoodTask();
  GetParam().change(*task.mutable_machine());
  EXPECT_THAT(RefusalOf(task), AllOf(HasSubstr(GetParam().field),
                                     HasSubstr("submit it again"), HasSubstr(kFile)));
}

INSTANTIATE_TEST_SUITE_P(
    EveryField, OtherMachine,
    testing::Values(
        Change{"name is \"els-04\"", [](auto& m) { m.set_name("els-04"); }},
        Change{"x.travel_min_mm is -20 in the job's profile and -2 in this machine's",
               [](auto& m) { m.mutable_x()->set_travel_min_mm(-20); }},
        Change{"z.travel_max_mm", [](auto& m) { m.mutable_z()->set_travel_max_mm(400); }},
        Change{"y.max_speed_mm_s",
               [](auto& m) { m.mutable_y()->set_max_speed_mm_s(90); }},
        Change{"x.max_acceleration_mm_s2",
               [](auto& m) { m.mutable_x()->set_max_acceleration_mm_s2(8000); }},
        Change{"x.max_jerk_mm_s3 is 1000000 in the job's profile and not there in",
               [](auto& m) { m.mutable_x()->set_max_jerk_mm_s3(1e6); }},
        Change{"block_origin_mm.z",
               [](auto& m) { m.mutable_block_origin_mm()->set_z(5); }},
        Change{"position_tolerance_um",
               [](auto& m) { m.set_position_tolerance_um(500); }},
        Change{"laser.rates_hz[7]",
               [](auto& m) { m.mutable_laser()->set_rates_hz(7, 400); }},
        Change{"laser.rates_hz[8] is 400 in the job's profile and not there",
               [](auto& m) { m.mutable_laser()->add_rates_hz(400); }},
        Change{"laser.wavelength_nm",
               [](auto& m) { m.mutable_laser()->set_wavelength_nm(1064); }},
        Change{"laser.pulse_energy_mj",
               [](auto& m) { m.mutable_laser()->set_pulse_energy_mj(60); }},
        Change{"laser.channels", [](auto& m) { m.mutable_laser()->set_channels(3); }},
        Change{"laser.max_missed_in_a_row",
               [](auto& m) { m.mutable_laser()->set_max_missed_in_a_row(1000); }},
        Change{"lenses[0].numerical_aperture",
               [](auto& m) { m.mutable_lenses(0)->set_numerical_aperture(0.3); }},
        Change{"lenses[1].name", [](auto& m) { m.mutable_lenses(1)->set_name("g70"); }},
        Change{"stage_lag_s", [](auto& m) { m.set_stage_lag_s(0.01); }},
        Change{"cartesian",
               [](auto& m) {
                 m.mutable_cartesian()->mutable_x()->set_moves(AXIS_MOVES_TABLE);
               }},
        Change{"polar", [](auto& m) { m.mutable_polar()->set_arm_length_mm(150); }},
        Change{"second_order",
               [](auto& m) {
                 m.mutable_second_order()->set_natural_frequency_hz(120);
                 m.mutable_second_order()->set_damping_ratio(0.7);
               }},
        Change{"servo", [](auto& m) { m.mutable_servo()->set_position_gain_per_s(300); }},
        Change{"max_speed_norm_mm_s", [](auto& m) { m.set_max_speed_norm_mm_s(80); }},
        Change{"max_acceleration_norm_mm_s2",
               [](auto& m) { m.set_max_acceleration_norm_mm_s2(7000); }}));

TEST(TaskCheck, AllDifferencesAreNamedTogether) {
  FrozenJob task = GoodTask();
  task.mutable_machine()->mutable_x()->set_travel_max_mm(400);
  task.mutable_machine()->mutable_block_origin_mm()->set_y(-10);
  EXPECT_THAT(RefusalOf(task),
              AllOf(HasSubstr("x.travel_max_mm is 400"), HasSubstr("block_origin_mm.y")));
}

// The profile may agree and the job may not keep to it.
TEST(TaskCheck, AJobBeyondThisMachineIsRefused) {
  FrozenJob task = GoodTask();
  task.mutable_job()->mutable_laser()->set_rate_hz(60);
  EXPECT_THAT(RefusalOf(task), HasSubstr("laser.rate_hz: 60 is none of the rates"));
  task = GoodTask();
  task.mutable_job()->mutable_laser()->add_channels(5);
  EXPECT_THAT(RefusalOf(task), HasSubstr("laser.channels[1]: 5"));
  task = GoodTask();
  task.mutable_job()->mutable_motion()->set_max_speed_mm_s(100);
  EXPECT_THAT(RefusalOf(task), HasSubstr("motion.max_speed_mm_s"));
}

// A change of these changes the depth of all points.
TEST(TaskCheck, OpticalValuesThatContradictTheJobAreRefused) {
  FrozenJob task = GoodTask();
  task.mutable_optics()->set_stage_per_glass_ratio(0.7);
  EXPECT_THAT(RefusalOf(task), HasSubstr("optics.stage_per_glass_ratio is 0.7"));
  task = GoodTask();
  task.mutable_optics()->set_cone_tangent(0);
  EXPECT_THAT(RefusalOf(task), HasSubstr("optics.cone_tangent"));
  task = GoodTask();
  task.mutable_optics()->set_wavelength_nm(1064);
  EXPECT_THAT(RefusalOf(task), HasSubstr("optics.wavelength_nm"));
  for (const double index :
       {0.0, 0.9, std::numeric_limits<double>::infinity(), std::nan("")}) {
    task = GoodTask();
    task.mutable_optics()->set_refractive_index(index);
    EXPECT_THAT(RefusalOf(task), HasSubstr("optics.refractive_index")) << index;
  }
}

}  // namespace
}  // namespace intaglio::synchronizer
