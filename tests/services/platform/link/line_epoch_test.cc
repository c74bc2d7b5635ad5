// Several hosts on one line, as two processes on one serial port or a splitter: the
// newest host has the device, and no other host sends anything to it.

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "services/platform/link/byte_codec.h"
#include "services/platform/link/reliable_link.h"
#include "tests/services/platform/link/faulty_line.h"

namespace intaglio::link {
namespace {

using std::chrono::milliseconds;

constexpr std::uint8_t kConsent = 0x55;

/// Bytes that the device sends go to every host.
class Splitter : public ByteStream {
 public:
  explicit Splitter(std::vector<std::unique_ptr<FaultyEnd>> branches)
      : branches_(std::move(branches)) {}
  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    return branches_.front()->Read(buffer);
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    for (const auto& branch : branches_) (void)branch->Write(bytes);
    return bytes.size();
  }
  int fd() const override { return -1; }

 private:
  std::vector<std::unique_ptr<FaultyEnd>> branches_;
};

class TwoHosts : public ::testing::Test {
 protected:
  struct Host {
    std::shared_ptr<FaultyPipe> from_device = std::make_shared<FaultyPipe>();
    std::shared_ptr<FaultyPipe> to_device;
    std::shared_ptr<LineEpoch> epoch = std::make_shared<LineEpoch>();
    std::unique_ptr<ReliableLink> link;
  };

  TwoHosts() { PowerUp(); }

  void PowerUp() {
    epoch = std::make_shared<LineEpoch>();
    PlugDevice();
  }
  void PlugDevice() {
    std::vector<std::unique_ptr<FaultyEnd>> branches;
    for (const Host& host : hosts) {
      branches.push_back(
          std::make_unique<FaultyEnd>(to_device, host.from_device, random, clock));
    }
    device = std::make_unique<ReliableLink>(
        Side::kDevice, std::make_unique<Splitter>(std::move(branches)), clock,
        LinkOptions{}, epoch);
  }
  /// The host at `host` begins, or begins anew without what it knew.
  void Start(Host& host) {
    host.epoch = std::make_shared<LineEpoch>();
    Reopen(host);
  }
  void Reopen(Host& host) {
    host.link = std::make_unique<ReliableLink>(
        Side::kHost,
        std::make_unique<FaultyEnd>(host.from_device, to_device, random, clock), clock,
        LinkOptions{}, host.epoch);
  }
  void TurnFor(milliseconds time) {
    for (int i = 0; i < time.count(); ++i) {
      now += milliseconds(1);
      for (Host& host : hosts) {
        if (!host.link) continue;
        EXPECT_TRUE(host.link->Poll([](auto, auto) {}));
      }
      EXPECT_TRUE(device->Poll([this](std::uint8_t, std::span<const std::byte> payload) {
        received.push_back(std::to_integer<int>(payload[0]));
      }));
    }
  }
  Status Send(Host& host, int word) {
    const std::array payload{std::byte(word)};
    return host.link->Send(kConsent, payload);
  }
  void Spoil(double ratio) {
    for (const auto& pipe : {to_device, hosts[0].from_device, hosts[1].from_device}) {
      pipe->drop_ratio = pipe->damage_ratio = ratio;
    }
  }

  std::chrono::nanoseconds now = std::chrono::hours(1);
  SteadyClock clock = [this] { return now; };
  std::shared_ptr<std::mt19937_64> random = std::make_shared<std::mt19937_64>(1);
  std::shared_ptr<FaultyPipe> to_device = std::make_shared<FaultyPipe>();
  std::array<Host, 2> hosts;
  std::shared_ptr<LineEpoch> epoch;  // the device's
  std::unique_ptr<ReliableLink> device;
  std::vector<int> received;
};

TEST_F(TwoHosts, TheNewerTakesTheDeviceAndTheOlderIsFencedOffForGood) {
  Start(hosts[0]);
  TurnFor(milliseconds(20));
  ASSERT_TRUE(hosts[0].link->up());
  ASSERT_TRUE(Send(hosts[0], 1));
  TurnFor(milliseconds(20));
  Start(hosts[1]);
  TurnFor(milliseconds(20));
  EXPECT_TRUE(hosts[1].link->up());
  EXPECT_GT(hosts[1].epoch->number, hosts[0].epoch->number);
  // The older one has not noticed yet: what it sends has no effect.
  ASSERT_TRUE(Send(hosts[0], 2));
  ASSERT_TRUE(Send(hosts[1], 3));
  TurnFor(milliseconds(400));
  EXPECT_EQ(received, (std::vector{1, 3}));
  EXPECT_TRUE(hosts[0].epoch->fenced);
  EXPECT_FALSE(hosts[0].link->up());
  EXPECT_FALSE(Send(hosts[0], 4));
  EXPECT_TRUE(hosts[1].link->up());
  EXPECT_FALSE(hosts[1].epoch->fenced);
  // Not a byte more of the older one, whatever becomes of the newer and of the device.
  hosts[1].link.reset();
  PowerUp();
  const std::uint64_t sent = to_device->taken_count;
  Reopen(hosts[0]);
  TurnFor(milliseconds(1000));
  EXPECT_EQ(to_device->taken_count, sent);
}

// Who asks only wants to know: the session of another goes on.
TEST_F(TwoHosts, AskingDisturbsNobody) {
  Start(hosts[0]);
  TurnFor(milliseconds(20));
  const std::uint32_t session = device->session();
  std::vector<std::byte> question;
  AppendFrame({0x01, 0xABCD, 0, 1, 1}, std::vector<std::byte>(8), question);
  FaultyEnd asker(hosts[1].from_device, to_device, random, clock);
  ASSERT_TRUE(asker.Write(question));
  TurnFor(milliseconds(500));
  EXPECT_TRUE(hosts[0].link->up());
  EXPECT_EQ(device->session(), session);
  std::array<std::byte, 97> buffer{};
  FrameParser parser;
  std::uint64_t answered = 0;
  for (auto got = asker.Read(buffer); got && *got > 0; got = asker.Read(buffer)) {
    parser.Feed(std::span(buffer).first(*got), [&](const FrameHeader& h, auto payload) {
      if (h.type != 0x05 || h.session != 0xABCD) return;
      answered = ByteReader(payload).Get<std::uint64_t>();
    });
  }
  EXPECT_EQ(answered, hosts[0].epoch->number);
}

// Both receive the same highest number.
TEST_F(TwoHosts, OfTwoThatBeginAtOnceOneStays) {
  for (int trial = 0; trial < 10; ++trial) {
    for (Host& host : hosts) Start(host);
    TurnFor(milliseconds(1000));
    EXPECT_NE(hosts[0].epoch->fenced, hosts[1].epoch->fenced);
    EXPECT_NE(hosts[0].link->up(), hosts[1].link->up());
  }
}

TEST_F(TwoHosts, OneStaysOnABadLine) {
  Spoil(0.003);
  Start(hosts[0]);
  TurnFor(milliseconds(500));
  Start(hosts[1]);
  TurnFor(milliseconds(3000));
  EXPECT_TRUE(hosts[0].epoch->fenced);
  EXPECT_FALSE(hosts[1].epoch->fenced);
  Spoil(0);
  TurnFor(milliseconds(300));
  EXPECT_TRUE(hosts[1].link->up());
}

// A device that forgot its epochs takes the host that is there again.
TEST_F(TwoHosts, APowerFailureOfTheDeviceFencesNobodyOff) {
  Start(hosts[0]);
  TurnFor(milliseconds(20));
  PowerUp();
  TurnFor(milliseconds(500));
  EXPECT_TRUE(hosts[0].link->up());
  EXPECT_EQ(epoch->number, hosts[0].epoch->number);
}

// The device keeps the number while its line is unplugged.
TEST_F(TwoHosts, WhoWasAwayWhileAnotherCameIsFencedOffWhenItIsBack) {
  Start(hosts[0]);
  TurnFor(milliseconds(20));
  hosts[0].link.reset();
  Start(hosts[1]);
  TurnFor(milliseconds(20));
  hosts[1].link.reset();
  PlugDevice();
  Reopen(hosts[0]);
  TurnFor(milliseconds(50));
  EXPECT_TRUE(hosts[0].epoch->fenced);
  EXPECT_FALSE(device->up());
}

// A frame that claims to open and does not name a host's epoch opens nothing.
TEST_F(TwoHosts, AnOpenWithoutAnEpochIsNoOpen) {
  for (const std::size_t size : {0u, 4u, 7u, 9u}) {
    std::vector<std::byte> open;
    AppendFrame({0x01, 0xABCD, 0, 1, 1}, std::vector<std::byte>(size, std::byte(1)),
                open);
    ASSERT_TRUE(FaultyEnd(hosts[1].from_device, to_device, random, clock).Write(open));
    TurnFor(milliseconds(10));
    EXPECT_FALSE(device->up());
  }
  EXPECT_EQ(epoch->number, 0u);
}

}  // namespace
}  // namespace intaglio::link
