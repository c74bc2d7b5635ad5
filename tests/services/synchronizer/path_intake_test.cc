#include "services/synchronizer/path_intake.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "services/platform/bus/samples.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::synchronizer {
namespace {

using test::Eventually;

struct Batch {
  std::uint64_t number = 0;
  std::vector<double> x_mm;
  std::uint64_t first_index = 0, total_count = 0;
  bool last = false;
  std::string job = "job";
  std::uint32_t attempt = 1;
  std::vector<double> y_mm = {};  ///< as many as x when empty
};

class PathIntakeTest : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(intake_.Open("job", 1));
    ASSERT_TRUE(Eventually([this] {
      credit_.Poll();
      return Grant().open && writer_.IsMatched(intake_.reader().guid());
    }));
  }

  bus::CreditBook::Grant Grant(std::uint32_t attempt = 1) {
    return credit_.Find(bus::PartStreamName("job", attempt, bus::kPathBatch.name, 0, 0));
  }

  /// Written, taken, and what came of it.
  Status Give(const Batch& batch) {
    Write(batch);
    // Reliable: once it is acknowledged it can be taken.
    EXPECT_TRUE(writer_.WaitForAcknowledgements(std::chrono::seconds(5)));
    return intake_.Poll();
  }

  void Write(const Batch& batch) {
    const std::vector<double>& y = batch.y_mm.empty() ? batch.x_mm : batch.y_mm;
    std::vector<std::uint32_t> source;
    for (std::size_t i = 0; i < batch.x_mm.size(); ++i) {
      source.push_back(static_cast<std::uint32_t>(batch.first_index + i) + 100);
    }
    intaglio_PathBatch sample{};
    sample.job_uid = bus::Borrow(batch.job);
    sample.attempt = batch.attempt;
    sample.sequence_number = batch.number;
    sample.first_index = batch.first_index;
    sample.total_count = batch.total_count;
    sample.last = batch.last;
    bus::Borrow(sample.x_mm, batch.x_mm);
    bus::Borrow(sample.y_mm, y);
    bus::Borrow(sample.z_mm, batch.x_mm);
    bus::Borrow(sample.source, source);
    EXPECT_TRUE(writer_.Write(sample));
  }

  bus::Bus bus_{test::PrivateBusOptions()};
  bus::Writer<intaglio_PathBatch> writer_{bus_, bus::kPathBatch};
  bus::CreditBook credit_{bus_};
  PathIntake intake_{bus_, "synchronizer"};
};

TEST_F(PathIntakeTest, TakesAPathInItsOrderAndGivesCreditBack) {
  ASSERT_TRUE(Give({0, {1, 2, 3}, 0, 5, false}));
  EXPECT_FALSE(intake_.complete());
  ASSERT_TRUE(Give({1, {4, 5}, 3, 5, true}));
  EXPECT_TRUE(intake_.complete());
  EXPECT_EQ(intake_.total_count(), 5);
  ASSERT_EQ(intake_.path().size(), 5);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(intake_.path().points_mm[i],
              Vec3(Vec3::Constant(1.0 + static_cast<double>(i))));
    EXPECT_EQ(intake_.path().source[i], 100 + i);
  }
  EXPECT_TRUE(Eventually([this] {
    credit_.Poll();
    return Grant().consumed == 2;
  }));
  intake_.Close();
  EXPECT_TRUE(Eventually([this] {
    credit_.Poll();
    return Grant().cancelled;
  }));
}

TEST_F(PathIntakeTest, PassesOverWhatBelongsToAnotherJobOrAttempt) {
  ASSERT_TRUE(Give({0, {7}, 0, 1, true, "another"}));
  ASSERT_TRUE(Give({0, {7}, 0, 1, true, "job", 2}));
  EXPECT_EQ(intake_.path().size(), 0);
  EXPECT_FALSE(intake_.complete());
}

TEST_F(PathIntakeTest, ForgetsAPathWhenAnotherAttemptIsOpened) {
  ASSERT_TRUE(Give({0, {1, 2}, 0, 4, false}));
  ASSERT_TRUE(intake_.Open("job", 2));
  EXPECT_EQ(intake_.path().size(), 0);
  ASSERT_TRUE(Give({1, {3, 4}, 2, 4, true}));  // late, of the old attempt
  EXPECT_EQ(intake_.path().size(), 0);
  ASSERT_TRUE(Give({0, {9}, 0, 1, true, "job", 2}));
  EXPECT_TRUE(intake_.complete());
  EXPECT_EQ(intake_.path().size(), 1);
}

TEST_F(PathIntakeTest, AMissingBatchIsAFault) {
  ASSERT_TRUE(Give({0, {1}, 0, 3, false}));
  const Status status = Give({2, {3}, 2, 3, true});
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kFault);
}

TEST_F(PathIntakeTest, ADoubledBatchIsAFault) {
  ASSERT_TRUE(Give({0, {1}, 0, 3, false}));
  EXPECT_FALSE(Give({0, {1}, 0, 3, false}));
}

TEST_F(PathIntakeTest, ColumnsThatDisagreeAreAFault) {
  EXPECT_FALSE(Give({0, {1, 2}, 0, 2, true, "job", 1, {1}}));
  EXPECT_EQ(intake_.path().size(), 0);
}

TEST_F(PathIntakeTest, MorePointsThanPromisedAreAFault) {
  EXPECT_FALSE(Give({0, {1, 2, 3}, 0, 2, true}));
}

TEST_F(PathIntakeTest, FewerPointsThanPromisedAreAFault) {
  EXPECT_FALSE(Give({0, {1, 2}, 0, 3, true}));
}

TEST_F(PathIntakeTest, AWildTotalIsAFault) {
  EXPECT_FALSE(Give({0, {1}, 0, std::numeric_limits<std::uint64_t>::max(), false}));
}

TEST_F(PathIntakeTest, ATotalThatChangesIsAFault) {
  ASSERT_TRUE(Give({0, {1}, 0, 3, false}));
  EXPECT_FALSE(Give({1, {2}, 1, 4, false}));
}

TEST_F(PathIntakeTest, ABatchThatIsTooLargeIsAFault) {
  EXPECT_FALSE(Give({0, std::vector<double>(8193, 1.0), 0, 20'000, false}));
  EXPECT_EQ(intake_.path().size(), 0);
}

// The reader has no limit (it would stop the receive thread), so the intake has.
TEST_F(PathIntakeTest, AFloodBeyondTheWindowIsRefusedAndDropped) {
  constexpr std::uint64_t kWindow = 32;
  const auto flood = [this](std::uint64_t first, std::uint64_t end) {
    for (std::uint64_t i = first; i < end; ++i) Write({i, {1}, i, 1'000'000, false});
    EXPECT_TRUE(writer_.WaitForAcknowledgements(std::chrono::seconds(5)));
  };
  flood(0, 200);
  const Status status = intake_.Poll();
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kFault);
  EXPECT_THAT(status.error().message,
              testing::HasSubstr("batch 32 with 1 points exceeds"));
  EXPECT_EQ(intake_.path().size(), kWindow);
  EXPECT_TRUE(Eventually([this] {
    credit_.Poll();
    return Grant().cancelled;
  })) << "the sorter knows that no more is wanted";
  flood(200, 400);
  EXPECT_TRUE(intake_.Poll());
  EXPECT_EQ(intake_.path().size(), kWindow);
  EXPECT_EQ(intake_.reader().Take([](const intaglio_PathBatch&) {}), 0)
      << "nothing is kept";
}

TEST_F(PathIntakeTest, AllThatWasGrantedMayComeAtOnceAndMoreWhenItWasTaken) {
  for (std::uint64_t i = 0; i < 32; ++i) Write({i, {1}, i, 64, false});
  EXPECT_TRUE(writer_.WaitForAcknowledgements(std::chrono::seconds(5)));
  ASSERT_TRUE(intake_.Poll());
  for (std::uint64_t i = 32; i < 64; ++i) Write({i, {1}, i, 64, i == 63});
  EXPECT_TRUE(writer_.WaitForAcknowledgements(std::chrono::seconds(5)));
  ASSERT_TRUE(intake_.Poll());
  EXPECT_TRUE(intake_.complete());
  EXPECT_EQ(intake_.TakePath().size(), 64);
  EXPECT_FALSE(intake_.complete());
  EXPECT_EQ(intake_.path().size(), 0);
}

TEST_F(PathIntakeTest, ACoordinateThatIsNoNumberIsAFault) {
  EXPECT_FALSE(Give({0, {std::nan("")}, 0, 1, true}));
}

}  // namespace
}  // namespace intaglio::synchronizer
