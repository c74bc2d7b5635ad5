// The messages of a scene, one after the other, from messages made here.

#include "services/scene/scene_maker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "services/scene/message_schema.h"
#include "tests/services/scene/packed_cloud.h"

namespace intaglio::scene {
namespace {

using recording::Value;
using recording::ValueObject;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr std::uint64_t kMade = 0, kMissed = 1, kSkipped = 2, kUncertain = 3;

Value PathOf(const std::string& job, std::uint64_t first, std::size_t count,
             bool last = true) {
  std::vector<double> x, y(count, 2), z(count, 3);
  for (std::size_t i = 0; i < count; ++i) x.push_back(static_cast<double>(first + i));
  return {ValueObject{{"job_uid", {job}},
                      {"first_index", {first}},
                      {"last", {last}},
                      {"x_mm", {x}},
                      {"y_mm", {y}},
                      {"z_mm", {z}}}};
}

struct Pulse {
  std::uint64_t tick, point, outcome;
};

Value PulsesOf(const std::string& job, const std::vector<Pulse>& pulses) {
  std::vector<std::uint64_t> tick, point, outcome;
  for (const Pulse& pulse : pulses) {
    tick.push_back(pulse.tick);
    point.push_back(pulse.point);
    outcome.push_back(pulse.outcome);
  }
  return {ValueObject{
      {"job_uid", {job}}, {"tick", {tick}}, {"point", {point}}, {"outcome", {outcome}}}};
}

class SceneMakerTest : public ::testing::Test {
 protected:
  std::vector<CloudPoint> LastOf(const std::string& topic) const {
    foxglove::PointCloud cloud;
    const auto found = written_.find(topic);
    if (found == written_.end()) return {};
    EXPECT_TRUE(cloud.ParseFromString(found->second.back()));
    return PointsOfCloud(cloud);
  }
  std::size_t CountOf(const std::string& topic) const {
    const auto found = written_.find(topic);
    return found == written_.end() ? 0 : found->second.size();
  }
  void Path(const std::string& job, std::size_t count) {
    EXPECT_TRUE(maker_.Add("PathBatch", "", PathOf(job, 0, count), 1));
  }
  void Pulses(const std::string& job, const std::vector<Pulse>& pulses) {
    EXPECT_TRUE(maker_.Add("PulseEventBatch", "cell", PulsesOf(job, pulses), 2));
  }

  std::map<std::string, std::vector<std::string>> written_;  // by topic
  SceneMaker maker_{[this](const std::string& topic,
                           const google::protobuf::Message& message, std::uint64_t) {
    written_[topic].push_back(message.SerializeAsString());
    return Status();
  }};
};

TEST_F(SceneMakerTest, APlanIsDrawnWhenItIsWhole) {
  EXPECT_TRUE(maker_.Add("PathBatch", "", PathOf("7-ab", 0, 3, false), 1));
  EXPECT_EQ(CountOf("job-7/plan"), 0u);
  EXPECT_TRUE(maker_.Add("PathBatch", "", PathOf("7-ab", 3, 2), 1));
  EXPECT_THAT(LastOf("job-7/plan"), SizeIs(5));
  EXPECT_EQ(LastOf("job-7/plan")[4].place_mm, Vec3(4, 2, 3));
}

TEST_F(SceneMakerTest, WhatIsFiredHasTheColourOfItsOutcome) {
  Path("1-a", 5);
  Pulses("1-a",
         {{10, 0, kMade}, {11, 1, kMissed}, {12, 2, kSkipped}, {13, 3, kUncertain}});
  const auto made = LastOf("job-1/made");
  ASSERT_THAT(made, SizeIs(3));
  EXPECT_GT(made[0].blue, made[0].red) << "made";
  EXPECT_EQ(made[1].order, 1u);
  EXPECT_GT(made[1].green, made[1].blue) << "missed is orange";
  EXPECT_EQ(made[2].order, 3u);
  EXPECT_GT(made[2].red, 2 * made[2].green) << "uncertain is red";
  const auto plan = LastOf("job-1/plan");
  ASSERT_THAT(plan, SizeIs(2)) << "the skipped one may be made yet";
  EXPECT_EQ(plan[0].order, 2u);
  // By a person's consent the uncertain one is fired again.
  Pulses("1-a", {{20, 3, kMade}});
  ASSERT_THAT(LastOf("job-1/made"), SizeIs(3));
  EXPECT_EQ(LastOf("job-1/made")[2].tick, 20u);
  EXPECT_GT(LastOf("job-1/made")[2].blue, LastOf("job-1/made")[2].red);
}

TEST_F(SceneMakerTest, AlarmsAreALog) {
  const std::vector<std::pair<std::string, foxglove::Log::Level>> levels = {
      {"ALARM_NOTICE", foxglove::Log::INFO},
      {"ALARM_WARNING", foxglove::Log::WARNING},
      {"ALARM_FAULT", foxglove::Log::ERROR}};
  for (const auto& [severity, level] : levels) {
    const Value alarm{ValueObject{{"instance", {std::string("synchronizer-1")}},
                                  {"severity", {severity}},
                                  {"message", {std::string("no progress in 41 s")}}}};
    ASSERT_TRUE(maker_.Add("Alarm", "cell", alarm, 2'000'000'003));
    foxglove::Log log;
    ASSERT_TRUE(log.ParseFromString(written_.at("alarms").back()));
    EXPECT_EQ(log.level(), level);
    EXPECT_EQ(log.message(), "no progress in 41 s");
    EXPECT_EQ(log.name(), "synchronizer-1");
    EXPECT_EQ(log.timestamp().seconds(), 2);
    EXPECT_EQ(log.timestamp().nanos(), 3);
  }
}

// A cloud of all that was made with each report would grow with the square of the points.
TEST_F(SceneMakerTest, TheWholeIsDrawnTwentyTimesAtMost) {
  Path("1-a", 2000);
  for (std::uint64_t i = 0; i < 2000; i += 10) {
    std::vector<Pulse> pulses;
    for (std::uint64_t k = 0; k < 10; ++k) pulses.push_back({i + k, i + k, kMade});
    Pulses("1-a", pulses);
  }
  EXPECT_TRUE(maker_.Finish());
  EXPECT_EQ(CountOf("job-1/new"), 200u);
  EXPECT_EQ(CountOf("job-1/made"), 20u);
  EXPECT_THAT(LastOf("job-1/made"), SizeIs(2000));
}

TEST_F(SceneMakerTest, TheRestIsDrawnAtTheEnd) {
  Path("1-a", 100);
  Pulses("1-a", {{1, 0, kMade}});
  EXPECT_EQ(CountOf("job-1/made"), 0u);
  EXPECT_TRUE(maker_.Finish());
  EXPECT_THAT(LastOf("job-1/made"), SizeIs(1));
  EXPECT_TRUE(maker_.Finish());
  EXPECT_EQ(CountOf("job-1/made"), 1u) << "once";
}

TEST_F(SceneMakerTest, AnotherFileBeginsWithTheWhole) {
  Path("1-a", 100);
  Pulses("1-a", {{1, 0, kMade}, {2, 1, kMade}});
  written_.clear();
  maker_.BeginAnew();
  Pulses("1-a", {{3, 2, kMade}});
  EXPECT_EQ(CountOf("job-1/frame"), 1u);
  EXPECT_THAT(LastOf("job-1/plan"), SizeIs(98));
  EXPECT_THAT(LastOf("job-1/made"), SizeIs(2));
  EXPECT_THAT(LastOf("job-1/new"), SizeIs(1));
}

TEST_F(SceneMakerTest, JobsLieBesideEachOther) {
  Path("1-a", 2);
  Path("2-b", 2);
  foxglove::FrameTransform first, second;
  EXPECT_TRUE(first.ParseFromString(written_["job-1/frame"].back()));
  EXPECT_TRUE(second.ParseFromString(written_["job-2/frame"].back()));
  EXPECT_EQ(first.translation().x(), 0);
  EXPECT_GT(second.translation().x(), 50) << "the width of a usual block";
}

TEST_F(SceneMakerTest, OldJobsAreForgotten) {
  for (int job = 1; job <= 17; ++job) Path(std::to_string(job) + "-a", 10);
  const std::uint64_t drawn = maker_.drawn_count();
  EXPECT_EQ(drawn, 170u);
  Pulses("1-a", {{1, 0, kMade}});
  EXPECT_EQ(CountOf("job-1/new"), 0u) << "its places are not known any more";
  Pulses("2-a", {{1, 0, kMade}});
  EXPECT_EQ(CountOf("job-2/new"), 0u) << "job 1 came back, so job 2 was the oldest";
  Pulses("17-a", {{1, 0, kMade}});
  EXPECT_EQ(CountOf("job-17/new"), 1u);
}

TEST_F(SceneMakerTest, DamagedMessagesAreRefusedOrLeftOut) {
  const auto far = maker_.Add("PathBatch", "", PathOf("1-a", UINT64_MAX - 1, 2), 1);
  ASSERT_FALSE(far);
  EXPECT_EQ(far.error().code, ErrorCode::kUnreadable);
  EXPECT_THAT(far.error().message, HasSubstr("18446744073709551614"));
  EXPECT_FALSE(maker_.Add("PathBatch", "", PathOf("3-a", 100'000'000, 1), 1))
      << "2 GB for one point";
  EXPECT_TRUE(maker_.Add("PathBatch", "", PathOf("4-a", 300'000, 1), 1))
      << "nine of ten batches were left out";
  Path("2-a", 2);
  Pulses("2-a", {{1, 99, kMade}, {2, 0, 77}});
  EXPECT_EQ(CountOf("job-2/new"), 0u);
  EXPECT_TRUE(maker_.Add("PulseEventBatch", "", Value{}, 3)) << "of no job";
}

}  // namespace
}  // namespace intaglio::scene
