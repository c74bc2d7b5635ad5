// A BJJCZ board on USB, behind fake_libusb.cc, in real time: a socket of this test is the
// board's end of either line, so what the driver sends over both can be compared.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <thread>
#include <vector>

#include "services/drivers/motion_drivers.h"
#include "tests/patience.h"
#include "tests/services/drivers/bjjcz/board_at_socket.h"
#include "tests/services/drivers/bjjcz/point_rig.h"
#include "tests/test_folder.h"

namespace intaglio::drivers {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using ::testing::ElementsAreArray;
using ::testing::HasSubstr;

constexpr double kUsbRate_hz = 4000;
constexpr std::size_t kUsbPoints = 150;

class UsbBoard : public ::testing::Test {
 protected:
  UsbBoard() {
    fs::remove_all(bus_);
    fs::create_directories(bus_);
    setenv("INTAGLIO_FAKE_USB", bus_.c_str(), 1);
  }
  ~UsbBoard() override {
    unsetenv("INTAGLIO_FAKE_USB");
    std::error_code ignored;
    fs::remove_all(bus_, ignored);
  }
  void Make(const std::string& device) {
    MachineSpec profile = BjjczPointProfile();
    profile.mutable_motion_line()->set_device(device);
    profile.mutable_laser()->set_warm_up_s(0);
    auto made = MakeMotionDriver(profile);
    ASSERT_TRUE(made) << made.error().message;
    driver_ = std::move(*made);
  }
  bool Until(const std::function<bool()>& condition,
             std::chrono::seconds bound = std::chrono::seconds(20)) {
    const test::Patience patience(bound);
    while (!condition()) {
      if (patience.over()) return false;
      driver_->laser()->Poll([](const link::PulseReport&) {},
                             [](const link::PastReport&) {});
      (void)driver_->TakePositions();
      std::this_thread::sleep_for(1ms);
    }
    return true;
  }
  static std::vector<Vec3> Points() {
    std::vector<Vec3> points;
    for (std::size_t i = 0; i < kUsbPoints; ++i) {
      const auto number = static_cast<double>(i);
      points.emplace_back(0.3123 * number - 20,
                          5.4567 - 0.0789 * static_cast<double>(i % 7),
                          0.066 * static_cast<double>(i / 50));
    }
    return points;
  }
  /// All of them are decided before the first is made; z moves before each 50.
  void MakePoints() {
    LaserController& laser = *driver_->laser();
    ASSERT_TRUE(Until([&] { return laser.up(); })) << laser.message();
    ASSERT_TRUE(laser.Reset() && driver_->ClearFault());
    ASSERT_TRUE(Until([&] { return driver_->state().at_rest; }));
    ASSERT_TRUE(laser.Lamp(true, kUsbRate_hz) && laser.OpenShutters(1));
    ASSERT_TRUE(Until([&] {
      return laser.Has(link::kLampWarm) && laser.status().shutters_open == 1 &&
             driver_->state().at_rest;
    })) << driver_->state().message;
    const std::uint64_t start =
        std::max(laser.status().tick, laser.status().decided_through) + 3;
    ASSERT_TRUE(driver_->BeginRun(1, start, 0)) << driver_->state().message;
    std::vector<motion::Segment> segments;
    std::vector<bool> fire(2, false);
    for (const Vec3& place : Points()) {
      const std::uint32_t ticks = segments.size() % 50 == 0 ? 200 : 2;
      segments.push_back({place, Vec3::Zero(), ticks * motion::kSubticksPerTick, true,
                          segments.size() + 1 == kUsbPoints});
      fire.resize(fire.size() + ticks);
      fire.back() = true;
    }
    ASSERT_GE(driver_->Room(), segments.size());
    ASSERT_TRUE(driver_->Append(segments, {}));
    ASSERT_TRUE(laser.Arm({start - 1, true, fire, false, 10}));
  }
  /// Commands and packets without the questions, which are asked by the clock.
  static std::vector<std::string> Messages(const std::string& bytes) {
    std::vector<std::string> all;
    for (std::size_t at = 0; at + 12 <= bytes.size();) {
      const std::size_t size = (bytes[at + 1] & 0x80) != 0 ? 3072 : 12;
      const int operation = static_cast<unsigned char>(bytes[at]);
      const bool asks = size == 12 && (operation == 0x25 || operation == 0x2A);
      if (!asks) all.push_back(bytes.substr(at, size));
      at += size;
    }
    return all;
  }

  // The path of a socket has 107 bytes at most.
  fs::path bus_ = "/tmp/usb-board-" + std::to_string(getpid());
  std::unique_ptr<MotionDriver> driver_;
};

TEST_F(UsbBoard, AllBytesAreThoseOfTheSocket) {
  std::vector<std::string> messages[2];
  for (const bool usb : {false, true}) {
    const std::string path = bus_ / "1-2.3";
    BoardAtSocket at(path, PlainBoard());
    std::ofstream(path + ".sent").flush();
    Make(usb ? "usb:9588:9899@1-2.3" : "unix:" + path);
    MakePoints();
    EXPECT_TRUE(Until([&] { return driver_->state().at_rest && driver_->Room() > 200; }))
        << driver_->state().message;
    driver_.reset();
    at.Stop();
    EXPECT_EQ(at.board().flashes().size(), kUsbPoints);
    EXPECT_EQ(at.board().unknown_count(), 0U);
    messages[usb ? 1 : 0] = Messages(at.bytes());
    // Each command and each packet is a transfer.
    std::ifstream sizes(path + ".sent");
    std::size_t packets = 0;
    for (const int size : std::vector<int>{std::istream_iterator<int>(sizes), {}}) {
      EXPECT_TRUE(size == 12 || size == 3072) << size;
      packets += size == 3072;
    }
    if (usb) {
      EXPECT_GT(packets, 1U);
    }
  }
  EXPECT_GT(messages[0].size(), 25U);
  EXPECT_THAT(messages[1], ElementsAreArray(messages[0]));
}

// lmc_client.py is written from the public descriptions alone, in another language.
TEST_F(UsbBoard, AnotherClientMakesTheSameRecordOfTheSameList) {
  std::vector<bjjcz::Flash> flashes[2];
  const std::string path = bus_ / "1-2.3";
  {
    BoardAtSocket at(path, PlainBoard());
    Make("usb:9588:9899");
    MakePoints();
    EXPECT_TRUE(Until([&] { return driver_->state().at_rest && driver_->Room() > 200; }));
    driver_.reset();
    at.Stop();
    flashes[0] = at.board().flashes();
  }
  std::ofstream points(bus_ / "points.txt");
  for (const Vec3& place : Points())
    points << place.x() << ' ' << place.y() << ' '
           << std::lround((place.z() + 51) * kBoardStepsPerMm) << '\n';
  points.close();
  {
    BoardAtSocket at(path, PlainBoard());
    const std::string command =
        "python3 " INTAGLIO_SOURCE_DIR "/tests/services/drivers/bjjcz/lmc_client.py " +
        path + " " + (bus_ / "points.txt").string() + " 110 3000 200 500 30000";
    ASSERT_EQ(std::system(command.c_str()), 0);
    at.Stop();
    EXPECT_EQ(at.board().unknown_count(), 0U);
    flashes[1] = at.board().flashes();
  }
  ASSERT_EQ(flashes[0].size(), kUsbPoints);
  ASSERT_EQ(flashes[1].size(), kUsbPoints);
  for (std::size_t i = 0; i < kUsbPoints; ++i) {
    EXPECT_NEAR(flashes[0][i].at[0], flashes[1][i].at[0], 0.5) << i;
    EXPECT_NEAR(flashes[0][i].at[1], flashes[1][i].at[1], 0.5) << i;
    EXPECT_EQ(flashes[0][i].axis, flashes[1][i].axis) << i;
    EXPECT_NEAR(flashes[0][i].lit_us, flashes[1][i].lit_us, 1) << i;
  }
}

// Two boards on the bus: the one of the profile's number is taken, the other is asked for
// its number and let go.
TEST_F(UsbBoard, TheSerialNumberChoosesAmongBoards) {
  bjjcz::VirtualBjjczOptions other = PlainBoard();
  other.serial_number = {9, 9, 9};
  BoardAtSocket first(bus_ / "1-1", other);
  BoardAtSocket second(bus_ / "1-2.3", PlainBoard());
  Make("usb:9588:9899");
  ASSERT_TRUE(Until([&] { return driver_->laser()->up(); }))
      << driver_->laser()->message();
  EXPECT_EQ(driver_->laser()->refusal(), "");
  driver_.reset();
  first.Stop();
  for (const std::string& message : Messages(first.bytes()))
    EXPECT_EQ(message[0], 0x09) << "another board was sent more than the question";
}

TEST_F(UsbBoard, AnUnpluggedBoardIsALostLineAndIsFoundAgain) {
  const std::string path = bus_ / "1-2.3";
  auto at = std::make_unique<BoardAtSocket>(path, PlainBoard());
  Make("usb:9588:9899");
  MakePoints();
  ASSERT_TRUE(Until([&] { return driver_->state().position_mm.x() > -15; }));
  at.reset();
  ASSERT_TRUE(Until([&] { return !driver_->laser()->up(); }));
  EXPECT_THAT(driver_->laser()->message(), HasSubstr("check"));
  ASSERT_TRUE(Until([&] {
    return driver_->laser()->message().find("lsusb") != std::string::npos;
  })) << driver_->laser()->message();
  at = std::make_unique<BoardAtSocket>(path, PlainBoard());
  EXPECT_TRUE(Until([&] { return driver_->laser()->up(); }))
      << driver_->laser()->message();
}

}  // namespace
}  // namespace intaglio::drivers
