#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "services/platform/bus/samples.h"
#include "services/platform/host/stage/flow.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::host {
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

class PathFlowTest : public testing::Test {
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
  Result<bool> Give(const Batch& batch) {
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
    sample.part_count = 1;
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
  PathIntake intake_{bus_, "synchronizer", bus::kPathBatch};
};

TEST_F(PathFlowTest, TakesAPathInItsOrderAndGivesCreditBack) {
  EXPECT_FALSE(Give({0, {1, 2, 3}, 0, 5, false}).value());
  EXPECT_TRUE(Give({1, {4, 5}, 3, 5, true}).value());
  const PointCloud path = intake_.TakeContent();
  ASSERT_EQ(path.size(), 5);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(path.points_mm[i], Vec3(Vec3::Constant(1.0 + static_cast<double>(i))));
    EXPECT_EQ(path.source[i], 100 + i);
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

TEST_F(PathFlowTest, PassesOverWhatBelongsToAnotherJobOrAttempt) {
  EXPECT_FALSE(Give({0, {7}, 0, 1, true, "another"}).value());
  EXPECT_FALSE(Give({0, {7}, 0, 1, true, "job", 2}).value());
  EXPECT_EQ(intake_.TakeContent().size(), 0);
}

TEST_F(PathFlowTest, ForgetsAPathWhenAnotherAttemptIsOpened) {
  ASSERT_TRUE(Give({0, {1, 2}, 0, 4, false}));
  ASSERT_TRUE(intake_.Open("job", 2));
  EXPECT_FALSE(Give({1, {3, 4}, 2, 4, true}).value());  // late, of the old attempt
  EXPECT_TRUE(Give({0, {9}, 0, 1, true, "job", 2}).value());
  EXPECT_EQ(intake_.TakeContent().points_mm, std::vector<Vec3>{Vec3::Constant(9)});
}

TEST_F(PathFlowTest, AMissingBatchIsALostLink) {
  ASSERT_TRUE(Give({0, {1}, 0, 3, false}));
  const auto refused = Give({2, {3}, 2, 3, true});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kLinkLost);
}

TEST_F(PathFlowTest, ADoubledBatchIsAFault) {
  ASSERT_TRUE(Give({0, {1}, 0, 3, false}));
  EXPECT_FALSE(Give({0, {1}, 0, 3, false}));
}

TEST_F(PathFlowTest, ColumnsThatDisagreeAreAFault) {
  EXPECT_FALSE(Give({0, {1, 2}, 0, 2, true, "job", 1, {1}}));
  EXPECT_EQ(intake_.TakeContent().size(), 0);
}

TEST_F(PathFlowTest, MorePointsThanPromisedAreAFault) {
  EXPECT_FALSE(Give({0, {1, 2, 3}, 0, 2, true}));
}

TEST_F(PathFlowTest, FewerPointsThanPromisedAreAFault) {
  EXPECT_FALSE(Give({0, {1, 2}, 0, 3, true}));
}

TEST_F(PathFlowTest, AWildTotalIsAFault) {
  EXPECT_FALSE(Give({0, {1}, 0, std::numeric_limits<std::uint64_t>::max(), false}));
}

TEST_F(PathFlowTest, ATotalThatChangesIsAFault) {
  ASSERT_TRUE(Give({0, {1}, 0, 3, false}));
  EXPECT_FALSE(Give({1, {2}, 1, 4, false}));
}

TEST_F(PathFlowTest, ABatchThatIsTooLargeIsAFault) {
  EXPECT_FALSE(Give({0, std::vector<double>(8193, 1.0), 0, 20'000, false}));
  EXPECT_EQ(intake_.TakeContent().size(), 0);
}

// The reader has no limit (it would stop the receive thread), so the intake has.
TEST_F(PathFlowTest, AFloodBeyondTheWindowIsRefusedAndDropped) {
  const auto flood = [this](std::uint64_t first, std::uint64_t end) {
    for (std::uint64_t i = first; i < end; ++i) Write({i, {1}, i, 1'000'000, false});
    EXPECT_TRUE(writer_.WaitForAcknowledgements(std::chrono::seconds(5)));
  };
  flood(0, 200);
  const auto refused = intake_.Poll();
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kFault);
  EXPECT_THAT(refused.error().message,
              testing::HasSubstr("exceeds the granted credit, batches below 32"));
  EXPECT_EQ(intake_.TakeContent().size(), 0);
  EXPECT_TRUE(Eventually([this] {
    credit_.Poll();
    return Grant().cancelled;
  })) << "the sorter knows that no more is wanted";
  flood(200, 400);
  EXPECT_FALSE(intake_.Poll().value());
  EXPECT_EQ(intake_.reader().Take([](const intaglio_PathBatch&) {}), 0)
      << "nothing is kept";
}

TEST_F(PathFlowTest, AllThatWasGrantedMayComeAtOnceAndMoreWhenItWasTaken) {
  for (std::uint64_t i = 0; i < 32; ++i) Write({i, {1}, i, 64, false});
  EXPECT_TRUE(writer_.WaitForAcknowledgements(std::chrono::seconds(5)));
  ASSERT_TRUE(intake_.Poll());
  for (std::uint64_t i = 32; i < 64; ++i) Write({i, {1}, i, 64, i == 63});
  EXPECT_TRUE(writer_.WaitForAcknowledgements(std::chrono::seconds(5)));
  ASSERT_TRUE(intake_.Poll().value());
  EXPECT_EQ(intake_.TakeContent().size(), 64);
  EXPECT_FALSE(intake_.Poll().value()) << "it is there once";
}

TEST_F(PathFlowTest, ACoordinateThatIsNoNumberIsAFault) {
  EXPECT_FALSE(Give({0, {std::nan("")}, 0, 1, true}));
}

}  // namespace
}  // namespace intaglio::host
