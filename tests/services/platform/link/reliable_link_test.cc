#include "services/platform/link/reliable_link.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <numeric>
#include <random>

#include "tests/services/platform/link/faulty_line.h"

namespace intaglio::link {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

class Line : public ::testing::Test {
 protected:
  Line() { Connect(); }

  void Connect() {
    to_device = std::make_shared<FaultyPipe>();
    to_host = std::make_shared<FaultyPipe>();
    NewHost();
    const SteadyClock clock = [this] { return now; };
    device = std::make_unique<ReliableLink>(
        Side::kDevice, std::make_unique<FaultyEnd>(to_device, to_host, random, clock),
        clock, options);
  }
  void NewHost() {
    const SteadyClock clock = [this] { return now; };
    host = std::make_unique<ReliableLink>(
        Side::kHost, std::make_unique<FaultyEnd>(to_host, to_device, random, clock),
        clock);
  }

  /// Messages are numbers; each side remembers what it got.
  static ReliableLink::Handler Keep(std::vector<std::uint32_t>& got) {
    return [&got](std::uint8_t type, std::span<const std::byte> payload) {
      EXPECT_EQ(type, 0x55);
      std::uint32_t number = 0;
      ASSERT_EQ(payload.size(), sizeof number);
      std::memcpy(&number, payload.data(), sizeof number);
      got.push_back(number);
    };
  }
  static Status Send(ReliableLink& link, std::uint32_t number) {
    return link.Send(0x55, std::as_bytes(std::span(&number, 1)));
  }
  void Turn() {
    now += milliseconds(1);
    EXPECT_TRUE(host->Poll(Keep(host_got)).has_value());
    EXPECT_TRUE(device->Poll(Keep(device_got)).has_value());
  }
  bool BothUp() const { return host->up() && device->up(); }
  void Open() {
    for (int i = 0; i < 2000 && !BothUp(); ++i) Turn();
    ASSERT_TRUE(BothUp());
  }
  void Spoil(double drop, double damage, double doubling) {
    for (const auto& pipe : {to_device, to_host}) {
      pipe->drop_ratio = drop;
      pipe->damage_ratio = damage;
      pipe->double_ratio = doubling;
    }
  }

  /// Sends numbers both ways as fast as the line takes them, until all have arrived.
  void Exchange(std::uint32_t count) {
    host_got.clear();
    device_got.clear();
    std::uint32_t to_device_count = 0, to_host_count = 0;
    const std::uint32_t session = host->session();
    for (int turn = 0; turn < 200000; ++turn) {
      // A session that broke would lose what was on its way: here none may.
      ASSERT_EQ(host->session(), session);
      while (to_device_count < count && host->CanSend()) {
        ASSERT_TRUE(Send(*host, to_device_count++));
      }
      while (to_host_count < count && device->CanSend()) {
        ASSERT_TRUE(Send(*device, to_host_count++));
      }
      Turn();
      if (device_got.size() >= count && host_got.size() >= count) break;
    }
    std::vector<std::uint32_t> all(count);
    std::iota(all.begin(), all.end(), 0u);
    ASSERT_EQ(device_got, all);
    ASSERT_EQ(host_got, all);
  }

  nanoseconds now{0};
  LinkOptions options;  // of the device
  std::shared_ptr<std::mt19937_64> random = std::make_shared<std::mt19937_64>(1);
  std::shared_ptr<FaultyPipe> to_device, to_host;
  std::unique_ptr<ReliableLink> host, device;
  std::vector<std::uint32_t> host_got, device_got;
};

TEST_F(Line, NothingCanBeSentBeforeTheHandshake) {
  EXPECT_FALSE(host->CanSend());
  EXPECT_FALSE(device->CanSend());
  EXPECT_EQ(Send(*host, 1).error().code, ErrorCode::kRefused);
}

// Bytes suffer at a ratio at which every fourth frame of this length is hit.
TEST_F(Line, DeliversEverythingOnceAndInOrderOverABadLine) {
  for (const auto& [drop, damage, doubling] : {std::tuple{0.0, 0.0, 0.0},
                                               {0.01, 0.0, 0.0},
                                               {0.0, 0.01, 0.0},
                                               {0.005, 0.005, 0.01}}) {
    Connect();
    Spoil(drop, damage, doubling);
    Open();
    Exchange(2000);
  }
}

TEST_F(Line, DeliversEverythingOnceAndInOrderOverALateLine) {
  for (const int delay_ms : {1, 20, 60}) {
    Connect();
    for (const auto& pipe : {to_device, to_host}) {
      pipe->delay = milliseconds(delay_ms);
      pipe->jitter = milliseconds(15);
      pipe->drop_ratio = pipe->damage_ratio = 0.0005;
    }
    Open();
    Exchange(500);
  }
}

TEST_F(Line, SilenceOf250MillisecondsIsDownAndAFrameIsUpAgain) {
  Open();
  for (int i = 0; i < 2000; ++i) Turn();
  EXPECT_TRUE(BothUp()) << "keep-alives hold an idle line up";
  to_device->cut = true;
  const nanoseconds cut_at = now;
  while (device->up() && now - cut_at < milliseconds(1000)) Turn();
  EXPECT_LE(now - cut_at, milliseconds(251));
  EXPECT_GE(now - cut_at, milliseconds(199));  // the last frame was at most 50 ms old
  EXPECT_FALSE(device->CanSend());
  EXPECT_GT(device->silence(), milliseconds(250));
  EXPECT_TRUE(host->up()) << "the other direction is whole";
  to_device->cut = false;
  Open();
}

// A process that was stopped for a minute, and what it had sent before is lost, too.
TEST_F(Line, OfADeviceThatWaitsIsNotLostBySilence) {
  options.waits = true;
  Connect();
  Open();
  const std::uint32_t session = host->session();
  for (const auto& silent : {std::vector{to_device}, {to_host}, {to_device, to_host}}) {
    for (const auto& pipe : silent) pipe->cut = true;
    ASSERT_TRUE(Send(*host, 1) && Send(*device, 2));
    for (int i = 0; i < 60'000; ++i) {
      Turn();
      ASSERT_TRUE(BothUp()) << i;
    }
    for (const auto& pipe : silent) pipe->cut = false;
    for (int i = 0; i < 100; ++i) Turn();
    EXPECT_EQ(device_got, std::vector<std::uint32_t>{1});
    EXPECT_EQ(host_got, std::vector<std::uint32_t>{2});
    Exchange(500);
    device_got.clear();
    host_got.clear();
  }
  EXPECT_EQ(host->session(), session);
}

TEST_F(Line, KeepsToTheWindowAndReportsIt) {
  Open();
  to_device->cut = true;
  std::uint32_t sent = 0;
  while (host->CanSend() && sent < 5000) ASSERT_TRUE(Send(*host, sent++));
  EXPECT_EQ(sent, LinkOptions().window_frames);
  EXPECT_EQ(Send(*host, sent).error().code, ErrorCode::kRefused);
}

TEST_F(Line, ANewHostGetsANewSessionAndNothingOfTheOldOne) {
  Open();
  const std::uint32_t before = device->session();
  for (std::uint32_t i = 0; i < 20; ++i) ASSERT_TRUE(Send(*host, i));
  // The host dies with frames in its line; another one takes it over.
  EXPECT_TRUE(host->Poll(Keep(host_got)).has_value());
  NewHost();
  Open();
  EXPECT_NE(device->session(), before);
  device_got.clear();
  for (std::uint32_t i = 100; i < 110; ++i) ASSERT_TRUE(Send(*host, i));
  for (int i = 0; i < 200; ++i) Turn();
  ASSERT_EQ(device_got.size(), 10u);
  EXPECT_EQ(device_got.front(), 100u);
}

/// A device that sends exactly what the test lets it send, and keeps what it receives.
class ScriptedDevice {
 public:
  ScriptedDevice(std::unique_ptr<ByteStream> stream) : stream_(std::move(stream)) {}

  void Send(std::uint8_t type, std::uint16_t acknowledged, std::uint16_t credit) {
    std::vector<std::byte> bytes;
    AppendFrame({type, session ^ session_error, 0, acknowledged, credit}, {}, bytes);
    EXPECT_EQ(stream_->Write(bytes), bytes.size());
  }
  /// Highest sequence number among the frames that came since the last call; 0: none.
  std::uint16_t Receive() {
    std::uint16_t highest = 0;
    std::array<std::byte, 4096> buffer;
    for (auto got = stream_->Read(buffer); got && *got > 0; got = stream_->Read(buffer)) {
      parser_.Feed(std::span(buffer).first(*got), [&](const FrameHeader& header, auto) {
        session = header.session;
        highest = std::max(highest, header.sequence);
      });
    }
    return highest;
  }
  std::uint32_t session = 0;
  std::uint32_t session_error = 0;

 private:
  std::unique_ptr<ByteStream> stream_;
  FrameParser parser_;
};

constexpr std::uint8_t kOpened = 0x02, kKeepAlive = 0x03, kNack = 0x04;

class ScriptedLine : public Line {
 protected:
  ScriptedLine()
      : peer(std::make_unique<FaultyEnd>(to_device, to_host, random,
                                         [this] { return now; })) {
    HostTurn();
    peer.Receive();
    peer.Send(kOpened, 1, 256);
    HostTurn();
  }
  void HostTurn() {
    now += milliseconds(1);
    EXPECT_TRUE(host->Poll(Keep(host_got)));
  }
  /// The peer repeats one thing for a while; what the host sent meanwhile, at most.
  std::uint16_t HighestWhileReceiving(std::uint16_t acknowledged, std::uint16_t credit) {
    std::uint16_t highest = 0;
    for (int i = 0; i < 200; ++i) {
      if (i % 20 == 0) peer.Send(kKeepAlive, acknowledged, credit);
      HostTurn();
      highest = std::max(highest, peer.Receive());
    }
    return highest;
  }
  ScriptedDevice peer;
};

TEST_F(ScriptedLine, NeverSendsMoreThanThePeersCredit) {
  peer.Send(kKeepAlive, 1, 3);
  HostTurn();
  for (std::uint32_t i = 0; host->CanSend(); ++i) ASSERT_TRUE(Send(*host, i));
  EXPECT_EQ(HighestWhileReceiving(1, 3), 3) << "frames 1, 2, 3, however often";
  EXPECT_EQ(HighestWhileReceiving(3, 5), 7) << "1 and 2 are taken: 3 to 7";
  EXPECT_EQ(HighestWhileReceiving(8, 0), 0);
  EXPECT_EQ(HighestWhileReceiving(8, 256), 32);
}

TEST_F(ScriptedLine, BelievesNoAcknowledgementOfWhatItNeverSent) {
  for (std::uint32_t i = 0; i < 5; ++i) ASSERT_TRUE(Send(*host, i));
  EXPECT_EQ(HighestWhileReceiving(4000, 256), 5);
  EXPECT_EQ(HighestWhileReceiving(7, 256), 5) << "6 would be all of them";
  EXPECT_EQ(HighestWhileReceiving(6, 256), 0);
}

TEST_F(ScriptedLine, ANackBringsTheFrameAtOnce) {
  for (std::uint32_t i = 0; i < 5; ++i) ASSERT_TRUE(Send(*host, i));
  HostTurn();
  EXPECT_EQ(peer.Receive(), 5);
  peer.Send(kNack, 3, 256);
  HostTurn();
  EXPECT_EQ(peer.Receive(), 5);
  EXPECT_EQ(host->counters().resent_frames, 3u);
}

TEST_F(ScriptedLine, FramesOfAnotherSessionAreNotReceived) {
  ASSERT_TRUE(Send(*host, 1));
  peer.session_error = 1;
  EXPECT_EQ(HighestWhileReceiving(2, 256), 1);
  now += milliseconds(60);
  EXPECT_FALSE(host->up()) << "nor do they count as a sign of life";
}

TEST_F(Line, SequenceNumbersGoRound) {
  Open();
  std::uint32_t sent = 0;
  while (device_got.size() < 70000) {
    while (sent < 70000 && host->CanSend()) ASSERT_TRUE(Send(*host, sent++));
    Turn();
    ASSERT_LT(now, std::chrono::seconds(600));
  }
  for (std::uint32_t i = 0; i < 70000; ++i) ASSERT_EQ(device_got[i], i);
}

// 115200 baud carry 11520 bytes a second. A window of long frames is 3 s of that, a
// hundred times the resend timer: it must not make the line send everything twice.
TEST_F(Line, ASlowLineIsNotFilledWithRepetitions) {
  for (const auto& pipe : {to_device, to_host}) pipe->bytes_per_s = 11520;
  Open();
  constexpr int kCount = 100;
  const std::vector<std::byte> long_payload(1000);
  int sent = 0, got = 0;
  const nanoseconds begin = now;
  while (got < kCount && now - begin < std::chrono::seconds(60)) {
    while (sent < kCount && host->CanSend()) {
      ASSERT_TRUE(host->Send(0x55, long_payload));
      ++sent;
    }
    now += milliseconds(1);
    ASSERT_TRUE(host->Poll(Keep(host_got)));
    ASSERT_TRUE(device->Poll([&](auto, auto) { ++got; }));
  }
  EXPECT_EQ(got, kCount);
  // 100 frames of 1020 bytes take 8.9 s.
  EXPECT_LT(std::chrono::duration<double>(now - begin).count(), 10.0);
}

TEST_F(Line, AStuckLineDoesNotPileUpWhatIsReportedOnIt) {
  to_device->stuck = true;
  for (int i = 0; i < 600000; ++i) {
    now += milliseconds(1);
    ASSERT_TRUE(host->Poll(Keep(host_got)));
  }
  to_device->stuck = false;
  ASSERT_TRUE(host->Poll(Keep(host_got)));
  EXPECT_LE(to_device->taken_count, 2 * kFrameOverhead);
  Open();
}

}  // namespace
}  // namespace intaglio::link
