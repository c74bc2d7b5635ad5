#include "services/cli/machine/machine_questions.h"

#include <gmock/gmock.h>

#include <sstream>

#include "services/job/files/job_file.h"

namespace intaglio::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

MachineSpec Family(const char* name) {
  return ReadMachineFile(std::string(INTAGLIO_SOURCE_DIR "/deploy/machines/") + name +
                         ".textproto")
      .value();
}

TEST(MachineQuestions, EmptyLinesAndTheEndKeepWhatIs) {
  const MachineSpec family = Family("els-03");
  for (const char* answers : {"", "\n\n\n\n\n\n\n\n\n\n\n\n\n\n\n"}) {
    MachineSpec machine = family;
    std::istringstream in(answers);
    std::ostringstream out;
    AskAboutMachine(in, out, machine);
    EXPECT_EQ(machine.SerializeAsString(), family.SerializeAsString());
    EXPECT_THAT(out.str(), HasSubstr("name of the machine [els-03]: "));
    EXPECT_THAT(out.str(), HasSubstr("x: travel to, mm [172]: "));
    EXPECT_THAT(out.str(),
                HasSubstr("corner of the block for the axes (x y z), mm [0 0 0]"));
  }
}

// A wrong answer is asked again, with the reason.
TEST(MachineQuestions, AnswersReachTheirFields) {
  MachineSpec machine = Family("els-03");
  std::istringstream in(
      "shop 1\nshop-1\n-5\n300\n\n250\n\n\ntable\ntable\n-100 -100 0\nf50\nf70\n"
      "tcp:192.168.7.20:5000\n/dev/ttyACM0\n");
  std::ostringstream out;
  AskAboutMachine(in, out, machine);
  EXPECT_THAT(out.str(), HasSubstr("name: \"shop 1\" has characters other than"));
  EXPECT_THAT(out.str(), HasSubstr("mounted_lens: \"f50\" is no lens of this machine"));
  EXPECT_EQ(machine.name(), "shop-1");
  EXPECT_EQ(machine.x().travel_min_mm(), -5);
  EXPECT_EQ(machine.x().travel_max_mm(), 300);
  EXPECT_EQ(machine.y().travel_min_mm(), -2);
  EXPECT_EQ(machine.y().travel_max_mm(), 250);
  EXPECT_EQ(machine.cartesian().x().moves(), AXIS_MOVES_TABLE);
  EXPECT_EQ(machine.cartesian().y().moves(), AXIS_MOVES_TABLE);
  EXPECT_EQ(machine.block_origin_mm().x(), -100);
  EXPECT_EQ(machine.mounted_lens(), "f70");
  EXPECT_EQ(machine.laser_line().device(), "tcp:192.168.7.20:5000");
  EXPECT_EQ(machine.motion_line().device(), "/dev/ttyACM0");
}

TEST(MachineQuestions, ABoardIsAskedAboutItsFieldAndItsLaser) {
  MachineSpec machine = Family("bjjcz");
  // name, field, jumps, correction, five delays, laser, inputs, line.
  std::istringstream in(
      "desk\n150\n4000\n\n-0.0001\n0.00005\n0.00015\n0.001\n0.0004\n0.00002\n"
      "fibre\n99\n2\n\ntcp:192.168.7.20:5000\n");
  std::ostringstream out;
  AskAboutMachine(in, out, machine);
  EXPECT_THAT(out.str(), HasSubstr("width of the field, mm [110]: "));
  EXPECT_THAT(out.str(), HasSubstr("bjjcz_board.door_input: 99"));
  EXPECT_THAT(out.str(), Not(HasSubstr("travel")));
  EXPECT_EQ(machine.scan_head().field_mm(), 150);
  EXPECT_EQ(machine.scan_head().jump_mm_s(), 4000);
  EXPECT_THAT(out.str(), HasSubstr("scan_head.laser_on_delay_s: -0.0001"));
  EXPECT_EQ(machine.scan_head().laser_on_delay_s(), 0.00005);
  EXPECT_EQ(machine.scan_head().laser_off_delay_s(), 0.00015);
  EXPECT_EQ(machine.scan_head().jump_delay_s(), 0.001);
  EXPECT_EQ(machine.scan_head().mark_delay_s(), 0.0004);
  EXPECT_EQ(machine.scan_head().polygon_delay_s(), 0.00002);
  EXPECT_EQ(machine.bjjcz_board().laser(), BJJCZ_LASER_FIBRE);
  EXPECT_EQ(machine.bjjcz_board().door_input(), 2U);
  EXPECT_EQ(machine.bjjcz_board().gate_output(), 0U);
  EXPECT_EQ(machine.mark_line().device(), "tcp:192.168.7.20:5000");
}

TEST(MachineQuestions, ABoardOverABlockIsAskedAboutLensAndStepsOfZ) {
  MachineSpec machine = Family("bjjcz-glass");
  // name, travels, origin, lens, both lines, field, correction, z, jumps, pupils, board.
  std::istringstream in(
      "desk\n\n\n\n\n0\n90\n\nf100\n100\n0.05\n110\nf100\n\n\n140\n\n800\n0.1\n4000\n"
      "0.0003\n0.001\n0.2\n200\n210\nfibre\n1064\n20000\n");
  std::ostringstream out;
  AskAboutMachine(in, out, machine);
  EXPECT_THAT(out.str(), HasSubstr("z rests at multiples of, mm [0.066]: "));
  EXPECT_THAT(out.str(), Not(HasSubstr("moves the head or the table")));
  EXPECT_EQ(machine.z().travel_max_mm(), 90);
  EXPECT_EQ(machine.scan_head().field_mm(), 140);
  EXPECT_EQ(machine.z().steps_per_mm(), 800);
  const HeadOverBlockKinematics& head = machine.head_over_block();
  EXPECT_EQ(head.jump_and_dwell().z_step_mm(), 0.1);
  EXPECT_EQ(head.jump_and_dwell().jump_mm_s(), 4000);
  EXPECT_EQ(head.jump_and_dwell().jump_delay_s(), 0.0003);
  EXPECT_EQ(head.jump_and_dwell().dwell_s(), 0.001);
  EXPECT_EQ(head.jump_and_dwell().z_settle_s(), 0.2);
  EXPECT_THAT(out.str(), HasSubstr("lens: focal length, mm [160]: "));
  EXPECT_EQ(machine.lenses(0).name(), "f100");
  EXPECT_EQ(machine.lenses(0).focal_length_mm(), 100);
  EXPECT_EQ(machine.lenses(0).numerical_aperture(), 0.05);
  EXPECT_EQ(machine.lenses(0).free_distance_mm(), 110);
  EXPECT_EQ(machine.mounted_lens(), "f100");
  EXPECT_EQ(machine.bjjcz_board().laser(), BJJCZ_LASER_FIBRE);
  EXPECT_EQ(machine.laser().wavelength_nm(), 1064);
  EXPECT_EQ(machine.bjjcz_board().point_frequency_hz(), 20000);
  EXPECT_EQ(head.pupil_x_mm(), 200);
  EXPECT_EQ(head.pupil_y_mm(), 210);
  EXPECT_TRUE(machine.kinematics_case() == MachineSpec::kHeadOverBlock);
}

TEST(MachineQuestions, AnArmIsNotAskedAboutXAndY) {
  MachineSpec machine = Family("polar");
  std::istringstream in("");
  std::ostringstream out;
  AskAboutMachine(in, out, machine);
  EXPECT_THAT(out.str(), Not(HasSubstr("x: travel")));
  EXPECT_THAT(out.str(), HasSubstr("z: travel to"));
}

TEST(MachineQuestions, AChangeNamesFieldAndValue) {
  MachineSpec machine = Family("els-03");
  EXPECT_TRUE(ChangeField(machine, "laser.channels=1"));
  EXPECT_EQ(machine.laser().channels(), 1u);
  EXPECT_THAT(ChangeField(machine, "laser.channels").error().message,
              HasSubstr("is no field=value"));
  EXPECT_THAT(ChangeField(machine, "laser.chanels=1").error().message,
              HasSubstr("--set laser.chanels"));
}

}  // namespace
}  // namespace intaglio::cli
