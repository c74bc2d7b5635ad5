#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "engrave/mark/mark_file.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/stage/flow.h"
#include "tests/patience.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::host {
namespace {

using namespace std::chrono_literals;
using bus::Borrow;
using test::Eventually;
using testing::HasSubstr;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kWindow = 32;  // of the intake

/// Marks of one to three places on a web, with two pens.
mark::MarkSet MarksOf(std::size_t count) {
  mark::MarkSet set;
  set.pens = {{"item 1", 1000, 0.5, 20000, 2}, {"item 2", 300, 1, 0, 1, 0.1, 5}};
  for (std::size_t i = 0; i < count; ++i) {
    const auto t = static_cast<double>(i);
    mark::Mark mark{static_cast<std::uint32_t>(i % 2), i % 3 == 2, t / 7, {}};
    for (std::size_t k = 0; k <= i % 3; ++k)
      mark.places.push_back({Vec2(t + static_cast<double>(k), 1 / (1 + t)), 0.25});
    // Rows of two dots, in some batches and not in others.
    if (i > 5000 && i % 3 == 1) {
      mark.places = {{{t, 1}}, {{t + 1, 1}, 0, true}, {{t + 2, 1}}, {{t + 3, 1}}};
    }
    set.marks.push_back(std::move(mark));
  }
  return set;
}

void ExpectSame(const mark::MarkSet& got, const mark::MarkSet& sent) {
  ASSERT_EQ(got.marks.size(), sent.marks.size());
  ASSERT_EQ(got.pens.size(), sent.pens.size());
  EXPECT_EQ(mark::MarksCrc(got), mark::MarksCrc(sent));
  for (std::size_t i = 0; i < got.marks.size(); ++i) {
    ASSERT_EQ(got.marks[i].places.size(), sent.marks[i].places.size());
    for (std::size_t k = 0; k < got.marks[i].places.size(); ++k)
      ASSERT_EQ(got.marks[i].places[k].at_mm, sent.marks[i].places[k].at_mm) << i;
  }
}

class MarkFlowTest : public testing::Test {
 protected:
  Result<mark::MarkSet> Transfer(const mark::MarkSet& set, const std::string& job_uid) {
    sender.Begin(job_uid, 1, {}, set, Clock::now());
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
    EXPECT_TRUE(sent.value() && taken.value());
    return intake.TakeContent();
  }
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
  MarkSender sender{bus, bus::kMarkBatch, ""};
  MarkIntake intake{bus, "consumer", bus::kMarkBatch};
  bus::Writer<intaglio_MarkBatch> writer{bus, bus::kMarkBatch};
};

TEST_F(MarkFlowTest, CarriesMarksBitForBitOneJobAfterAnother) {
  // More than a window of batches, whole batches, one mark, none.
  for (const std::size_t count :
       {std::size_t{200'000}, 2 * kBatchMarks, std::size_t{1}, std::size_t{0}}) {
    const mark::MarkSet set = MarksOf(count);
    const auto got = Transfer(set, "job-" + std::to_string(count));
    ASSERT_TRUE(got) << got.error().message;
    ExpectSame(*got, set);
  }
}

TEST_F(MarkFlowTest, AMarkOfManyPlacesTravelsWhole) {
  mark::MarkSet set = MarksOf(3);
  for (std::size_t k = 0; k < 3 * kBatchPlaces; ++k)
    set.marks[1].places.push_back({Vec2(static_cast<double>(k), 2), 0});
  const auto got = Transfer(set, "long");
  ASSERT_TRUE(got) << got.error().message;
  ExpectSame(*got, set);
}

TEST_F(MarkFlowTest, NoMoreIsSentThanAWindowOfBatches) {
  ASSERT_TRUE(intake.Open("j", 1));
  sender.Begin("j", 1, {}, MarksOf((kWindow + 8) * kBatchMarks), Clock::now());
  bus::Reader<intaglio_MarkBatch> listener(bus, bus::kMarkBatch);
  std::uint64_t sent_count = 0;
  const auto listen = [&] {
    EXPECT_FALSE(sender.Advance(Clock::now()).value());
    listener.Take([&](const intaglio_MarkBatch&) { ++sent_count; });
  };
  ASSERT_TRUE(Eventually([&] { return listen(), sent_count == kWindow; }));
  for (int i = 0; i < 100; ++i) listen();
  EXPECT_EQ(sent_count, kWindow) << "what is not consumed is not followed by more";
  EXPECT_FALSE(intake.Poll().value());
  EXPECT_TRUE(Eventually([&] { return listen(), sent_count > kWindow; }));
}

TEST_F(MarkFlowTest, AConsumerThatGoesEndsTheSending) {
  sender.Begin("j", 1, {}, MarksOf(500'000), Clock::now());
  ASSERT_TRUE(intake.Open("j", 1));
  Result<bool> sent = false;
  ASSERT_TRUE(Eventually(
      [&] { return sent = sender.Advance(Clock::now()), sent && intake.Poll(); }));
  intake.Close();
  ASSERT_TRUE(Eventually([&] { return sent = sender.Advance(Clock::now()), !sent; }));
  EXPECT_EQ(sent.error().code, ErrorCode::kLinkLost);
}

TEST_F(MarkFlowTest, AConsumerThatNeverComesIsGivenUp) {
  const auto start = Clock::now();
  sender.Begin("nobody", 1, {}, MarksOf(10), start);
  EXPECT_FALSE(sender.Advance(start + 59s).value());
  const auto late = sender.Advance(start + 61s);
  ASSERT_FALSE(late);
  EXPECT_EQ(late.error().code, ErrorCode::kTimedOut);
}

/// One mark of two places, right in everything.
class OneMarkBatch {
 public:
  explicit OneMarkBatch(std::string job_uid) : job_uid_(std::move(job_uid)) {
    pens_[0].name = Borrow(name_);
    pens_[0].speed_mm_s = 100;
    pens_[0].power_ratio = 0.5;
    pens_[0].pass_count = 1;
    batch.job_uid = Borrow(job_uid_);
    batch.attempt = 1;
    batch.total_count = 1;
    batch.last = true;
    Borrow(batch.pens, pens_);
    Borrow(batch.pen, pen_);
    Borrow(batch.closed, closed_);
    Borrow(batch.web_mm, web_mm_);
    Borrow(batch.place_count, count_);
    Borrow(batch.x_mm, two_);
    Borrow(batch.y_mm, two_);
    Borrow(batch.bulge, zeros_);
  }

  intaglio_MarkBatch batch{};

 private:
  std::string job_uid_, name_ = "pen";
  std::vector<intaglio_MarkPen> pens_{1};
  std::vector<std::uint32_t> pen_{0}, count_{2};
  std::vector<std::uint8_t> closed_{0};
  std::vector<double> web_mm_{0}, two_{1, 2}, zeros_{0, 0};
};

TEST_F(MarkFlowTest, WhatContradictsItselfIsRefusedByItsField) {
  struct Case {
    const char* what;
    std::function<void(intaglio_MarkBatch&)> spoil;
    ErrorCode code;
    const char* message;
  };
  const std::vector<double> one = {1}, three = {1, 2, 3},
                            nan = {std::numeric_limits<double>::quiet_NaN(), 1};
  const std::vector<std::uint32_t> of_three = {3}, of_none = {0}, pen_five = {5},
                                   two_counts = {1, 1};
  const std::vector<std::uint8_t> one_flag = {0}, two_flags = {0, 0};
  const std::vector<std::uint32_t> no_marks;
  const std::vector<std::uint8_t> no_flags;
  const std::vector<double> no_values;
  const auto empty = [&](intaglio_MarkBatch& b) {
    Borrow(b.pen, no_marks), Borrow(b.place_count, no_marks), Borrow(b.closed, no_flags);
    Borrow(b.web_mm, no_values), Borrow(b.x_mm, no_values), Borrow(b.y_mm, no_values);
    Borrow(b.bulge, no_values);
  };
  const Case cases[] = {
      {"a batch is missing", [](auto& b) { b.sequence_number = 1; }, ErrorCode::kLinkLost,
       "batch 0 of MarkBatch is missing"},
      {"a gap in the marks", [](auto& b) { b.first_mark = 1; }, ErrorCode::kLinkLost,
       "is missing"},
      {"closed", [&](auto& b) { Borrow(b.closed, two_flags); }, ErrorCode::kFault,
       "closed is 2, and not 1"},
      {"web", [&](auto& b) { Borrow(b.web_mm, three); }, ErrorCode::kFault,
       "web_mm is 3, and not 1"},
      {"counts", [&](auto& b) { Borrow(b.place_count, two_counts); }, ErrorCode::kFault,
       "place_count is 2, and not 1"},
      {"y", [&](auto& b) { Borrow(b.y_mm, three); }, ErrorCode::kFault,
       "y_mm is 3, and not 2"},
      {"bulge", [&](auto& b) { Borrow(b.bulge, one); }, ErrorCode::kFault,
       "bulge is 1, and not 2"},
      {"dark", [&](auto& b) { Borrow(b.dark, one_flag); }, ErrorCode::kFault,
       "dark is 1, and not 2"},
      {"sum", [&](auto& b) { Borrow(b.place_count, of_three); }, ErrorCode::kFault,
       "the sum of place_count is 3, and not 2"},
      {"no place",
       [&](auto& b) {
         Borrow(b.place_count, of_none), Borrow(b.x_mm, no_values);
         Borrow(b.y_mm, no_values), Borrow(b.bulge, no_values);
       },
       ErrorCode::kFault, "mark batch 0, from mark 0 on"},
      {"pen", [&](auto& b) { Borrow(b.pen, pen_five); }, ErrorCode::kFault, "pen"},
      {"not a number", [&](auto& b) { Borrow(b.x_mm, nan); }, ErrorCode::kFault,
       "mark batch 0, from mark 0 on"},
      {"more than told", [](auto& b) { b.total_count = 0; }, ErrorCode::kFault,
       "total_count is 0, and 1 marks have come"},
      {"the end too early", [](auto& b) { b.total_count = 2; }, ErrorCode::kFault,
       "it is the last, with 1 of 2 marks"},
      {"far too many", [](auto& b) { b.total_count = 1ull << 60; }, ErrorCode::kFault,
       "total_count is 1152921504606846976, above"},
      {"empty in the middle",
       [&](auto& b) {
         empty(b);
         b.last = false;
       },
       ErrorCode::kFault, "it has no marks and is not the last"}};
  for (const Case& c : cases) {
    OpenFor(c.what);
    OneMarkBatch one_mark(c.what);
    c.spoil(one_mark.batch);
    ASSERT_TRUE(writer.Write(one_mark.batch));
    const auto taken = PollUntilDecided();
    ASSERT_FALSE(taken) << c.what;
    EXPECT_EQ(taken.error().code, c.code) << c.what;
    EXPECT_THAT(taken.error().message, HasSubstr(c.message)) << c.what;
  }
  OpenFor("right");
  ASSERT_TRUE(writer.Write(OneMarkBatch("right").batch));
  EXPECT_TRUE(PollUntilDecided().value());
}

TEST_F(MarkFlowTest, TheTotalStaysAndPensComeOnce) {
  const auto second = [&](const char* job, auto spoil) {
    OpenFor(job);
    OneMarkBatch first(job), next(job);
    first.batch.last = false;
    first.batch.total_count = 2;
    next.batch.sequence_number = next.batch.first_mark = 1;
    next.batch.total_count = 2;
    spoil(next.batch);
    EXPECT_TRUE(writer.Write(first.batch));
    EXPECT_TRUE(writer.Write(next.batch));
    const auto taken = PollUntilDecided();
    return taken ? std::string() : taken.error().message;
  };
  const std::vector<intaglio_MarkPen> none;
  const auto without_pens = [&](intaglio_MarkBatch& b) { Borrow(b.pens, none); };
  EXPECT_EQ(second("right", without_pens), "");
  EXPECT_THAT(second("pens", [](auto&) {}), HasSubstr("pens are of the first batch"));
  EXPECT_THAT(second("total",
                     [&](auto& b) {
                       without_pens(b);
                       b.total_count = 3;
                       b.last = false;
                     }),
              HasSubstr("total_count is 3, and was 2"));
  EXPECT_THAT(second("gap",
                     [&](auto& b) {
                       without_pens(b);
                       b.sequence_number = 2;
                     }),
              HasSubstr("batch 1 of MarkBatch is missing"));
}

TEST_F(MarkFlowTest, WhatExceedsTheCreditIsRefused) {
  OpenFor("j");
  bus::Reader<intaglio_MarkBatch> listener(bus, bus::kMarkBatch);
  ASSERT_TRUE(Eventually([&] { return writer.IsMatched(listener.guid()); }));
  const mark::MarkSet set = MarksOf(kWindow + 1);
  for (std::uint32_t i = 0; i <= kWindow; ++i) {
    const MarkColumns columns(set, i, 1);
    intaglio_MarkBatch batch{};
    const std::string job_uid = "j";
    batch.job_uid = Borrow(job_uid);
    batch.attempt = 1;
    batch.sequence_number = batch.first_mark = i;
    batch.total_count = set.marks.size();
    batch.last = i == kWindow;
    columns.BorrowTo(batch);
    ASSERT_TRUE(writer.Write(batch));
  }
  // All of them in one turn: the credit of a turn is that of the one before.
  std::uint32_t come = 0;
  ASSERT_TRUE(Eventually([&] {
    listener.Take([&](const intaglio_MarkBatch&) { ++come; });
    return come > kWindow;
  }));
  const auto taken = PollUntilDecided();
  ASSERT_FALSE(taken);
  EXPECT_EQ(taken.error().code, ErrorCode::kFault);
  EXPECT_THAT(taken.error().message, HasSubstr("exceeds the granted credit"));
}

TEST_F(MarkFlowTest, ALaterSenderBeginsAnewAndAnEarlierOneIsDropped) {
  const mark::MarkSet set = MarksOf((kWindow + 8) * kBatchMarks);
  MarkSender second(bus, bus::kMarkBatch, "");
  ASSERT_TRUE(intake.Open("j", 1));
  sender.Begin("j", 1, {}, set, Clock::now());
  bus::CreditBook book(bus);
  const std::string stream = bus::PartStreamName("j", 1, bus::kMarkBatch.name, 0, 0);
  ASSERT_TRUE(Eventually([&] {
    EXPECT_FALSE(sender.Advance(Clock::now()).value());
    EXPECT_TRUE(intake.Poll());
    book.Poll();
    return book.Find(stream).consumed > 0;
  }));
  // It begins with as many batches as have come of the first one.
  second.Begin("j", 1, {.attempt = 1}, set, Clock::now());
  Result<bool> sent = false, taken = false;
  ASSERT_TRUE(Eventually(
      [&] {
        sent = second.Advance(Clock::now());
        if (taken && !*taken) taken = intake.Poll();
        return !sent || !taken || (*sent && *taken);
      },
      10s));
  ASSERT_TRUE(sent && taken);
  ExpectSame(intake.TakeContent(), set);
  Result<bool> old = false;
  ASSERT_TRUE(Eventually([&] { return old = sender.Advance(Clock::now()), !old; }));
  EXPECT_EQ(old.error().code, ErrorCode::kLinkLost);
}

TEST_F(MarkFlowTest, BatchesOfAnotherAttemptAreDropped) {
  OpenFor("j");
  OneMarkBatch old("j");
  old.batch.attempt = 0;
  ASSERT_TRUE(writer.Write(old.batch));
  const mark::MarkSet set = MarksOf(5);
  const auto got = Transfer(set, "j");
  ASSERT_TRUE(got) << got.error().message;
  ExpectSame(*got, set);
}

TEST_F(MarkFlowTest, AnImpossiblePartIsRefused) {
  OpenFor("j");
  OneMarkBatch unknown("j");
  unknown.batch.part_attempt = kMaxPartAttempts;
  ASSERT_TRUE(writer.Write(unknown.batch));
  const auto refused = PollUntilDecided();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kFault);
}

}  // namespace
}  // namespace intaglio::host
