#include "services/drivers/linuxcnc/hal_text.h"

#include <gtest/gtest.h>

namespace intaglio::drivers {
namespace {

// As HAL printed it (LinuxCNC 2.9, `halsampler -t`).
constexpr char kLine[] =
    "3738 12 1003.000000 7.000000 54.000000 7.000000 3.000000 2673 1.500000 -2.250000 "
    "0.000001 1.600000 -2.250000 0.000000 90 1 2 3 10.000000 ";

TEST(HalText, ReadsASampleOfHal) {
  const auto sample = ParseSample(kLine);
  ASSERT_TRUE(sample);
  EXPECT_EQ(sample->tick, 12u);
  EXPECT_EQ(sample->row, 1003u);
  EXPECT_EQ(sample->row_arm, 7u);
  EXPECT_EQ(sample->command, 54u);
  EXPECT_EQ(sample->arm, 7u);
  EXPECT_EQ(sample->motion, 3u);
  EXPECT_TRUE(sample->Has(kHalFresh) && sample->Has(kHalKey) && sample->Has(kHalWarm));
  EXPECT_FALSE(sample->Has(kHalLaser) || sample->Has(kHalLaserOk));
  EXPECT_EQ(sample->actual_mm, Vec3(1.5, -2.25, 0.000001));
  EXPECT_EQ(sample->target_mm, Vec3(1.6, -2.25, 0));
  EXPECT_EQ(sample->pulses, 90u);
  EXPECT_EQ(sample->openings, 6u);
  EXPECT_EQ(sample->periods, 10u);
}

TEST(HalText, TakesNoPartOfASample) {
  const std::string_view line = kLine;
  // Without its last field, or with another one, it is no sample.
  for (std::size_t length = 0; length < line.rfind("10.000000"); ++length)
    EXPECT_FALSE(ParseSample(line.substr(0, length))) << length;
  EXPECT_FALSE(ParseSample("overrun"));
  EXPECT_FALSE(ParseSample(std::string(line) + " 1"));
  for (const char* number : {"nan", "inf", "-1.0", "1e300", "x"}) {
    std::string changed(line);
    changed.replace(changed.find("1003.000000"), 11, number);
    EXPECT_FALSE(ParseSample(changed)) << number;
  }
  std::string lost(line);
  lost.replace(lost.find("1.500000"), 8, "nan");
  EXPECT_FALSE(ParseSample(lost));
}

// halstreamer reads these columns in this order: deploy/linuxcnc/intaglio.hal.
TEST(HalText, WritesRowsAndCommandsInTheColumnsOfTheHalFile) {
  std::string text;
  AppendText(HalRow{12, 1003, 7, 3, true, false, Vec3(1.5, -2.25, 1e-9)}, text);
  EXPECT_EQ(text, "12 1003 7 3 1 0 1.500000000 -2.250000000 0.000000001 1003\n");
  text.clear();
  AppendText(HalCommand{54, 7, 3, true, false, false, true, false, true, true, 10}, text);
  EXPECT_EQ(text, "54 7 3 1 0 0 1 0 1 1 10 54\n");
}

TEST(HalText, ReadsTheIdentity) {
  const auto identity =
      ParseIdentity("power_up 77\nperiod_ns 1000000\nserial_number L-03\n");
  ASSERT_TRUE(identity);
  EXPECT_EQ(identity->power_up, 77u);
  EXPECT_EQ(identity->period_ns, 1000000u);
  EXPECT_EQ(identity->serial_number, "L-03");
  EXPECT_TRUE(ParseIdentity("power_up 77\nperiod_ns 1000000\nserial_number \n"));
  for (const char* bad :
       {"", "power_up 0\nperiod_ns 1000000\n", "power_up 77\n",
        "power_up 77\nperiod_ns 1\n", "power_up x\nperiod_ns 1000000\n"})
    EXPECT_FALSE(ParseIdentity(bad)) << bad;
}

TEST(HalText, ReadsWholeLinesOfTheRecord) {
  EXPECT_EQ(ParsePulses("5 1.0 2.0 3.0 \n9 1.0 2.0 3.5 \n12 1.0"),
            (std::vector<std::uint32_t>{5, 9}));
  EXPECT_TRUE(ParsePulses("").empty());
  EXPECT_TRUE(ParsePulses("x\n-1 2 3 4\n").empty());
}

}  // namespace
}  // namespace intaglio::drivers
