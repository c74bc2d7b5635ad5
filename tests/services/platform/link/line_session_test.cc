#include "services/platform/link/line_session.h"

#include <gtest/gtest.h>

#include "tests/services/platform/link/faulty_line.h"

namespace intaglio::link {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// A device on a line that can be pulled out and plugged in, and its host's session.
class DeviceAndSession : public ::testing::Test {
 protected:
  DeviceAndSession() : session([this] { return Open(); }, [this] { return now; }) {}

  Result<std::unique_ptr<ByteStream>> Open() {
    open_times.push_back(now);
    if (!plugged) return Fail(ErrorCode::kIo, "no such device");
    return std::unique_ptr<ByteStream>(
        std::make_unique<FaultyEnd>(to_host, to_device, random, [this] { return now; }));
  }
  void PlugIn() {
    to_device = std::make_shared<FaultyPipe>();
    to_host = std::make_shared<FaultyPipe>();
    plugged = true;
    PowerUp();
  }
  void PullOut() {
    plugged = false;
    device.reset();
    to_device->gone = to_host->gone = true;
  }
  /// The device forgets everything, as after a power failure.
  void PowerUp() {
    device = std::make_unique<ReliableLink>(
        Side::kDevice,
        std::make_unique<FaultyEnd>(to_device, to_host, random, [this] { return now; }),
        [this] { return now; }, LinkOptions{}, epoch);
    *epoch = {};
    ++power_up;
    reported_session = 0;
  }
  void Turn() {
    now += milliseconds(1);
    session.Poll([this](std::uint8_t type, std::span<const std::byte>) {
      received.push_back(type);
    });
    if (!device) return;
    EXPECT_TRUE(device->Poll([](auto, auto) {}));
    // As both controllers do: who they are, once after every handshake.
    if (device->up() && device->session() != reported_session) {
      reported_session = device->session();
      EXPECT_TRUE(device->Send(power_up, {}));
    }
  }
  void TurnFor(milliseconds time) {
    for (const nanoseconds end = now + time; now < end;) Turn();
  }

  nanoseconds now{0};
  std::shared_ptr<std::mt19937_64> random = std::make_shared<std::mt19937_64>(1);
  std::shared_ptr<FaultyPipe> to_device, to_host;
  bool plugged = false;
  std::shared_ptr<LineEpoch> epoch = std::make_shared<LineEpoch>();
  std::unique_ptr<ReliableLink> device;
  std::uint32_t reported_session = 0;
  std::uint8_t power_up = 0x40;  ///< the type of the device's message after a handshake
  std::vector<nanoseconds> open_times;
  std::vector<std::uint8_t> received;
  LineSession session;
};

TEST_F(DeviceAndSession, AnAbsentDeviceIsTriedTwiceASecondAndNamed) {
  EXPECT_FALSE(session.message().empty());
  TurnFor(milliseconds(2600));
  EXPECT_FALSE(session.up());
  EXPECT_FALSE(session.CanSend());
  EXPECT_EQ(session.fd(), -1);
  EXPECT_EQ(session.message(), "no such device");
  const auto refused = session.Send(0x10);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kLinkLost);
  EXPECT_EQ(refused.error().message, "no such device");
  ASSERT_EQ(open_times.size(), 6u);
  for (std::size_t i = 1; i < open_times.size(); ++i) {
    EXPECT_EQ(open_times[i] - open_times[i - 1], milliseconds(500));
  }
}

TEST_F(DeviceAndSession, OpensAndIsOpened) {
  PlugIn();
  TurnFor(milliseconds(10));
  EXPECT_TRUE(session.up());
  EXPECT_TRUE(session.CanSend());
  EXPECT_EQ(session.sessions(), 1u);
  EXPECT_EQ(session.message(), "");
  EXPECT_EQ(received, std::vector<std::uint8_t>{0x41});
  TurnFor(milliseconds(5000));
  EXPECT_EQ(session.sessions(), 1u) << "an idle line stays what it is";
  EXPECT_EQ(open_times.size(), 1u);
}

TEST_F(DeviceAndSession, ADeviceThatIsSilentFromTheStartIsReportedToBe) {
  PlugIn();
  to_host->cut = true;
  TurnFor(milliseconds(2000));
  EXPECT_FALSE(session.up());
  EXPECT_EQ(
      session.message(),
      "the device does not answer: check that it is switched on and uses version 13 "
      "of the frames");
  to_host->cut = false;
  TurnFor(milliseconds(50));
  EXPECT_TRUE(session.up());
}

// Without another handshake the host would count on what the device has forgotten.
TEST_F(DeviceAndSession, ANewPowerUpIsANewSessionOnTheSameLine) {
  PlugIn();
  TurnFor(milliseconds(100));
  PowerUp();
  TurnFor(milliseconds(1000));
  EXPECT_TRUE(session.up());
  EXPECT_EQ(session.sessions(), 2u);
  EXPECT_EQ(open_times.size(), 1u);
  EXPECT_EQ(received, (std::vector<std::uint8_t>{0x41, 0x42}));
}

TEST_F(DeviceAndSession, SilenceIsNoticedAndEndsWithANewSession) {
  PlugIn();
  TurnFor(milliseconds(100));
  to_host->cut = true;
  TurnFor(milliseconds(199));
  EXPECT_TRUE(session.up()) << "the last word is at most 50 ms old";
  TurnFor(milliseconds(53));
  EXPECT_FALSE(session.up());
  EXPECT_EQ(session.message(), "the device no longer sends");
  EXPECT_FALSE(session.Send(0x10));
  to_host->cut = false;
  TurnFor(milliseconds(100));
  EXPECT_TRUE(session.up());
  EXPECT_EQ(session.message(), "");
  EXPECT_EQ(session.sessions(), 2u);
  EXPECT_EQ(received, (std::vector<std::uint8_t>{0x41, 0x41}));
}

TEST_F(DeviceAndSession, ALineThatWasPulledOutIsOpenedAgain) {
  PlugIn();
  TurnFor(milliseconds(700));
  PullOut();
  Turn();
  EXPECT_FALSE(session.up());
  EXPECT_EQ(session.fd(), -1);
  EXPECT_EQ(session.message(), "the test's line is gone");
  TurnFor(milliseconds(1000));
  EXPECT_EQ(session.message(), "no such device");
  PlugIn();
  TurnFor(milliseconds(600));
  EXPECT_TRUE(session.up());
  EXPECT_EQ(session.sessions(), 2u);
  EXPECT_EQ(received, (std::vector<std::uint8_t>{0x41, 0x42}));
}

// Another host has the device by then: this process sends nothing to it any more.
TEST_F(DeviceAndSession, WhoIsFencedOffReportsItAndOpensNothing) {
  PlugIn();
  TurnFor(milliseconds(100));
  ASSERT_TRUE(session.up());
  EXPECT_FALSE(session.fenced());
  epoch->number += 1u << 30;
  to_host->cut = true;
  TurnFor(milliseconds(300));
  to_host->cut = false;
  TurnFor(milliseconds(300));
  EXPECT_TRUE(session.fenced());
  EXPECT_FALSE(session.up());
  EXPECT_EQ(session.message(), "another host has taken over this machine");
  EXPECT_EQ(session.fd(), -1) << "the port is closed for whoever has it now";
  const std::size_t opened = open_times.size();
  TurnFor(milliseconds(2000));
  EXPECT_EQ(open_times.size(), opened);
  EXPECT_FALSE(session.Send(0x10));
}

}  // namespace
}  // namespace intaglio::link
