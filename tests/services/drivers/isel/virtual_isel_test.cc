// The facts of isel's controllers that the virtual one keeps.

#include "tests/services/drivers/isel/virtual_isel.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace intaglio::isel {
namespace {

constexpr double kMs = 1000;

class Isel : public ::testing::Test {
 protected:
  /// The answer to a command within the time; what came of it.
  std::string Send(const std::string& command, double limit_us = 60'000'000) {
    isel.Write(command + "\r");
    std::string answer;
    for (double us = 0; us < limit_us && answer.empty(); us += kMs) {
      isel.Advance(kMs);
      answer += isel.Read();
    }
    isel.Advance(20 * kMs);
    return answer + isel.Read();
  }
  void Home() {
    ASSERT_EQ(Send("@07"), "0");
    ASSERT_EQ(Send("@0R7"), "0");
  }

  VirtualIsel isel;
};

TEST_F(Isel, AnswersOneCharacterWithoutALineEnd) {
  EXPECT_EQ(Send("@07"), "0");
  EXPECT_EQ(Send("@0R7"), "0");
  EXPECT_EQ(Send("@0n7"), "0");
  EXPECT_EQ(Send("@0J75"), "0");
  EXPECT_EQ(Send("@0j300"), "0");
}

// 4 bytes and the answer take 10 bits each.
TEST_F(Isel, TakesAByteInTenBitsOfItsBaudRate) {
  isel.Write("@07\r");
  isel.Advance(5 * 10e6 / 19200);
  EXPECT_EQ(isel.Read(), "");
  isel.Advance(2 * kMs);
  EXPECT_EQ(isel.Read(), "0");
}

TEST_F(Isel, AnswersAMoveWhenItHasEnded) {
  Home();
  isel.Write("@0M4000,2000,0,2000,0,2000,0,21\r");  // 2 s
  isel.Advance(1900 * kMs);
  EXPECT_TRUE(isel.moves());
  EXPECT_EQ(isel.Read(), "");
  isel.Advance(200 * kMs);
  EXPECT_EQ(isel.Read(), "0");
  EXPECT_EQ(isel.place(), (Steps{4000, 0, 0}));
}

TEST_F(Isel, MovesToPlacesAndByWays) {
  Home();
  EXPECT_EQ(Send("@0M1000,5000,2000,5000,300,5000,0,21"), "0");
  EXPECT_EQ(Send("@0A-400,5000,0,5000,50,5000,0,21"), "0");
  EXPECT_EQ(isel.place(), (Steps{600, 2000, 350}));
}

TEST_F(Isel, ReportsItsPlaceInTwentyFourBitTwosComplement) {
  Home();
  EXPECT_EQ(Send("@0M256,5000,4096,5000,0,5000,0,21"), "0");
  EXPECT_EQ(Send("@0P"), "0000100001000000000");
  EXPECT_EQ(Send("@0n7"), "0");
  EXPECT_EQ(Send("@0P"), "0000000000000000000");
  EXPECT_EQ(Send("@0A-1,5000,-256,5000,0,5000,0,21"), "0");
  EXPECT_EQ(Send("@0P"), "0FFFFFFFFFF00000000");
  EXPECT_EQ(Send("@08"), "0");
  EXPECT_EQ(Send("@0P"), "0FFFFFFFFFF00000000000000") << "of four axes";
}

TEST_F(Isel, SwitchesItsOutputOnceForEachCommand) {
  Home();
  EXPECT_EQ(Send("@0M500,5000,0,5000,0,5000,0,21"), "0");
  isel.Write("@0B1,1\r@0B1,0\r");
  isel.Advance(30 * kMs);
  EXPECT_EQ(isel.Read(), "00");
  ASSERT_EQ(isel.flashes().size(), 1u);
  const Flash& flash = isel.flashes()[0];
  EXPECT_EQ(flash.place, (Steps{500, 0, 0}));
  EXPECT_FALSE(flash.moved);
  EXPECT_NEAR(flash.off_us - flash.on_us, 7 * 10e6 / 19200, 200) << "7 bytes";
}

// It has no watchdog: what was switched on stays on.
TEST_F(Isel, KeepsItsOutputWithoutAHost) {
  Home();
  EXPECT_EQ(Send("@0B1,1"), "0");
  isel.Advance(60'000 * kMs);
  EXPECT_TRUE(isel.output());
}

TEST_F(Isel, NamesErrorsByACharacter) {
  EXPECT_EQ(Send("@0P"), "9") << "not initialized";
  EXPECT_EQ(Send("@07"), "0");
  EXPECT_EQ(Send("@0M0,500,0,500,0,500,0,21"), "R") << "not referenced";
  Home();
  EXPECT_EQ(Send("@0X"), "5");
  EXPECT_EQ(Send("hello"), "5");
  EXPECT_EQ(Send("@0M1,x,0,500,0,500,0,21"), "5");
  EXPECT_EQ(Send("@0M1,500"), "7");
  EXPECT_EQ(Send("@0M1,5,0,500,0,500,0,21"), "D");
  EXPECT_EQ(Send("@0M1,50000,0,500,0,500,0,21"), "D");
  EXPECT_EQ(Send("@0M-10,500,0,500,0,500,0,21"), "2");
  EXPECT_EQ(Send("@0M10,500,0,500,0,500,0,21"), "R") << "after a limit";
}

TEST_F(Isel, StopsAtOnceAtTheByteAndAtItsKey) {
  for (const bool by_byte : {true, false}) {
    Home();
    isel.Write("@0M40000,2000,0,2000,0,2000,0,21\r");
    isel.Advance(500 * kMs);
    by_byte ? isel.Write(std::string(1, static_cast<char>(253))) : isel.PressStop();
    isel.Advance(5 * kMs);
    EXPECT_FALSE(isel.moves());
    EXPECT_EQ(isel.Read(), "F");
    const Steps stopped = isel.place();
    isel.Advance(500 * kMs);
    EXPECT_EQ(isel.place(), stopped);
    EXPECT_EQ(Send("@0M0,5000,0,5000,0,5000,0,21"), "0") << "it is still referenced";
  }
}

TEST_F(Isel, StopsAndRefusesWithItsCoverOpen) {
  Home();
  isel.Write("@0M40000,2000,0,2000,0,2000,0,21\r");
  isel.Advance(500 * kMs);
  isel.SetCover(true);
  isel.Advance(5 * kMs);
  EXPECT_EQ(isel.Read(), "H");
  EXPECT_EQ(Send("@0M0,5000,0,5000,0,5000,0,21"), "H");
  EXPECT_EQ(Send("@0B1,1"), "H");
  EXPECT_FALSE(isel.output());
  EXPECT_EQ(Send("@0B1,0"), "0");
  isel.SetCover(false);
  EXPECT_EQ(Send("@0M0,5000,0,5000,0,5000,0,21"), "0");
}

TEST_F(Isel, ForgetsItsReferenceWithAResetOrItsPower) {
  for (const bool by_byte : {true, false}) {
    Home();
    by_byte ? isel.Write(std::string(1, static_cast<char>(254))) : isel.PowerCycle();
    isel.Advance(5 * kMs);
    EXPECT_EQ(Send("@0P"), "9");
    EXPECT_EQ(Send("@07"), "0");
    EXPECT_EQ(Send("@0A1,500,0,500,0,500,0,21"), "R");
  }
}

}  // namespace
}  // namespace intaglio::isel
