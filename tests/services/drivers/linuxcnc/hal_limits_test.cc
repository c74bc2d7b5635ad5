#include "services/drivers/linuxcnc/hal_limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/job/files/job_file.h"
#include "tests/test_folder.h"

namespace intaglio::drivers {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::StartsWith;

MachineSpec Supplied() {
  return ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/linuxcnc.textproto")
      .value();
}

std::map<std::string, double> SuppliedPins() {
  return ParseHalPins(
      test::ContentOf(INTAGLIO_SOURCE_DIR "/deploy/linuxcnc/simulated.hal"));
}

constexpr std::uint32_t kPeriod_ns = 1'000'000;

TEST(HalPins, AreTheNumbersThatAFileSets) {
  const auto pins = ParseHalPins(
      "# setp no.1 1\nsetp a.b 2.5\n  setp\tc -3e2 # mm\nsetp a.b 4\nsetp d TRUE\n"
      "setp e\nsetp\nnet x => y\nsetp f nan\nsetp g 1x\r\nsetp h 7\r\nsetp i 8");
  EXPECT_EQ(pins,
            (std::map<std::string, double>{{"a.b", 4}, {"c", -300}, {"h", 7}, {"i", 8}}));
}

TEST(HalLimits, OfTheSuppliedFileAgreeWithTheSuppliedProfile) {
  EXPECT_THAT(CheckLinuxcncProfile(Supplied()), IsEmpty());
  EXPECT_THAT(CompareHal(Supplied(), {1, kPeriod_ns, ""}, SuppliedPins()), IsEmpty());
  EXPECT_THAT(CompareHal(Supplied(), {1, kPeriod_ns, ""}, {}), IsEmpty());
}

TEST(HalLimits, EachDifferenceNamesFieldPinAndRemedy) {
  struct Case {
    const char* pin;
    double value;
    const char *field, *text;
  };
  for (const Case& c :
       {Case{"x-limit.min", 0, "x.travel_min_mm: -5 ", "x-limit.min, 0; raise"},
        Case{"y-limit.max", 90, "y.travel_max_mm: 95 ", "y-limit.max, 90; reduce"},
        Case{"z-limit.maxv", 50, "z.max_speed_mm_s: 50 ", "z-limit.maxv, 50,"},
        Case{"x-limit.maxa", 1500, "x.max_acceleration_mm_s2: 2000 ", "x-limit.maxa"},
        Case{"y-near.difference", 0.01, "position_tolerance_um: 5 ",
             "make both the same"},
        Case{"lamp-delay.on-delay", 30, "laser.warm_up_s: 0.2 ", "30 s; raise it"}}) {
    auto pins = SuppliedPins();
    ASSERT_TRUE(pins.contains(c.pin)) << c.pin;
    pins[c.pin] = c.value;
    const auto found = CompareHal(Supplied(), {1, kPeriod_ns, ""}, pins);
    ASSERT_EQ(found.size(), 1u) << c.pin;
    EXPECT_THAT(found[0].message, StartsWith(c.field));
    EXPECT_THAT(found[0].message, HasSubstr(c.text));
  }
}

TEST(HalLimits, OfACutterAreThoseOfItsWay) {
  const MachineSpec cutter =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/linuxcnc-cutter.textproto")
          .value();
  HalIdentity identity{1, kPeriod_ns, "", HalLaser::kBeam};
  EXPECT_THAT(CompareBeamHal(cutter, identity, SuppliedPins()), IsEmpty());
  const auto first = [&](const MachineSpec& machine, const char* pin, double value) {
    auto pins = SuppliedPins();
    if (*pin != 0) pins[pin] = value;
    const auto found = CompareBeamHal(machine, identity, pins);
    return found.empty() ? "" : found.front().message;
  };
  EXPECT_THAT(first(cutter, "x-limit.max", 90), StartsWith("x.travel_max_mm: 95 "));
  EXPECT_THAT(first(cutter, "y-limit.maxa", 1500),
              StartsWith("y.max_acceleration_mm_s2: 2000 "));
  MachineSpec lags = cutter;
  lags.set_stage_lag_s(0.004);
  EXPECT_THAT(first(lags, "", 0),
              HasSubstr("0.200 mm behind its row there by the drive of the profile, and "
                        "x-near.difference, 0.005 mm"));
  EXPECT_THAT(CompareBeamHal(lags, identity, {{"x-near.difference", 0.4}}), IsEmpty());
  identity.laser = HalLaser::kPulses;
  EXPECT_THAT(first(cutter, "", 0), HasSubstr("was started without --beam"));
  MachineSpec other = cutter;
  other.mutable_mark_line()->set_serial_number("L-02");
  EXPECT_THAT(first(other, "", 0),
              StartsWith("mark_line.serial_number: \"L-02\" is expected"));
}

TEST(HalIdentity, NamesTheLaserThatHalWasStartedWith) {
  const std::string text = "power_up 5\nperiod_ns 1000000\nserial_number \n";
  EXPECT_EQ(ParseIdentity(text)->laser, HalLaser::kPulses);
  EXPECT_EQ(ParseIdentity(text + "laser pulses\n")->laser, HalLaser::kPulses);
  EXPECT_EQ(ParseIdentity(text + "laser beam\n")->laser, HalLaser::kBeam);
}

TEST(HalLimits, RatesAreWholePartsOfTheServoRate) {
  MachineSpec machine = Supplied();
  machine.mutable_motion_line()->set_serial_number("L-02");
  std::string all;
  for (const Error& error : CompareHal(machine, {1, 3'000'000, "L-01"}, {}))
    all += error.message + "\n";
  EXPECT_THAT(all, HasSubstr("motion_line.serial_number: \"L-02\" is expected"));
  EXPECT_THAT(all, HasSubstr("laser.rates_hz[0]: 10 Hz is not the servo rate, 333.333"));
  machine.mutable_laser()->mutable_timing()->set_shutter_time_ms(3);
  machine.mutable_laser()->set_channels(2);
  machine.set_pulse_trigger(PULSE_TRIGGER_AT_PLACE);
  EXPECT_EQ(CheckLinuxcncProfile(machine).size(), 3u);
}

}  // namespace
}  // namespace intaglio::drivers
