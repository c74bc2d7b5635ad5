#include "services/virtual_engraver/lines/late_line.h"

#include <gtest/gtest.h>

#include "tests/services/virtual_engraver/machine_bench.h"

namespace intaglio::virtual_engraver {
namespace {

using namespace std::chrono_literals;

class LateLineTest : public ::testing::Test {
 protected:
  /// Passes `count` numbered bytes, one every 0.1 ms; when each of them came out.
  template <typename Send, typename Receive>
  std::vector<std::chrono::nanoseconds> Pass(int count, Send send, Receive receive) {
    std::vector<std::chrono::nanoseconds> came;
    for (int step = 0; step < 100 * count; ++step) {
      if (step % 10 == 0 && step / 10 < count) {
        send(static_cast<std::byte>(step / 10));
        sent_.push_back(now_);
      }
      while (const auto byte = receive()) {
        EXPECT_EQ(static_cast<std::size_t>(*byte), came.size() % 256) << "in order";
        came.push_back(now_);
      }
      now_ += 10us;
    }
    return came;
  }
  std::optional<std::byte> ReadOne(link::ByteStream& line) {
    std::byte byte{};
    return *line.Read({&byte, 1}) == 1 ? std::optional(byte) : std::nullopt;
  }
  void ExpectLateAndInOrder(const std::vector<std::chrono::nanoseconds>& came) {
    ASSERT_EQ(came.size(), sent_.size());
    auto latest = 0ns;
    for (std::size_t i = 0; i < came.size(); ++i) {
      EXPECT_GE(came[i], sent_[i]);
      EXPECT_LE(came[i] - sent_[i], 2010us);
      latest = std::max(latest, came[i] - sent_[i]);
    }
    EXPECT_GT(latest, 1ms);
  }

  std::chrono::nanoseconds now_ = 5s;
  std::vector<std::chrono::nanoseconds> sent_;
  std::shared_ptr<BenchLine::Wire> to_machine_ = std::make_shared<BenchLine::Wire>();
  std::shared_ptr<BenchLine::Wire> to_host_ = std::make_shared<BenchLine::Wire>();
  LateLine line_{std::make_unique<BenchLine>(to_machine_, to_host_), 2ms, 1,
                 [this] { return now_; }};
};

TEST_F(LateLineTest, DeliversLateAndInOrderWhatComesIn) {
  ExpectLateAndInOrder(Pass(
      200, [this](std::byte byte) { to_machine_->bytes.push_back(byte); },
      [this] { return ReadOne(line_); }));
}

TEST_F(LateLineTest, DeliversLateAndInOrderWhatGoesOut) {
  ExpectLateAndInOrder(Pass(
      200,
      [this](std::byte byte) {
        EXPECT_EQ(*line_.Write({&byte, 1}), 1u);
      },
      [this]() -> std::optional<std::byte> {
        (void)ReadOne(line_);  // which moves what is due both ways
        if (to_host_->bytes.empty()) return std::nullopt;
        const std::byte byte = to_host_->bytes.front();
        to_host_->bytes.pop_front();
        return byte;
      }));
}

TEST_F(LateLineTest, TakesNoMoreThanABufferHolds) {
  const std::vector<std::byte> much(70000);
  EXPECT_EQ(*line_.Write(much), much.size());
  EXPECT_EQ(*line_.Write(much), 0u);
  now_ += 3ms;
  (void)ReadOne(line_);
  EXPECT_EQ(to_host_->bytes.size(), much.size());
  EXPECT_EQ(*line_.Write(much), much.size());
}

}  // namespace
}  // namespace intaglio::virtual_engraver
