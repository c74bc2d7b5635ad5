#include "services/replayer/recorded_stops.h"

#include <gtest/gtest.h>

namespace intaglio::replayer {
namespace {

using recording::Value;
using recording::ValueList;
using recording::ValueObject;

ValueObject Sample(const std::string& cell, bool pressed, std::uint64_t number) {
  return {{"cell", Value{cell}},
          {"pressed", Value{pressed}},
          {"source", Value{std::string("ann")}},
          {"number", Value{number}}};
}

TEST(RecordedStops, AResetHasThePressesThatItNames) {
  RecordedStops stops("els-03");
  ValueObject reset = Sample("els-03", false, 7);
  reset.push_back(
      {"released",
       Value{ValueList{Value{ValueObject{{"source", Value{std::string("bob")}},
                                         {"number", Value{std::uint64_t{3}}}}}}}});
  const auto read = stops.Read(Value{reset});
  ASSERT_TRUE(read);
  EXPECT_TRUE(read->ours);
  EXPECT_FALSE(read->stop.pressed);
  EXPECT_EQ(read->stop.source, "ann");
  EXPECT_EQ(read->stop.number, 7u);
  EXPECT_EQ(read->stop.released, (std::vector<RecordedPress>{{"bob", 3}}));
  reset.back().value = Value{std::uint64_t{3}};
  EXPECT_FALSE(stops.Read(Value{reset})) << "a list that is none";
}

TEST(RecordedStops, APressOfEveryMachineIsOurs) {
  RecordedStops stops("els-03");
  EXPECT_TRUE(stops.Read(Value{Sample("*", true, 1)})->ours);
  EXPECT_FALSE(stops.Read(Value{Sample("els-04", true, 1)})->ours);
}

// As recorded before resets named presses: every lower number, and no other.
TEST(RecordedStops, AResetOfAnOldRecordingReleasesTheLowerNumbers) {
  RecordedStops stops("els-03");
  const auto first = stops.Read(Value{Sample("els-03", true, 10)});
  const auto second = stops.Read(Value{Sample("els-03", true, 20)});
  ASSERT_TRUE(stops.Read(Value{Sample("els-04", true, 5)}));
  ASSERT_TRUE(first && second);
  EXPECT_NE(first->stop.source, second->stop.source);
  const auto low = stops.Read(Value{Sample("els-03", false, 20)});
  ASSERT_TRUE(low);
  EXPECT_EQ(low->stop.released, (std::vector<RecordedPress>{{first->stop.source, 10}}));
  const auto high = stops.Read(Value{Sample("els-03", false, 21)});
  ASSERT_TRUE(high);
  EXPECT_EQ(high->stop.released.size(), 2u);
}

TEST(RecordedStops, WhatIsNoEmergencyStopIsRefused) {
  RecordedStops stops("els-03");
  for (std::size_t left_out = 0; left_out < 4; ++left_out) {
    ValueObject sample = Sample("els-03", true, 1);
    sample.erase(sample.begin() + static_cast<std::ptrdiff_t>(left_out));
    EXPECT_FALSE(stops.Read(Value{sample})) << left_out;
  }
}

}  // namespace
}  // namespace intaglio::replayer
