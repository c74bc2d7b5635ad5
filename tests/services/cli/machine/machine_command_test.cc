// `intaglio machine new` and `check`, as a person calls them.

#include <gmock/gmock.h>
#include <google/protobuf/util/json_util.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "proto/machine_report.pb.h"
#include "services/cli/intaglio_program.h"
#include "services/job/files/job_file.h"
#include "tests/services/cli/typed_command.h"
#include "tests/test_folder.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::HasSubstr;

class MachineCommand : public TypedCommand {
 protected:
  int Run(std::vector<std::string> words) { return TypeToAll(words); }
  fs::path profile() const { return folder_ / "shop-1.textproto"; }
  static std::string Supplied(const std::string& name) {
    return INTAGLIO_SOURCE_DIR "/deploy/machines/" + name + ".textproto";
  }
};

TEST_F(MachineCommand, NewMakesAProfileOfAFamily) {
  ASSERT_EQ(Run({"machine", "new", Supplied("els-03"), "--out", profile().string(),
                 "--no-questions", "--set", "x.travel_max_mm=300", "laser.channels=1"}),
            0)
      << errors_;
  const auto machine = ReadMachineFile(profile());
  ASSERT_TRUE(machine) << machine.error().message;
  EXPECT_EQ(machine->name(), "shop-1");
  EXPECT_EQ(machine->x().travel_max_mm(), 300);
  EXPECT_EQ(machine->laser().channels(), 1u);
  EXPECT_EQ(Run({"machine", "check", profile().string(), "--offline"}), 0) << output_;
  EXPECT_THAT(output_, HasSubstr("shop-1: good"));
  EXPECT_EQ(Run({"machine", "new", Supplied("els-03"), "--out", profile().string()}), 2);
  EXPECT_THAT(errors_, HasSubstr("exists already"));
}

// LightBurn's 110 mm at a scale of 0.98 are a field of 112.245 mm.
TEST_F(MachineCommand, NewTakesTheSettingsOfALightBurnDevice) {
  const std::string data = INTAGLIO_SOURCE_DIR "/tests/data/devices/";
  for (const char* file : {"galvo.lbdev", "galvo.lbzip"}) {
    fs::remove(profile());
    ASSERT_EQ(Run({"machine", "new", Supplied("bjjcz-glass"), "--from", data + file,
                   "--out", profile().string(), "--no-questions", "--set",
                   "z.steps_per_mm=800", "lenses[0].focal_length_mm=163"}),
              0)
        << errors_;
    EXPECT_THAT(errors_, AllOf(HasSubstr(std::string(file) + ": the device \"UV 110\""),
                               HasSubstr("scan_head.field_mm = 112.245: 110 x 110 mm"),
                               HasSubstr("    Galvo_1_Bulge 1.0360000133514404\n"),
                               HasSubstr("    Laser_OpenMODelay 8\n")));
    const auto machine = ReadMachineFile(profile());
    ASSERT_TRUE(machine) << machine.error().message;
    EXPECT_NEAR(machine->scan_head().field_mm(), 110 / 0.98, 1e-5);
    EXPECT_EQ(machine->head_over_block().jump_and_dwell().jump_mm_s(), 4000);
    EXPECT_EQ(machine->z().steps_per_mm(), 800);
    EXPECT_EQ(machine->lenses(0).focal_length_mm(), 163);
    EXPECT_EQ(Run({"machine", "check", profile().string(), "--offline"}), 0) << output_;
  }
}

// Nothing is written of what was refused.
TEST_F(MachineCommand, NewRefusesADeviceThatIsNone) {
  const fs::path device = folder_ / "diode.lbdev";
  std::ofstream(device)
      << R"({"DeviceList": [{"Name": "GRBL", "DisplayName": "Diode"}]})";
  const auto from = [&](const std::vector<std::string>& words) {
    std::vector<std::string> all = {"machine", "new"};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), {"--out", profile().string(), "--no-questions"});
    EXPECT_EQ(Run(all), 2);
    EXPECT_FALSE(fs::exists(profile()));
    return errors_;
  };
  const std::string galvo = INTAGLIO_SOURCE_DIR "/tests/data/devices/galvo.lbdev";
  EXPECT_THAT(from({Supplied("bjjcz"), "--from", device.string()}),
              HasSubstr("diode.lbdev: has no device of a BJJCZ board (JCZFiber) but"));
  EXPECT_THAT(from({Supplied("bjjcz"), "--from", device.string() + ".gone"}),
              HasSubstr("diode.lbdev.gone"));
  EXPECT_THAT(from({Supplied("els-03"), "--from", galvo}),
              HasSubstr("galvo.lbdev: the family has no bjjcz_board"));
  EXPECT_THAT(from({"--from", galvo}), HasSubstr("--from: needs the family"));
  EXPECT_THAT(from({Supplied("bjjcz"), "--device", "UV 110"}),
              HasSubstr("--device: names a device in the file of --from"));
}

TEST_F(MachineCommand, NewListsTheFamilies) {
  setenv("INTAGLIO_SHARE", INTAGLIO_SOURCE_DIR "/deploy", 1);
  EXPECT_EQ(Run({"machine", "new"}), 0);
  unsetenv("INTAGLIO_SHARE");
  EXPECT_THAT(output_, HasSubstr("els-03           ELS-03, the laser engraver of Troch"));
  EXPECT_THAT(output_, HasSubstr("proposes it in ch. 8: the table carries the block"));
}

// The profile names the template and calibrates the pulse energy: half of the energy is
// at setting 0.6.
TEST_F(MachineCommand, PostTakesTemplateAndSettingOfTheProfile) {
  setenv("INTAGLIO_MATERIALS_DB", (folder_ / "materials.db").c_str(), 1);
  MachineSpec machine = ReadMachineFile(Supplied("els-03")).value();
  machine.set_post(INTAGLIO_SOURCE_DIR "/deploy/post/grbl.post");
  machine.mutable_laser()->set_pulse_energy_mj(15);
  for (const auto& [setting, energy] : {std::pair{0.2, 0.0}, {0.6, 15.0}, {1.0, 30.0}}) {
    EnergyPoint& point = *machine.mutable_laser()->add_energy_calibration();
    point.set_setting_ratio(setting);
    point.set_energy_mj(energy);
  }
  ASSERT_TRUE(WriteMachineFile(profile(), machine));
  const fs::path path = folder_ / "path.xyz", program = folder_ / "p.nc";
  std::ofstream(path) << "10 10 10\n11 10 10\n";
  ASSERT_EQ(Run({"post", "--path", path.string(), "--block", "30", "30", "20",
                 "--machine", profile().string(), "--out", program.string()}),
            0)
      << errors_;
  std::ifstream in(program);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  EXPECT_THAT(text, HasSubstr("S600 F3000"));
  EXPECT_EQ(Run({"post", "--path", path.string(), "--block", "30", "30", "20",
                 "--machine", Supplied("els-03"), "--out", program.string()}),
            2);
  EXPECT_THAT(errors_, HasSubstr("has no field post"));
}

TEST_F(MachineCommand, NewWritesNoProfileWithMistakes) {
  EXPECT_EQ(Run({"machine", "new", Supplied("els-03"), "--out", profile().string(),
                 "--no-questions", "--set", "x.travel_max_mm=-9", "laser.channels=7"}),
            2);
  EXPECT_THAT(errors_, AllOf(HasSubstr("x.travel_min_mm: -2 is not below"),
                             HasSubstr("laser.channels: 7 is outside 1..4")));
  EXPECT_FALSE(fs::exists(profile()));
}

TEST_F(MachineCommand, CheckPrintsEverythingAtOnce) {
  MachineSpec machine = ReadMachineFile(Supplied("els-03")).value();
  machine.mutable_x()->set_travel_min_mm(200);
  machine.mutable_laser()->set_channels(0);
  machine.mutable_lenses(1)->set_name("f43");
  machine.set_mounted_lens("f50");
  machine.set_post("linuxcn");
  machine.mutable_laser_line()->set_device("tcp:nowhere");
  machine.mutable_motion_line()->set_protocol("no-such-family");
  ASSERT_TRUE(WriteMachineFile(profile(), machine));
  EXPECT_EQ(Run({"machine", "check", profile().string()}), 2);
  EXPECT_THAT(output_, AllOf(HasSubstr("x.travel_min_mm: 200 is not below"),
                             HasSubstr("laser.channels: 0 is outside 1..4"),
                             HasSubstr("lenses[1].name: \"f43\" is already"),
                             HasSubstr("mounted_lens: \"f50\" is no lens"),
                             HasSubstr("laser_line.device: "),
                             HasSubstr("post: 'linuxcn' is neither a file nor"),
                             HasSubstr("motion_line.protocol: no driver for 'no-such-"),
                             HasSubstr("7 to correct")));
}

// As the message of proto/machine_report.proto, for programs.
TEST_F(MachineCommand, CheckPrintsJson) {
  const std::string grbl = Supplied("grbl");
  EXPECT_EQ(Run({"machine", "check", grbl, "--offline", "--json"}), 0) << output_;
  MachineCheck check;
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(output_, &check).ok())
      << output_;
  EXPECT_TRUE(check.good());
  EXPECT_EQ(check.machine(), "grbl");
  EXPECT_EQ(check.profile(), grbl);
  MachineSpec machine = ReadMachineFile(grbl).value();
  machine.mutable_laser()->clear_max_unsettled_points();
  ASSERT_TRUE(WriteMachineFile(profile(), machine));
  EXPECT_EQ(Run({"machine", "check", profile().string(), "--json"}), 2);
  ASSERT_TRUE(google::protobuf::util::JsonStringToMessage(output_, &check).ok())
      << output_;
  EXPECT_FALSE(check.good());
  ASSERT_EQ(check.findings_size(), 1);
  EXPECT_EQ(check.findings(0).field(), "laser.max_unsettled_points");
  EXPECT_THAT(check.findings(0).message(), HasSubstr("is missing"));
  EXPECT_TRUE(check.lines().empty()) << "no line is opened for a wrong profile";
}

// Devices that are not there are named, and are no mistake of the profile.
TEST_F(MachineCommand, CheckNamesLinesThatItCannotCompare) {
  MachineSpec machine = ReadMachineFile(Supplied("els-03")).value();
  machine.mutable_laser_line()->set_device((folder_ / "none").string());
  machine.mutable_motion_line()->set_protocol("virtual-cell");
  ASSERT_TRUE(WriteMachineFile(profile(), machine));
  EXPECT_EQ(Run({"machine", "check", profile().string()}), 0) << output_;
  EXPECT_THAT(output_, AllOf(HasSubstr("laser_line: not compared with the device: "),
                             HasSubstr("motion_line: not compared with the device: "
                                       "controllers of the protocol virtual-cell")));
}

TEST_F(MachineCommand, CheckNamesTheArmsThatReachABlock) {
  EXPECT_EQ(Run({"machine", "check", Supplied("polar"), "--offline"}), 0) << output_;
  // The nearest edge is 200 - 90 mm from the arm's axis; the margin of 0.1 rad needs
  // 1.244 mm more.
  EXPECT_THAT(output_,
              HasSubstr("note: block of 50 x 50 mm at block_origin_mm: an arm of "
                        "111.244 to 286.758 mm reaches all of the block"));
}

}  // namespace
}  // namespace intaglio::cli
