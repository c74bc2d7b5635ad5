// The conformance of the virtual grbl: one test for each fact that was measured on
// grblHAL and on grbl 1.1h. Those about states are in virtual_grbl_states_test.cc.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/services/drivers/grbl/virtual_grbl_host.h"

namespace intaglio::grbl {
namespace {

using Host = VirtualHost;

// grblHAL was measured with a full line, the 328P with one line at a time: only
// so the figures agree with the pulses a second. 10 %: the turn of the host, 0.1 ms.
TEST(VirtualGrbl, TakesAsManyLinesASecondAsMeasuredAt115200) {
  const auto streamed = [](const std::string& line) {
    Host host(GrblHal());
    host.receive_bytes = 1023;
    return 500 / host.Stream(std::vector(500, line));
  };
  EXPECT_NEAR(streamed("G90G1F500"), 816, 80);
  EXPECT_NEAR(streamed("G90G1G21G17G54F500"), 526, 50);
  Host host;
  const double begin = host.grbl.motion().now_us();
  for (int i = 0; i < 50; ++i) host.Ask("G90G1F500");
  EXPECT_NEAR(50 / (host.grbl.motion().now_us() - begin) * 1e6, 363, 36);
}

TEST(VirtualGrbl, ReceiveBufferHolds128BytesAnd1023InHal) {
  for (auto [options, bytes] : {std::pair(Grbl11(), 128U), std::pair(GrblHal(), 1023U)}) {
    Host host(options);
    host.Ask("G1F600X1");
    host.Ask("G90");
    host.grbl.Write("!");
    host.Run(0.1);
    host.grbl.Write(std::string(bytes, 'G'));
    host.Run(0.2);
    EXPECT_EQ(host.grbl.lost_bytes(), 0U);
    host.grbl.Write("GG");
    host.Run(0.1);
    EXPECT_EQ(host.grbl.lost_bytes(), 2U) << "what does not fit is lost";
  }
}

TEST(VirtualGrbl, PlannerHolds15BlocksAnd100InHal) {
  for (auto [options, blocks] : {std::pair(Grbl11(), 15), std::pair(GrblHal(), 100)}) {
    Host host(options);
    host.Ask("G91G1F60");
    host.read.clear();
    for (int i = 0; i < blocks + 3; ++i) {
      host.grbl.Write("X1\n");
      host.Run(0.005);
    }
    EXPECT_EQ(host.Count("ok"), blocks) << "one more waits for room";
    EXPECT_NE(host.Status().find("Bf:0,"), std::string::npos);
  }
}

TEST(VirtualGrbl, LaserSwitchesAtTheRightStep) {
  for (auto options : {Grbl11(), GrblHal()}) {
    Host host(Quick(options));
    host.Stream(PulsedLine(50));
    host.UntilIdle();
    const auto& flashes = host.grbl.motion().flashes();
    ASSERT_EQ(flashes.size(), 50U);
    for (int i = 0; i < 50; ++i) {
      const double step = 250 * 0.1 * i;
      EXPECT_LE(std::abs(double(flashes[i].on_at[0]) - step), 1) << i;
      EXPECT_LE(std::abs(double(flashes[i].off_at[0]) - (step + 12.5)), 1.5) << i;
    }
    EXPECT_EQ(host.grbl.motion().lit_at_rest_us(), 0);
  }
}

TEST(VirtualGrbl, PulsesASecondMovingAt50MmS) {
  Host hal(Quick(GrblHal())), grbl11(Quick(Grbl11()));
  hal.receive_bytes = 1023;
  // Measured: 279 and 219; the acceleration of that measurement is not known.
  EXPECT_NEAR(500 / hal.Stream(PulsedLine(500)), 279, 70);
  EXPECT_NEAR(500 / grbl11.Stream(PulsedLine(500)), 219, 55);
}

TEST(VirtualGrbl, APulseOfM3AtRestLastsADwellOf50Ms) {
  Host host;
  host.Ask("G1F600");
  const double begin = host.grbl.motion().now_us();
  for (int i = 0; i < 5; ++i) {
    for (const char* line : {"M3S1000", "G4P0.002", "M5"}) host.Ask(line);
  }
  const double rate = 5 / (host.grbl.motion().now_us() - begin) * 1e6;
  EXPECT_GT(rate, 10);
  EXPECT_LT(rate, 20);
  ASSERT_EQ(host.grbl.motion().flashes().size(), 5U);
  for (const Flash& flash : host.grbl.motion().flashes()) {
    EXPECT_GE(flash.at_rest_us, 50000);
    EXPECT_LE(flash.at_rest_us, 60000);
  }
}

TEST(VirtualGrbl, OkMeansQueuedAndNotDone) {
  Host host;
  EXPECT_EQ(host.Ask("G1X10F600"), "ok");
  EXPECT_LT(host.grbl.WorkPosition_mm().x(), 0.5);
  host.UntilIdle();
  EXPECT_EQ(host.grbl.WorkPosition_mm().x(), 10);
}

TEST(VirtualGrbl, OkOfADwellMeansThatThePlannerIsEmpty) {
  Host host;
  host.Ask("G1X3F600");
  EXPECT_EQ(host.Ask("G4P0"), "ok");
  EXPECT_EQ(host.grbl.WorkPosition_mm().x(), 3);
}

TEST(VirtualGrbl, ADwellLastsAtLeast50Ms) {
  Host host;
  const double begin = host.grbl.motion().now_us();
  host.Ask("G4P0");
  EXPECT_GE(host.grbl.motion().now_us() - begin, 50000);
  EXPECT_LE(host.grbl.motion().now_us() - begin, 60000);
}

TEST(VirtualGrbl, M3InG0FiresNothing) {
  Host host;
  host.Ask("M3S1000");
  host.Ask("G0X5");
  host.UntilIdle();
  EXPECT_TRUE(host.grbl.motion().flashes().empty());
}

TEST(VirtualGrbl, M64ActsWhenItIsParsed) {
  Host host;
  host.Ask("G1X12F600");
  host.Ask("M64P0");
  EXPECT_TRUE(host.grbl.output_on());
  EXPECT_LT(host.grbl.output_at()[0], 250) << "some 12 mm early";
}

TEST(VirtualGrbl, M62CrashesHalAndIsUnknownTo11) {
  Host grbl11, hal(GrblHal());
  EXPECT_EQ(grbl11.Ask("M62P0"), "error:20");
  hal.grbl.Write("M62P0\n");
  hal.Run(1);
  EXPECT_TRUE(hal.grbl.crashed());
  EXPECT_EQ(hal.Status(), "");
}

TEST(VirtualGrbl, M4LosesOneOf400PulsesWhileItAccelerates) {
  VirtualGrblOptions options = Quick(GrblHal());
  options.motion.lose_dynamic_every = 400;
  Host host(options);
  host.receive_bytes = 1023;
  std::vector<std::string> lines = PulsedLine(0);
  for (int i = 0; i < 400; ++i) {  // from rest each time
    lines.push_back(fmt::format("G1X{:.2f}S1000", 0.02 * i + 0.01));
    lines.push_back(fmt::format("G1X{:.2f}S0", 0.02 * i + 0.02));
    if (i % 8 == 7) lines.emplace_back("G4P0");
  }
  host.Stream(lines);
  host.UntilIdle();
  EXPECT_EQ(host.grbl.motion().flashes().size(), 399U);
}

TEST(VirtualGrbl, HalNotHomedIgnoresItsSoftLimits) {
  VirtualGrblOptions options = GrblHal();
  options.soft_limits = true;
  options.motion.max_speed_mm_s = 5000;
  options.motion.acceleration_mm_s2 = 1e5;
  Host host(options);
  EXPECT_EQ(host.Ask("$J=G91X-5045F300000"), "ok");
  host.UntilIdle();
  EXPECT_EQ(host.grbl.WorkPosition_mm().x(), -5045);
}

TEST(VirtualGrbl, HalTakesANumberOf90Digits) {
  VirtualGrblOptions options = GrblHal();
  options.soft_limits = true;
  Host host(options);
  EXPECT_EQ(host.Ask("G1F6000X" + std::string(70, '9')), "ok");
  host.Run(0.5);
  EXPECT_GT(host.grbl.WorkPosition_mm().x(), 10) << "it drives off";
}

TEST(VirtualGrbl, Grbl11RefusesAJogBeyondTheTravelWithError15) {
  VirtualGrblOptions options;
  options.soft_limits = true;
  Host host(options);
  EXPECT_EQ(host.Ask("$J=G91X60F600"), "error:15");
}

TEST(VirtualGrbl, Grbl11IsMuteAfterAlarm2UntilReset) {
  VirtualGrblOptions options;
  options.soft_limits = true;
  Host host(options);
  host.grbl.Write("G1X60F600\n");
  host.Run(0.1);
  EXPECT_EQ(host.Count("ALARM:2"), 1);
  EXPECT_EQ(host.Status(), "");
  host.grbl.Write("\x18");
  host.Run(0.1);
  EXPECT_NE(host.Status().find("<Alarm"), std::string::npos);
}

TEST(VirtualGrbl, ThePwmOfA328PTakesUpToAMillisecond) {
  VirtualGrblOptions options = Quick(Grbl11());
  options.motion.pwm_period_us = 1000;
  Host host(options);
  host.Stream({"M4S0", "G90G1F3000", "X5", "X5.01S1000", "X10S0",  // 0.2 ms
               "X10.5S1000", "X15S0"});
  host.UntilIdle();
  const auto& flashes = host.grbl.motion().flashes();
  ASSERT_LE(flashes.size(), 2U) << "a short pulse may vanish";
  EXPECT_GE(flashes.back().on_at[0], 2500);
  EXPECT_LE(flashes.back().on_at[0], 2500 + 250 * 50 / 1000 + 1);
}

TEST(VirtualGrbl, JogCancelBrakesAndForgetsTheJog) {
  Host host;
  host.Ask("M5S0");
  EXPECT_EQ(host.Ask("$J=G91G21X40F3000"), "ok");
  host.Run(0.2);
  host.grbl.Write("\x85");
  host.UntilIdle();
  EXPECT_LT(host.grbl.WorkPosition_mm().x(), 20);
  EXPECT_EQ(host.Ask("$J=G90X0F3000"), "ok");
}

TEST(VirtualGrbl, G10L20SetsTheWorkZero) {
  Host host;
  host.Ask("$J=G91X5F3000");
  host.UntilIdle();
  EXPECT_EQ(host.Ask("G10L20P1X0Y0Z0"), "ok");
  EXPECT_NE(host.Status().find("WPos:0.000,0.000,0.000"), std::string::npos);
}

TEST(VirtualGrbl, TheStatusHasPlaceAndLineOfExecution) {
  Host host;
  host.Ask("N7G1X5F300");
  host.Run(0.3);
  const std::string status = host.Status();
  EXPECT_NE(status.find("<Run|WPos:1."), std::string::npos) << status;
  EXPECT_NE(status.find("|Ln:7"), std::string::npos) << status;
  EXPECT_NE(status.find("|Bf:14,128"), std::string::npos) << status;
}

TEST(VirtualGrbl, RealtimeCommandsAreNeverQueued) {
  Host host;
  host.Ask("G91G1F60");
  for (int i = 0; i < 20; ++i) host.grbl.Write("X1\n");
  host.Run(0.2);
  EXPECT_NE(host.Status().find("<Run"), std::string::npos) << "with a full planner";
  host.grbl.Write("!");
  host.Run(0.1);
  EXPECT_NE(host.Status().find("<Hold:0"), std::string::npos);
}

TEST(VirtualGrbl, WithHomingItIsLockedFromPowerUpUntilHOrX) {
  VirtualGrblOptions options;
  options.homing = true;
  Host host(options);
  EXPECT_EQ(host.Ask("G1X1F600"), "error:9");
  EXPECT_EQ(host.Ask("$H"), "ok");
  EXPECT_EQ(host.Ask("G1X1F600"), "ok");
}

TEST(VirtualGrbl, WhileItHomesItIsMuteAndAResetOrTheDoorEndsItWithAnAlarm) {
  VirtualGrblOptions options;
  options.homing = true;
  options.home_steps = {-5000, 0, 0};  // 20 mm away: 0.8 s
  Host host(options);
  host.grbl.Write("$H\n");
  host.Run(0.3);
  host.read.clear();
  host.grbl.Write("?");
  host.Run(0.2);
  EXPECT_EQ(host.read, "");
  host.grbl.Write("\x18");
  host.Run(0.1);
  EXPECT_NE(host.read.find("ALARM:6"), std::string::npos);
  EXPECT_EQ(host.Ask("G1X1F600"), "error:9");
  host.grbl.Write("$H\n");
  host.Run(0.2);
  host.grbl.SetDoor(true);
  host.Run(0.1);
  EXPECT_NE(host.read.find("ALARM:7"), std::string::npos);
  host.grbl.SetDoor(false);
  EXPECT_EQ(host.Ask("$H"), "ok");
  EXPECT_EQ(host.grbl.motion().at(), Steps{});
  EXPECT_EQ(host.grbl.TrueSteps(), options.home_steps);
}

// An oracle apart from the planner: v^2 = 2 a s up to the speed, and the area below it.
TEST(VirtualGrbl, ABlockTakesTheTimeOfItsTrapezoid) {
  Host host;
  host.Ask("G1X20F1800");  // 30 mm/s, 1000 mm/s^2: 30 ms each ramp
  const double begin = host.grbl.motion().now_us();
  host.UntilIdle();
  EXPECT_NEAR(host.grbl.motion().now_us() - begin, 20.0 / 30 * 1e6 + 30e3, 3e3);
  EXPECT_EQ(host.grbl.motion().steps_made(), 5000U);
}

}  // namespace
}  // namespace intaglio::grbl
