// The facts about what a grbl does without a host, in a hold, a jog, an alarm and a door
// (virtual_grbl_test.cc has the others).

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/services/drivers/grbl/virtual_grbl_host.h"

namespace intaglio::grbl {
namespace {

using Host = VirtualHost;

TEST(VirtualGrbl, WithASilentHostItRunsItsBufferOut) {
  Host host;
  host.grbl.Write("M4S1000\nG1F600X1\nX2S0\nX3\n");
  host.Run(5);
  EXPECT_EQ(host.grbl.WorkPosition_mm().x(), 3) << "there is no watchdog";
}

TEST(VirtualGrbl, WithASilentHostM3StaysLitAndM4EndsDark) {
  for (const bool dynamic : {false, true}) {
    Host host;
    host.grbl.Write(dynamic ? "M4S1000\nG1F600X1\n" : "M3S1000\nG1F600X1\n");
    host.Run(5);
    EXPECT_EQ(host.grbl.motion().lit(), !dynamic);
    EXPECT_EQ(host.grbl.motion().lit_at_rest_us() > 4e6, !dynamic);
    EXPECT_EQ(host.grbl.motion().lit_at_rest_us() == 0, dynamic);
  }
}

TEST(VirtualGrbl, AJogWithPowerLightsAndStaysLitAfterM3) {
  for (const bool dynamic : {false, true}) {
    Host host;
    host.Ask("G1F600");
    host.Ask(dynamic ? "M4S0" : "M3S0");
    host.Ask("S1000");
    EXPECT_EQ(host.Ask("$J=G91X1F600"), "ok");
    host.Run(0.05);
    EXPECT_TRUE(host.grbl.motion().lit());
    host.UntilIdle();
    EXPECT_EQ(host.grbl.motion().lit(), !dynamic) << "gnea/grbl#136";
  }
}

TEST(VirtualGrbl, M5S0BeforeAJogKeepsItDark) {
  Host host;
  host.Ask("M4S1000");
  host.Ask("M5S0");
  host.Ask("$J=G91X1F600");
  host.UntilIdle();
  EXPECT_TRUE(host.grbl.motion().flashes().empty());
}

TEST(VirtualGrbl, HoldWithM3IsLitUntilStandstill) {
  Host host;
  host.Ask("M3S1000");
  host.Ask("G1X20F3000");
  host.Run(0.1);
  host.grbl.Write("!");
  host.Run(0.5);
  EXPECT_NE(host.Status().find("<Hold:0"), std::string::npos);
  EXPECT_FALSE(host.grbl.motion().lit());
  EXPECT_EQ(host.grbl.motion().flashes().size(), 1U);
  EXPECT_LT(host.grbl.motion().lit_at_rest_us(), 100);
}

TEST(VirtualGrbl, ResetInMotionIsDarkAtOnceAndAlarm3) {
  Host host;
  host.Ask("M3S1000");
  host.Ask("G1X20F3000");
  host.Run(0.1);
  host.read.clear();
  host.grbl.Write("\x18");
  host.Run(0.05);
  EXPECT_FALSE(host.grbl.motion().lit());
  EXPECT_FALSE(host.grbl.motion().moving());
  EXPECT_EQ(host.Count("ALARM:3"), 1);
  EXPECT_EQ(host.Count("Grbl 1.1h"), 1);
  EXPECT_EQ(host.Ask("G1X1F600"), "error:9") << "until $X";
  host.Ask("$X");
  EXPECT_EQ(host.Ask("G1X1F600"), "ok");
}

TEST(VirtualGrbl, ResetAtRestIsNoAlarmAndKeepsThePosition) {
  Host host;
  host.Ask("G1X2F600");
  host.UntilIdle();
  host.grbl.Write("G1X30");  // half a line of a host that died
  host.grbl.Write("\x18");
  host.Run(0.05);
  EXPECT_EQ(host.Count("ALARM"), 0);
  EXPECT_EQ(host.Ask("G90"), "ok");
  EXPECT_EQ(host.grbl.WorkPosition_mm().x(), 2);
}

TEST(VirtualGrbl, ALimitIsDarkAndAlarm1AndMuteUntilReset) {
  Host host;
  host.Ask("M3S1000");
  host.Ask("G1X20F3000");
  host.Run(0.1);
  host.grbl.HitLimit();
  host.Run(0.01);
  EXPECT_FALSE(host.grbl.motion().lit());
  EXPECT_EQ(host.Count("ALARM:1"), 1);
  EXPECT_EQ(host.Status(), "");
  host.grbl.Write("\x18");
  host.Run(0.05);
  EXPECT_NE(host.Status().find("<Alarm"), std::string::npos);
}

TEST(VirtualGrbl, AfterADoorResumeLightsAgain) {
  Host host;
  host.Ask("M4S1000");
  host.Ask("G1X20F1200");
  host.Run(0.1);
  host.grbl.SetDoor(true);
  host.Run(0.5);
  EXPECT_NE(host.Status().find("<Door:1"), std::string::npos);
  EXPECT_FALSE(host.grbl.motion().lit());
  host.grbl.Write("~");
  host.Run(0.1);
  EXPECT_FALSE(host.grbl.motion().moving()) << "not while it is open";
  host.grbl.SetDoor(false);
  host.Run(0.1);
  EXPECT_NE(host.Status().find("<Door:0"), std::string::npos) << "latched";
  EXPECT_FALSE(host.grbl.motion().lit());
  host.grbl.Write("~");
  host.Run(0.1);
  EXPECT_TRUE(host.grbl.motion().lit());
}

TEST(VirtualGrbl, InJogOnlyJogsAreTaken) {
  Host host;
  host.Ask("$J=G91X5F300");
  EXPECT_EQ(host.Ask("G1X1F600"), "error:9");
  EXPECT_EQ(host.Ask("$J=G91X1F300"), "ok");
}

TEST(VirtualGrbl, AJogInHoldIsNotAnswered) {
  Host host;
  host.Ask("G1X5F300");
  host.grbl.Write("!");
  host.Run(0.3);
  host.read.clear();
  host.grbl.Write("$J=G91X1F300\n");
  host.Run(1);
  EXPECT_EQ(host.read, "");
}

TEST(VirtualGrbl, AJogWithoutFeedIsError22) {
  Host host;
  EXPECT_EQ(host.Ask("$J=G91X1"), "error:22");
  EXPECT_EQ(host.Ask("G1X1"), "error:22");
}

}  // namespace
}  // namespace intaglio::grbl
