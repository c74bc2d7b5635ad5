#include "services/replayer/retained.h"

#include <gtest/gtest.h>

#include <cstring>
#include <map>

#include "tests/services/replayer/golden.h"

namespace intaglio::replayer {
namespace {

Selection Everything(const recording::McapReader& reader) {
  return *Select(reader.contents(), {.with_commands = true});
}

/// The oracle: ServiceHealth by its first member, read by hand from the bytes.
std::string InstanceOf(recording::ByteView payload) {
  std::uint32_t length = 0;
  std::memcpy(&length, payload.data() + 4, sizeof length);
  return {reinterpret_cast<const char*>(payload.data()) + 8, length - 1};
}

TEST(Retained, GivesTheNewestOfEachInstanceThatLives) {
  const auto reader = Golden("pyramid.mcap");
  const auto& statistics = reader.contents().statistics;
  const std::uint64_t middle =
      statistics.start_ns + (statistics.end_ns - statistics.start_ns) / 2;
  const Selection selection = Everything(reader);
  std::map<std::string, std::uint64_t> newest;
  recording::MessageCursor cursor(reader, {.to_ns = middle, .channels = {}});
  for (auto next = cursor.Next(); next && *next; next = cursor.Next()) {
    const auto& message = **next;
    const auto& stream = selection.channels.at(message.channel_id).stream;
    if (stream.topic != "ServiceHealth") continue;
    if (stream.kind == recording::SampleKind::kValue) {
      newest[InstanceOf(message.payload)] = message.log_time_ns;
    } else {
      newest.erase(InstanceOf(message.payload));
    }
  }
  ASSERT_GE(newest.size(), 5u);  // the services of the session
  std::map<std::string, std::uint64_t> restored;
  Retained retained(reader, selection);
  std::uint64_t last = 0;
  for (const recording::RetainedSample& message : retained.Before(middle)) {
    EXPECT_LT(message.log_time_ns, middle);
    EXPECT_GE(message.log_time_ns, last);
    last = message.log_time_ns;
    const auto& stream =
        selection.channels.at(static_cast<std::uint16_t>(message.stream)).stream;
    if (stream.topic == "ServiceHealth")
      restored[InstanceOf(message.payload)] = message.log_time_ns;
  }
  EXPECT_EQ(restored, newest);
  EXPECT_TRUE(retained.complaints().empty());
}

TEST(Retained, NothingIsKeptOfVolatileTopicsAndOfWhatHasEnded) {
  const auto reader = Golden("pyramid.mcap");
  const Selection selection = Everything(reader);
  Retained retained(reader, selection);
  for (const recording::RetainedSample& message : retained.Before(~0ull)) {
    const auto& stream =
        selection.channels.at(static_cast<std::uint16_t>(message.stream)).stream;
    EXPECT_EQ(stream.qos.at("durability"), "transient_local");
    // All services of the session ended before its recorder.
    EXPECT_NE(stream.topic, "Permission");
    EXPECT_NE(stream.topic, "Interlock");
  }
}

TEST(Retained, NothingIsThereAtTheBeginning) {
  const auto reader = Golden("pyramid.mcap");
  const Selection selection = Everything(reader);
  EXPECT_TRUE(
      Retained(reader, selection).Before(reader.contents().statistics.start_ns).empty());
}

}  // namespace
}  // namespace intaglio::replayer
