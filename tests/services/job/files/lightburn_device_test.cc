// Devices that LightBurn exports, and the profile that follows. The expected numbers are
// computed here from the file's own, by the rule of the programs that the header cites: a
// mm is 65536 / width times the scale in units of the board.

#include "services/job/files/lightburn_device.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "services/job/checks/job_check.h"
#include "services/job/files/job_file.h"
#include "services/job/files/lightburn_profile.h"

namespace intaglio {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::StartsWith;

constexpr double kScale = 0.9800000190734863, kWidthMm = 110;

std::string BytesOf(const std::string& name) {
  std::ifstream in(INTAGLIO_SOURCE_DIR "/tests/data/devices/" + name, std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  return bytes.str();
}

/// The device file with one text in place of another, which is there once.
std::string With(const std::string& what, const std::string& other) {
  std::string text = BytesOf("galvo.lbdev");
  const auto at = text.find(what);
  EXPECT_NE(at, text.npos) << what;
  EXPECT_EQ(text.find(what, at + 1), text.npos) << what;
  return at == text.npos ? text : text.replace(at, what.size(), other);
}

std::string ErrorOf(std::string_view bytes, const std::string& name = "") {
  const auto device = ReadLightBurnDevice(bytes, "uv.lbdev", name);
  return device ? "no error" : device.error().message;
}

MachineSpec Supplied(const std::string& name) {
  return ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/" + name + ".textproto")
      .value();
}

TEST(LightBurnDevice, WhatPublicProgramsAgreeOnIsRead) {
  for (const char* file : {"galvo.lbdev", "galvo.lbzip"}) {
    const auto device = ReadLightBurnDevice(BytesOf(file), file);
    ASSERT_TRUE(device) << device.error().message;
    EXPECT_EQ(device->name, "UV 110");
    EXPECT_EQ(device->width_mm, kWidthMm);
    EXPECT_EQ(device->height_mm, kWidthMm);
    EXPECT_EQ(device->x_scale_ratio, kScale);
    EXPECT_EQ(device->y_scale_ratio, kScale);
    EXPECT_EQ(device->jump_mm_s, 4000);
    EXPECT_EQ(device->min_pulse_hz, 40'000);  // 40 kHz
    EXPECT_EQ(device->max_pulse_hz, 100'000);
  }
}

// Each key of the file is either read or named.
TEST(LightBurnDevice, WhatIsNotReadIsNamedWithItsValue) {
  const auto device = ReadLightBurnDevice(BytesOf("galvo.lbdev"), "uv.lbdev");
  ASSERT_TRUE(device);
  EXPECT_THAT(device->field_not_read,
              testing::ElementsAre(
                  DeviceSetting{"FieldOffsetY", "0.3499999940395355"},
                  DeviceSetting{"Galvo_1_Bulge", "1.0360000133514404"},
                  DeviceSetting{"Galvo_1_Sign", "1"},
                  DeviceSetting{"Galvo_1_Trapezoid", "0.996999979019165"},
                  DeviceSetting{"Galvo_2_Bulge", "0.9589999914169312"},
                  DeviceSetting{"Galvo_2_Sign", "-1"}, DeviceSetting{"MirrorX", "false"},
                  DeviceSetting{"MirrorY", "true"}));
  EXPECT_THAT(device->not_read, Contains(DeviceSetting{"Laser_OpenMODelay", "8"}));
  EXPECT_THAT(device->not_read, Contains(DeviceSetting{"Laser_Type", "3"}));
  EXPECT_THAT(device->not_read, Contains(DeviceSetting{"GUID", "\"AbCdEfGhIj\""}));
  EXPECT_THAT(device->not_read,
              Contains(DeviceSetting{"DefaultCutList", "a list of 0 values"}));
  constexpr std::size_t kRead = 11,
                        kOfTheList = 1;  // Name, Settings and DisplayName, too
  const std::string text = BytesOf("galvo.lbdev");
  std::size_t keys = 0;
  for (const char c : text.substr(0, text.find("\"DisplayName\": \"Diode\"")))
    keys += c == ':';
  EXPECT_EQ(device->field_not_read.size() + device->not_read.size(),
            keys - kRead - kOfTheList);
}

TEST(LightBurnDevice, EachAxisHasTheScaleOfItsMirror) {
  const std::string first = "\"Galvo_1_Scale\": 0.9800000190734863";
  const auto second_is_x =
      ReadLightBurnDevice(With(first, "\"Galvo_1_Scale\": 1.02"), "a");
  ASSERT_TRUE(second_is_x);
  EXPECT_EQ(second_is_x->x_scale_ratio, kScale);
  EXPECT_EQ(second_is_x->y_scale_ratio, 1.02);
  std::string text = With(first, "\"Galvo_1_Scale\": 1.02");
  text.replace(text.find("\"Galvo_1_is_X\": false"), 21, "\"Galvo_1_is_X\": true");
  const auto first_is_x = ReadLightBurnDevice(text, "a");
  ASSERT_TRUE(first_is_x) << first_is_x.error().message;
  EXPECT_EQ(first_is_x->x_scale_ratio, 1.02);
  EXPECT_EQ(first_is_x->y_scale_ratio, kScale);
}

TEST(LightBurnDevice, AWrongValueIsNamedWithItsKeyItsValueAndTheRemedy) {
  EXPECT_THAT(ErrorOf(With("\"Width\": 110", "\"Width\": \"110\"")),
              AllOf(StartsWith("uv.lbdev: DeviceList[0].Width: \"110\" is not a number"),
                    HasSubstr("export the device again")));
  EXPECT_THAT(ErrorOf(With("\"Width\": 110", "\"Wide\": 110")),
              HasSubstr("DeviceList[0].Width: is missing"));
  // Inches, meters and Hz in place of mm, mm/s and kHz, and a scale in per cent.
  EXPECT_THAT(ErrorOf(With("\"Width\": 110", "\"Width\": 0.11")),
              HasSubstr("DeviceList[0].Width: 0.11 is not in 1..2000 mm"));
  EXPECT_THAT(ErrorOf(With("Speed\": 4000", "Speed\": 4")),
              HasSubstr("Settings.Default_JumpSpeed: 4 is not in 10..100000 mm/s"));
  EXPECT_THAT(ErrorOf(With("MaxFreq\": 100", "MaxFreq\": 100000")),
              HasSubstr("Settings.Laser_MaxFreq: 100000 is not in 0.001..10000 kHz"));
  EXPECT_THAT(ErrorOf(With("2_Scale\": 0.9800000190734863", "2_Scale\": 98")),
              HasSubstr("Settings.Galvo_2_Scale: 98 is not in 0.5..2 as a ratio, 1 for"));
  EXPECT_THAT(ErrorOf(With("MinFreq\": 40", "MinFreq\": 400")),
              HasSubstr("Settings.Laser_MinFreq: 400 is not below Laser_MaxFreq, 100"));
  EXPECT_THAT(ErrorOf(With("is_X\": false", "is_X\": 0")),
              HasSubstr("Settings.Galvo_1_is_X: 0 is not true or false"));
  EXPECT_THAT(ErrorOf(With("1_Scale\": 0.9800000190734863", "1_Scale\": 1e999")),
              StartsWith("uv.lbdev: "));
  EXPECT_THAT(ErrorOf(With("\"Width\": 110", "\"Width\": NaN")),
              StartsWith("uv.lbdev: "));
  EXPECT_THAT(ErrorOf(With("\"Settings\": {\n                \"Cor",
                           "\"Settings\": 5, \"Other\": {\n                \"Cor")),
              HasSubstr("DeviceList[0].Settings: 5 is not a group of keys"));
}

TEST(LightBurnDevice, TheDeviceOfABoardIsFoundAmongOthers) {
  EXPECT_EQ(ErrorOf(BytesOf("galvo.lbdev"), "UV 110"), "no error");
  EXPECT_THAT(ErrorOf(BytesOf("galvo.lbdev"), "Uv"),
              HasSubstr("has no device \"Uv\"; it has \"UV 110\" (JCZFiber), \"Diode\" "
                        "(GRBL)"));
  EXPECT_THAT(
      ErrorOf(BytesOf("galvo.lbdev"), "Diode"),
      AllOf(HasSubstr("no device of a BJJCZ board (JCZFiber) but \"Diode\" (GRBL)"),
            HasSubstr("intaglio machine new")));
  EXPECT_THAT(ErrorOf(With("\"GRBL\"", "\"JCZFiber\"")),
              HasSubstr("has 2 devices of BJJCZ boards: \"UV 110\" (JCZFiber), \"Diode\" "
                        "(JCZFiber); name one of them by --device"));
}

TEST(LightBurnDevice, WhatIsNoDeviceIsRefused) {
  for (const char* text : {"", "x", "[1]", "{\"DeviceList\": [", "5", "\"DeviceList\""})
    EXPECT_THAT(ErrorOf(text), StartsWith("uv.lbdev: ")) << text;
  for (const char* text : {"{}", "{\"DeviceList\": []}", "{\"DeviceList\": 5}"})
    EXPECT_THAT(ErrorOf(text), HasSubstr("DeviceList: has no device")) << text;
  EXPECT_THAT(ErrorOf("{\"DeviceList\": [5]}"),
              HasSubstr("DeviceList[0]: 5 is not a group of keys"));
  const std::string deep = std::string(5000, '[') + std::string(5000, ']');
  EXPECT_THAT(ErrorOf("{\"DeviceList\": " + deep + "}"), HasSubstr("more than 32 deep"));
  EXPECT_THAT(ErrorOf("{\"DeviceList\": ['\"', " + deep + "]}"),
              HasSubstr("more than 32 deep"));
  EXPECT_EQ(ErrorOf(With("\"AbCdEfGhIj\"", "\"" + std::string(99, '[') + "\"")),
            "no error");
  EXPECT_EQ(ErrorOf(With("\"AbCdEfGhIj\"", "\"\\\"" + std::string(99, '[') + "\"")),
            "no error");
  std::string large(kMaxLightBurnTextBytes + 1, ' ');
  EXPECT_THAT(ErrorOf(large), HasSubstr("1048577 bytes are more than 1048576"));
  // What a terminal would obey is not shown.
  EXPECT_THAT(ErrorOf(With("\"UV 110\"", "\"\\u001b[2J\\u009b5m\""), "other"),
              testing::Not(AnyOf(HasSubstr("\x1b"), HasSubstr("\xc2\x9b"))));
}

TEST(LightBurnDevice, ADamagedArchiveIsRefused) {
  const std::string whole = BytesOf("galvo.lbzip");
  for (std::size_t size = 2; size < whole.size(); size += 7) {
    EXPECT_THAT(ErrorOf(whole.substr(0, size)), StartsWith("uv.lbdev: ")) << size;
  }
  std::string renamed = whole;
  for (auto at = renamed.find(".lbdev"); at != renamed.npos; at = renamed.find(".lbdev"))
    renamed.replace(at, 6, ".other");
  EXPECT_THAT(ErrorOf(renamed), HasSubstr("has 0 files of a device (.lbdev)"));
  // The directory declares 4 GB of it: refused before memory is taken.
  std::string huge = whole;
  const auto entry = huge.rfind("PK\1\2");
  huge.replace(entry + 24, 4, "\xfe\xff\xff\xff");
  EXPECT_THAT(ErrorOf(huge), HasSubstr("4294967294 bytes are more than 1048576"));
}

// A place of 25 mm: LightBurn commands 25 * 65536 / 110 * 0.98 units, the profile's board
// 25 * 65536 / field_mm.
TEST(LightBurnProfile, AMillimetreIsAsManyUnitsAsAtTheDevice) {
  const auto device = ReadLightBurnDevice(BytesOf("galvo.lbdev"), "uv.lbdev").value();
  for (const char* family : {"bjjcz", "bjjcz-glass"}) {
    MachineSpec machine = Supplied(family);
    const auto sentences = ApplyDevice(device, machine);
    ASSERT_TRUE(sentences) << sentences.error().message;
    EXPECT_NEAR(25 * 65536 / machine.scan_head().field_mm(),
                25 * 65536 / kWidthMm * kScale, 1e-6);
    EXPECT_EQ(machine.scan_head().jump_mm_s(), 4000);
    EXPECT_TRUE(CheckMachine(machine).empty())
        << JoinErrors(CheckMachine(machine)).message;
    EXPECT_THAT(*sentences,
                Contains("scan_head.field_mm = 112.245: 110 x 110 mm over the "
                         "scales 0.98 (x) and 0.98 (y)"));
  }
}

TEST(LightBurnProfile, PointsTakeJumpsTravelAndTheLasersRange) {
  const auto device = ReadLightBurnDevice(BytesOf("galvo.lbdev"), "uv.lbdev").value();
  MachineSpec machine = Supplied("bjjcz-glass");
  ASSERT_EQ(machine.bjjcz_board().point_frequency_hz(), 30'000);
  const auto sentences = ApplyDevice(device, machine);
  ASSERT_TRUE(sentences);
  EXPECT_EQ(machine.head_over_block().jump_and_dwell().jump_mm_s(), 4000);
  EXPECT_EQ(machine.x().travel_min_mm(), -kWidthMm / 2);
  EXPECT_EQ(machine.y().travel_max_mm(), kWidthMm / 2);
  EXPECT_EQ(machine.bjjcz_board().point_frequency_hz(), 40'000);
  EXPECT_THAT(*sentences, Contains(HasSubstr("point_frequency_hz = 40000: within")));
}

// Scales 1 and 0.99: fields of 110 and 111.111 mm, mean 110.5556; at 55 mm x is 0.5025 %
// of it, 276.4 um, too near.
TEST(LightBurnProfile, ScalesThatDifferAreNamedByWhatTheyCost) {
  std::string text = With("2_Scale\": 0.9800000190734863", "2_Scale\": 1");
  text.replace(text.find("0.9800000190734863"), 18, "0.99");
  const auto device = ReadLightBurnDevice(text, "uv.lbdev");
  ASSERT_TRUE(device);
  MachineSpec machine = Supplied("bjjcz");
  const auto sentences = ApplyDevice(*device, machine);
  ASSERT_TRUE(sentences);
  EXPECT_NEAR(machine.scan_head().field_mm(), 110.5556, 1e-4);
  EXPECT_THAT(*sentences,
              Contains(HasSubstr("at the border x is 276 um too near and y as "
                                 "much too far")));
  LightBurnDevice oblong = *device;
  oblong.height_mm = 70;
  const MachineSpec before = machine;
  const auto refused = ApplyDevice(oblong, machine);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("70.7071 mm"));
  EXPECT_EQ(machine.SerializeAsString(), before.SerializeAsString());
}

TEST(LightBurnProfile, AFamilyWithoutTheBoardIsRefused) {
  const auto device = ReadLightBurnDevice(BytesOf("galvo.lbdev"), "uv.lbdev").value();
  MachineSpec machine = Supplied("els-03");
  const auto refused = ApplyDevice(device, machine);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, HasSubstr("choose bjjcz (marks) or bjjcz-glass"));
}

}  // namespace
}  // namespace intaglio
