#include "services/replayer/selection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "services/platform/bus/topics.h"
#include "tests/services/replayer/golden.h"

namespace intaglio::replayer {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::Key;
using ::testing::Not;

std::set<std::string> NamesOf(const Selection& selection) {
  std::set<std::string> names;
  for (const auto& [id, channel] : selection.channels) names.insert(channel.name);
  return names;
}

std::set<std::string> Played(const SelectionOptions& options) {
  const auto reader = Golden("pyramid.mcap");
  const auto selection = Select(reader.contents(), options);
  EXPECT_TRUE(selection) << selection.error().message;
  return NamesOf(*selection);
}

// A person who adds a topic has to consider its effect when it is played.
TEST(Selection, EveryTopicOfTheProductIsWeighed) {
  const std::set<std::string> shown = {"Alarm", "PulseEventBatch"};
  bus::ForEachTopic([&](const auto& topic) {
    EXPECT_EQ(WeightOf(topic.name) == Weight::kShown, shown.contains(topic.name))
        << topic.name;
  });
}

TEST(Selection, CommandsAreNeverPlayedUnlessAskedFor) {
  for (const char* topic : {"Permission", "EmergencyStop", "JobCommand", "JobSubmission",
                            "MotionSegmentBatch", "DiscretizeTask", "SortTask",
                            "EngraveTask", "ManualCommand", "CellMove"}) {
    EXPECT_EQ(WeightOf(topic), Weight::kCommand) << topic;
    EXPECT_THAT(Played({}), Not(Contains(topic)));
  }
  EXPECT_THAT(Played({.with_commands = true}), Contains("Permission"));
  EXPECT_THAT(Played({}), Contains("MotionState"));
}

TEST(Selection, WhereServicesLiveNothingIsPlayedThatTheyBelieve) {
  EXPECT_EQ(Played({.services_live = true}), (std::set<std::string>{"PulseEventBatch"}));
  EXPECT_THAT(Played({.with_commands = true, .services_live = true}),
              Contains("MotionState"));
}

TEST(Selection, FiltersAreOfTheRecordedNames) {
  EXPECT_EQ(Played({.topics = {{"Task*", "Lamp*"}, {"LampSync"}}}),
            (std::set<std::string>{"TaskStatus"}));
}

TEST(Selection, ARenamedCommandIsNoneAndTheOtherWayRound) {
  EXPECT_THAT(Played({.renames = {{"Permission", "Old/Permission"}}}),
              Contains("Old/Permission"));
  EXPECT_THAT(Played({.renames = {{"PulseEventBatch", "Permission"}}}),
              Not(Contains("Permission")));
}

TEST(Selection, RenameOfATopicThatIsNotThereIsAnError) {
  const auto reader = Golden("pyramid.mcap");
  const auto selection = Select(reader.contents(), {.renames = {{"Nothing", "A"}}});
  ASSERT_FALSE(selection);
  EXPECT_THAT(selection.error().message, HasSubstr("Nothing"));
}

TEST(Selection, TwoTypesUnderOneNameAreAnError) {
  const auto reader = Golden("pyramid.mcap");
  const std::map<std::string, std::string> renames = {{"LampSync", "MotionState"}};
  const auto both = Select(reader.contents(), {.renames = renames});
  ASSERT_FALSE(both);
  EXPECT_EQ(both.error().code, ErrorCode::kInvalidValue);
  EXPECT_THAT(both.error().message, HasSubstr("intaglio::LampSync"));
  EXPECT_TRUE(
      Select(reader.contents(), {.topics = {{}, {"MotionState"}}, .renames = renames}));
}

TEST(Selection, ReportsWhyATopicIsLeftOut) {
  const auto reader = Golden("pyramid.mcap");
  const auto selection = Select(reader.contents(), {.credit_is_given = true});
  ASSERT_TRUE(selection);
  EXPECT_THAT(selection->left_out.at("Permission"), HasSubstr("--with-commands"));
  EXPECT_THAT(selection->left_out, Contains(Key("Credit")));
  EXPECT_TRUE(selection->believed);
}

}  // namespace
}  // namespace intaglio::replayer
