#include "services/platform/recording/retained_state.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/services/platform/recording/status_samples.h"

namespace intaglio::recording {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::uint32_t kValues = 3, kEnds = 4;

class RetainedStateTest : public ::testing::Test {
 protected:
  void Learn(RetainedState& state, int depth = 1) {
    EXPECT_TRUE(state.Learn(kValues, StatusStream(SampleKind::kValue, depth),
                            {"m::Status", kStatusIdl, kStatusKeys}));
    EXPECT_TRUE(state.Learn(kEnds, StatusStream(SampleKind::kDisposed, depth),
                            {"m::Status_key", kStatusKeyIdl, kStatusKeys}));
  }
  void Send(RetainedState& state, std::uint32_t id, std::uint32_t filling = 0) {
    ++count_;
    state.Receive(kValues, count_, 10 * count_, count_, StatusOf(id, count_, filling));
  }
  static std::vector<std::uint32_t> SequencesIn(const RetainedState& state) {
    std::vector<std::uint32_t> sequences;
    for (const RetainedSample* sample : state.Samples())
      sequences.push_back(sample->sequence);
    return sequences;
  }
  std::uint32_t count_ = 0;
};

TEST_F(RetainedStateTest, KeepsTheNewestOfEachInstanceInOrder) {
  RetainedState state;
  Learn(state);
  for (const std::uint32_t id : {7u, 8u, 7u, 9u, 8u}) Send(state, id);
  EXPECT_THAT(SequencesIn(state), ElementsAre(3, 4, 5));
  EXPECT_EQ(state.Samples()[0]->payload, StatusOf(7, 3));
  EXPECT_EQ(state.Samples()[0]->log_time_ns, 30u);
  EXPECT_EQ(state.Samples()[0]->publish_time_ns, 3u);
}

TEST_F(RetainedStateTest, KeepsAsManyAsTheWriterDoes) {
  RetainedState state;
  Learn(state, 2);
  for (const std::uint32_t id : {7u, 7u, 8u, 7u}) Send(state, id);
  EXPECT_THAT(SequencesIn(state), ElementsAre(2, 3, 4));
}

TEST_F(RetainedStateTest, ForgetsWhatHasEnded) {
  RetainedState state;
  Learn(state);
  for (const std::uint32_t id : {7u, 8u}) Send(state, id);
  state.Receive(kEnds, 0, 0, 0, StatusKeyOf(7));
  state.Receive(kEnds, 0, 0, 0, StatusKeyOf(70));
  EXPECT_THAT(SequencesIn(state), ElementsAre(2));
  state.Receive(kEnds, 0, 0, 0, StatusKeyOf(8));
  EXPECT_TRUE(state.empty());
  EXPECT_EQ(state.bytes(), 0u);
}

TEST_F(RetainedStateTest, BeyondItsLimitTheLatestChangedStay) {
  RetainedState state(10'000);
  Learn(state);
  for (std::uint32_t i = 0; i < 100; ++i) Send(state, i % 20, 1000);
  const auto kept = SequencesIn(state);
  EXPECT_LE(state.bytes(), 10'000u);
  ASSERT_GE(kept.size(), 5u);
  EXPECT_EQ(kept.back(), 100u);
  EXPECT_EQ(kept.front(), 101 - kept.size());
  EXPECT_GT(state.forgotten_count(), 0u);
}

TEST_F(RetainedStateTest, WhatDoesNotFitAlonePushesNobodyOut) {
  RetainedState state(10'000);
  Learn(state);
  Send(state, 7);
  Send(state, 8);
  Send(state, 7, 20'000);  // and what it replaces is not the state any more
  EXPECT_THAT(SequencesIn(state), ElementsAre(2));
  EXPECT_EQ(state.forgotten_count(), 1u);
}

TEST_F(RetainedStateTest, PassesOverWhatItCannotRead) {
  RetainedState state;
  EXPECT_FALSE(state.Learn(1, StatusStream(), {"m::Status", "", kStatusKeys}));
  EXPECT_FALSE(state.Learn(1, StatusStream(), {"m::Status", kStatusIdl, ""}));
  EXPECT_FALSE(state.Learn(1, StatusStream(), {"m::Status", "module {", kStatusKeys}));
  state.Receive(1, 0, 0, 0, StatusOf(7, 1));
  Learn(state);
  state.Receive(kValues, 0, 0, 0, Bytes(6));
  EXPECT_THAT(SequencesIn(state), IsEmpty());
}

TEST_F(RetainedStateTest, PlacesAreKeptApart) {
  RetainedState state;
  Stream elsewhere = StatusStream();
  Learn(state);
  elsewhere.partition = "cell-2";
  ASSERT_TRUE(state.Learn(5, elsewhere, {"m::Status", kStatusIdl, kStatusKeys}));
  Stream without_key = StatusStream();
  without_key.topic = "Shop";
  without_key.keyed = false;
  ASSERT_TRUE(state.Learn(6, without_key, {}));
  Send(state, 7);
  for (const std::uint32_t number : {5u, 6u, 6u})
    state.Receive(number, 10 * number, 0, 0, StatusOf(7, 1));
  EXPECT_THAT(SequencesIn(state), ElementsAre(1, 50, 60));
}

}  // namespace
}  // namespace intaglio::recording
