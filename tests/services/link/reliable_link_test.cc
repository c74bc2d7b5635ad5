#include "services/link/reliable_link.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

namespace intaglio::link {
namespace {

using std::chrono::milliseconds;
using std::chrono::nanoseconds;

/// One direction of a line that spoils bytes as it is told.
struct Pipe {
  std::deque<std::byte> bytes;
  double drop_ratio = 0, damage_ratio = 0, double_ratio = 0;
  bool cut = false;
};

class PipeEnd : public ByteStream {
 public:
  PipeEnd(std::shared_ptr<Pipe> in, std::shared_ptr<Pipe> out,
          std::shared_ptr<std::mt19937_64> random)
      : in_(std::move(in)), out_(std::move(out)), random_(std::move(random)) {}

  Result<std::size_t> Read(std::span<std::byte> buffer) override {
    const std::size_t count =
        std::min({buffer.size(), in_->bytes.size(), std::size_t{97}});
    std::copy_n(in_->bytes.begin(), count, buffer.begin());
    in_->bytes.erase(in_->bytes.begin(),
                     in_->bytes.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }
  Result<std::size_t> Write(std::span<const std::byte> bytes) override {
    std::uniform_real_distribution<double> unit(0, 1);
    for (std::byte byte : bytes) {
      if (out_->cut || unit(*random_) < out_->drop_ratio) continue;
      if (unit(*random_) < out_->damage_ratio) byte ^= std::byte((*random_)() | 1);
      out_->bytes.push_back(byte);
      if (unit(*random_) < out_->double_ratio) out_->bytes.push_back(byte);
    }
    return bytes.size();
  }
  int fd() const override { return -1; }

 private:
  std::shared_ptr<Pipe> in_, out_;
  std::shared_ptr<std::mt19937_64> random_;
};

class Line : public ::testing::Test {
 protected:
  Line() { Connect(); }

  void Connect() {
    to_device = std::make_shared<Pipe>();
    to_host = std::make_shared<Pipe>();
    host = std::make_unique<ReliableLink>(
        Side::kHost, std::make_unique<PipeEnd>(to_host, to_device, random),
        [this] { return now; });
    device = std::make_unique<ReliableLink>(
        Side::kDevice, std::make_unique<PipeEnd>(to_device, to_host, random),
        [this] { return now; });
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
  static Status Say(ReliableLink& link, std::uint32_t number) {
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

  nanoseconds now{0};
  std::shared_ptr<std::mt19937_64> random = std::make_shared<std::mt19937_64>(1);
  std::shared_ptr<Pipe> to_device, to_host;
  std::unique_ptr<ReliableLink> host, device;
  std::vector<std::uint32_t> host_got, device_got;
};

TEST_F(Line, NothingCanBeSentBeforeTheHandshake) {
  EXPECT_FALSE(host->CanSend());
  EXPECT_FALSE(device->CanSend());
  EXPECT_EQ(Say(*host, 1).error().code, ErrorCode::kRefused);
}

// A line worse than any that is used: every second frame suffers.
TEST_F(Line, DeliversEverythingOnceAndInOrderOverABadLine) {
  for (const auto& [drop, damage, doubling] : {std::tuple{0.0, 0.0, 0.0},
                                               {0.01, 0.0, 0.0},
                                               {0.0, 0.01, 0.0},
                                               {0.005, 0.005, 0.01}}) {
    Connect();
    host_got.clear();
    device_got.clear();
    Spoil(drop, damage, doubling);
    Open();
    constexpr std::uint32_t kCount = 2000;
    std::uint32_t to_device_count = 0, to_host_count = 0;
    std::uint32_t session = host->session();
    for (int turn = 0; turn < 200000; ++turn) {
      // A session that broke would lose what was on its way: with these it does not.
      ASSERT_EQ(host->session(), session);
      while (to_device_count < kCount && host->CanSend()) {
        ASSERT_TRUE(Say(*host, to_device_count++));
      }
      while (to_host_count < kCount && device->CanSend()) {
        ASSERT_TRUE(Say(*device, to_host_count++));
      }
      Turn();
      if (device_got.size() == kCount && host_got.size() == kCount) break;
    }
    ASSERT_EQ(device_got.size(), kCount);
    ASSERT_EQ(host_got.size(), kCount);
    for (std::uint32_t i = 0; i < kCount; ++i) {
      ASSERT_EQ(device_got[i], i);
      ASSERT_EQ(host_got[i], i);
    }
  }
}

TEST_F(Line, SilenceOf250MillisecondsIsDownAndASpokenWordIsUpAgain) {
  Open();
  for (int i = 0; i < 2000; ++i) Turn();
  EXPECT_TRUE(BothUp()) << "keep-alives hold an idle line up";
  to_device->cut = true;
  const nanoseconds cut_at = now;
  while (device->up() && now - cut_at < milliseconds(1000)) Turn();
  EXPECT_LE(now - cut_at, milliseconds(251));
  EXPECT_GE(now - cut_at, milliseconds(199));  // the last word was at most 50 ms old
  EXPECT_FALSE(device->CanSend());
  to_device->cut = false;
  Open();
}

TEST_F(Line, KeepsToTheWindowAndSaysSo) {
  Open();
  to_device->cut = true;
  std::uint32_t sent = 0;
  while (host->CanSend() && sent < 5000) ASSERT_TRUE(Say(*host, sent++));
  EXPECT_LE(sent, 64u);
  EXPECT_EQ(Say(*host, sent).error().code, ErrorCode::kRefused);
}

TEST_F(Line, ANewHostGetsANewSessionAndNothingOfTheOldOne) {
  Open();
  const std::uint32_t before = device->session();
  for (std::uint32_t i = 0; i < 20; ++i) ASSERT_TRUE(Say(*host, i));
  // The host dies with frames in its line; another one takes it over.
  EXPECT_TRUE(host->Poll(Keep(host_got)).has_value());
  host = std::make_unique<ReliableLink>(
      Side::kHost, std::make_unique<PipeEnd>(to_host, to_device, random),
      [this] { return now; });
  Open();
  EXPECT_NE(device->session(), before);
  device_got.clear();
  for (std::uint32_t i = 100; i < 110; ++i) ASSERT_TRUE(Say(*host, i));
  for (int i = 0; i < 200; ++i) Turn();
  ASSERT_EQ(device_got.size(), 10u);
  EXPECT_EQ(device_got.front(), 100u);
}

TEST_F(Line, SequenceNumbersGoRound) {
  Open();
  std::uint32_t sent = 0;
  while (device_got.size() < 70000) {
    while (sent < 70000 && host->CanSend()) ASSERT_TRUE(Say(*host, sent++));
    Turn();
    ASSERT_LT(now, std::chrono::seconds(600));
  }
  for (std::uint32_t i = 0; i < 70000; ++i) ASSERT_EQ(device_got[i], i);
}

}  // namespace
}  // namespace intaglio::link
