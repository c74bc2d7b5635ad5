#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <thread>

#include "services/platform/bus/samples.h"
#include "services/platform/host/stage/flow.h"
#include "tests/patience.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::host {
namespace {

using namespace std::chrono_literals;
using bus::Borrow;
using test::Eventually;
using Clock = std::chrono::steady_clock;

PointCloud CloudOf(std::size_t count) {
  PointCloud cloud;
  for (std::size_t i = 0; i < count; ++i) {
    const auto t = static_cast<double>(i);
    cloud.Add(Vec3(t, 1 / (1 + t), -t), static_cast<std::uint32_t>(i % 3));
  }
  return cloud;
}

class PointFlowTest : public testing::Test {
 protected:
  /// The whole way; empty when it fails.
  Result<PointCloud> Transfer(const PointCloud& cloud, const std::string& job_uid) {
    sender.Begin(job_uid, 1, {}, cloud, Clock::now());
    if (auto opened = intake.Open(job_uid, 1); !opened)
      return tl::unexpected(opened.error());
    Result<bool> taken = false, sent = false;
    const test::Patience patience(10s);
    while ((!taken.value() || !sent.value()) && !patience.over()) {
      sent = sender.Advance(Clock::now());
      taken = intake.Poll();
      if (!sent) return tl::unexpected(sent.error());
      if (!taken) return tl::unexpected(taken.error());
    }
    EXPECT_TRUE(sent.value());
    return intake.TakeContent();
  }

  /// Opens the intake and waits until this test may write batches to it.
  void OpenFor(const std::string& job_uid) {
    ASSERT_TRUE(intake.Open(job_uid, 1));
    ASSERT_TRUE(Eventually([&] { return writer.IsMatched(intake.reader().guid()); }));
  }
  Result<bool> PollUntilDecided() {
    Result<bool> taken = false;
    EXPECT_TRUE(Eventually([&] { return taken = intake.Poll(), !taken || *taken; }));
    return taken;
  }

  bus::Bus bus{test::PrivateBusOptions()};
  PointSender sender{bus, bus::kPointBatch, ""};
  PointIntake intake{bus, "consumer", bus::kPointBatch};
  bus::Writer<intaglio_PointBatch> writer{bus, bus::kPointBatch};
};

TEST_F(PointFlowTest, CarriesCloudsBitForBitOneAfterAnother) {
  // More than a window of batches, whole batches, one point, none.
  for (const std::size_t count : {300'000, 2 * 8192, 1, 0}) {
    const PointCloud cloud = CloudOf(count);
    const auto got = Transfer(cloud, "job-" + std::to_string(count));
    ASSERT_TRUE(got) << got.error().message;
    EXPECT_EQ(got->points_mm, cloud.points_mm);
    EXPECT_EQ(got->source, cloud.source);
  }
}

TEST_F(PointFlowTest, AConsumerThatGoesEndsTheSending) {
  sender.Begin("j", 1, {}, CloudOf(3'000'000), Clock::now());
  ASSERT_TRUE(intake.Open("j", 1));
  Result<bool> sent = false;
  ASSERT_TRUE(Eventually(
      [&] { return sent = sender.Advance(Clock::now()), sent && intake.Poll(); }));
  intake.Close();
  ASSERT_TRUE(Eventually([&] { return sent = sender.Advance(Clock::now()), !sent; }));
  EXPECT_EQ(sent.error().code, ErrorCode::kLinkLost);
}

TEST_F(PointFlowTest, AConsumerThatNeverComesIsGivenUp) {
  const auto start = Clock::now();
  sender.Begin("nobody", 1, {}, CloudOf(10), start);
  EXPECT_FALSE(sender.Advance(start + 59s).value());
  const auto late = sender.Advance(start + 61s);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kTimedOut);
}

TEST_F(PointFlowTest, WhatContradictsItselfIsRefused) {
  struct Case {
    const char* what;
    std::function<void(intaglio_PointBatch&)> spoil;
    ErrorCode code;
  };
  const std::vector<double> one = {1}, two = {1, 2},
                            nan = {std::numeric_limits<double>::quiet_NaN()};
  const Case cases[] = {
      {"a batch is missing", [](auto& b) { b.sequence_number = 1; },
       ErrorCode::kLinkLost},
      {"a gap in the points", [](auto& b) { b.first_index = 1; }, ErrorCode::kLinkLost},
      {"columns of other lengths", [&](auto& b) { Borrow(b.z_mm, two); },
       ErrorCode::kFault},
      {"more points than told", [](auto& b) { b.total_count = 0; }, ErrorCode::kFault},
      {"the end too early", [](auto& b) { b.total_count = 2; }, ErrorCode::kFault},
      {"not a number", [&](auto& b) { Borrow(b.y_mm, nan); }, ErrorCode::kFault},
      {"far too many", [](auto& b) { b.total_count = 1ull << 60; },
       ErrorCode::kTooLarge}};
  const std::vector<std::uint32_t> source = {0};
  for (const Case& c : cases) {
    const std::string job_uid = c.what;
    OpenFor(job_uid);
    intaglio_PointBatch batch{};
    batch.job_uid = Borrow(job_uid);
    batch.attempt = 1;
    batch.part_count = 1;
    batch.total_count = 1;
    batch.last = true;
    Borrow(batch.x_mm, one);
    Borrow(batch.y_mm, one);
    Borrow(batch.z_mm, one);
    Borrow(batch.source, source);
    c.spoil(batch);
    ASSERT_TRUE(writer.Write(batch));
    const auto taken = PollUntilDecided();
    ASSERT_FALSE(taken) << c.what;
    EXPECT_EQ(taken.error().code, c.code) << c.what;
  }
}

// What the parts of a job need of the intake: several senders as several processes have
// them, each with a part of its own.
class PointPartsTest : public PointFlowTest {
 protected:
  /// The points of this part, some of them empty.
  PointCloud PieceOf(std::uint32_t part, std::uint32_t count) const {
    PointCloud piece;
    const auto cut = [&](std::uint32_t k) {
      return whole.size() * k * k / count / count;
    };
    for (std::size_t i = cut(part); i < cut(part + 1); ++i) {
      piece.Add(whole.points_mm[i], whole.source[i]);
    }
    return piece;
  }
  /// Sends this part until it is taken; what came of it.
  Result<bool> Send(PointSender& by, TaskPart part) {
    by.Begin("j", 1, part, PieceOf(part.index, part.count), Clock::now());
    return Finish(by);
  }
  Result<bool> Finish(PointSender& by) {
    Result<bool> sent = false;
    EXPECT_TRUE(Eventually([&] {
      sent = by.Advance(Clock::now());
      taken = intake.Poll();
      return !sent || *sent || !taken;
    }));
    return sent;
  }
  void ExpectWhole() {
    ASSERT_TRUE(taken && *taken);
    const PointCloud got = intake.TakeContent();
    EXPECT_EQ(got.points_mm, whole.points_mm);
    EXPECT_EQ(got.source, whole.source);
  }

  const PointCloud whole = CloudOf(600'000);
  PointSender second{bus, bus::kPointBatch, ""};
  Result<bool> taken = false;
};

TEST_F(PointPartsTest, ComeTogetherInAnyOrder) {
  ASSERT_TRUE(intake.Open("j", 1, 5));
  for (const std::uint32_t part : {3u, 0u, 4u, 2u}) {
    ASSERT_TRUE(Send(sender, {part, 5, 0}));
    EXPECT_FALSE(*taken);
  }
  ASSERT_TRUE(Send(second, {1, 5, 0}));
  ExpectWhole();
}

TEST_F(PointPartsTest, ComeSideBySide) {
  ASSERT_TRUE(intake.Open("j", 1, 2));
  sender.Begin("j", 1, {1, 2, 0}, PieceOf(1, 2), Clock::now());
  second.Begin("j", 1, {0, 2, 0}, PieceOf(0, 2), Clock::now());
  Result<bool> one = false, two = false;
  ASSERT_TRUE(Eventually([&] {
    one = sender.Advance(Clock::now());
    two = second.Advance(Clock::now());
    taken = intake.Poll();
    return *one && *two && *taken;
  }));
  ExpectWhole();
}

TEST_F(PointPartsTest, OneBegunAgainTakesTheOldOnesPlace) {
  ASSERT_TRUE(intake.Open("j", 1, 2));
  // Its process is killed, or thought to be, in the middle: a window's batches are there.
  sender.Begin("j", 1, {1, 2, 0}, PieceOf(1, 2), Clock::now());
  bus::CreditBook book(bus);
  const std::string stream = bus::PartStreamName("j", 1, bus::kPointBatch.name, 1, 0);
  ASSERT_TRUE(Eventually([&] {
    const bool all_sent = *sender.Advance(Clock::now());
    EXPECT_FALSE(all_sent);
    taken = intake.Poll();
    book.Poll();
    return book.Find(stream).consumed > 0;
  }));
  ASSERT_TRUE(Send(second, {1, 2, 1}));
  const auto old = Finish(sender);
  ASSERT_FALSE(old) << "nobody wants the rest of it";
  EXPECT_EQ(old.error().code, ErrorCode::kLinkLost);
  ASSERT_TRUE(Send(second, {0, 2, 0}));
  ExpectWhole();
}

// Its first sender died when it had sent everything and not reported it yet.
TEST_F(PointPartsTest, OneThatIsThereAlreadyIsAcknowledgedAndDropped) {
  ASSERT_TRUE(intake.Open("j", 1, 2));
  ASSERT_TRUE(Send(sender, {1, 2, 0}));
  ASSERT_TRUE(Send(second, {1, 2, 1}));
  EXPECT_FALSE(*taken);
  ASSERT_TRUE(Send(second, {0, 2, 0}));
  ASSERT_TRUE(Send(sender, {0, 2, 2})) << "also when the cloud is whole";
  ExpectWhole();
  ASSERT_TRUE(Send(sender, {0, 2, 1})) << "and when it was taken";
}

TEST_F(PointPartsTest, OfAnotherCutAreRefused) {
  struct Case {
    std::uint32_t part, part_count, part_attempt;
  };
  for (const Case& c : {Case{0, 3, 0}, Case{2, 2, 0}, Case{0, 2, kMaxPartAttempts}}) {
    ASSERT_TRUE(intake.Open("j", 1, 2));
    ASSERT_TRUE(Eventually([&] { return writer.IsMatched(intake.reader().guid()); }));
    intaglio_PointBatch batch{};
    const std::string job_uid = "j";
    batch.job_uid = Borrow(job_uid);
    batch.attempt = 1;
    batch.part = c.part;
    batch.part_count = c.part_count;
    batch.part_attempt = c.part_attempt;
    ASSERT_TRUE(writer.Write(batch));
    const auto refused = PollUntilDecided();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().code, ErrorCode::kFault);
  }
  EXPECT_FALSE(intake.Open("j", 1, 0));
  EXPECT_FALSE(intake.Open("j", 1, kMaxParts + 1));
}

TEST_F(PointPartsTest, TooManyTogetherAreRefused) {
  ASSERT_TRUE(intake.Open("j", 1, 2));
  ASSERT_TRUE(Send(sender, {1, 2, 0}));
  intaglio_PointBatch batch{};
  const std::string job_uid = "j";
  batch.job_uid = Borrow(job_uid);
  batch.attempt = 1;
  batch.part_count = 2;
  batch.total_count = kMaxCloudPoints;
  ASSERT_TRUE(Eventually([&] { return writer.IsMatched(intake.reader().guid()); }));
  ASSERT_TRUE(writer.Write(batch));
  const auto refused = PollUntilDecided();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kTooLarge);
}

// All of it in one turn: the credit of a turn is that of the one before.
TEST_F(PointFlowTest, WhatExceedsTheCreditIsRefused) {
  constexpr std::uint64_t kWindowBatches =
      PointCodec<intaglio_PointBatch>::kWindowBatches;
  const std::string job_uid = "j";
  const std::vector<double> one = {1};
  const std::vector<std::uint32_t> source = {0};
  OpenFor(job_uid);
  for (std::uint64_t i = 0; i <= kWindowBatches; ++i) {
    intaglio_PointBatch batch{};
    batch.job_uid = Borrow(job_uid);
    batch.attempt = 1;
    batch.part_count = 1;
    batch.sequence_number = batch.first_index = i;
    batch.total_count = 1000;
    Borrow(batch.x_mm, one);
    Borrow(batch.y_mm, one);
    Borrow(batch.z_mm, one);
    Borrow(batch.source, source);
    ASSERT_TRUE(writer.Write(batch));
  }
  ASSERT_TRUE(writer.WaitForAcknowledgements(5s));
  const auto taken = intake.Poll();
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().code, ErrorCode::kFault);
  EXPECT_THAT(taken.error().message,
              testing::HasSubstr("exceeds the granted credit, batches below 32"));
}

TEST_F(PointFlowTest, BatchesOfAnotherAttemptAreDropped) {
  OpenFor("j");
  intaglio_PointBatch old{};
  const std::string job_uid = "j";
  old.job_uid = Borrow(job_uid);
  old.attempt = 0;
  old.part_count = 1;
  old.last = true;
  ASSERT_TRUE(writer.Write(old));
  const auto got = Transfer(CloudOf(5), "j");
  ASSERT_TRUE(got);
  EXPECT_EQ(got->size(), 5u);
}

}  // namespace
}  // namespace intaglio::host
