#include "services/platform/bus/topic_tap.h"

#include <dds/dds.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <map>
#include <optional>
#include <set>

#include "services/platform/bus/samples.h"
#include "services/platform/bus/topics.h"
#include "tests/services/platform/bus/child_program.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A tap with one thread for both of its halves, and the samples that it received.
class Listener {
 public:
  explicit Listener(bus::TopicTap::Filter filter = [](const auto&) { return true; })
      : bus(test::PrivateBusOptions()),
        tap(bus, std::move(filter),
            [this](const std::string& topic, const std::string& why) {
              complaints.push_back(topic + ": " + why);
            }) {}

  bool Until(const std::function<bool()>& condition) {
    return test::Eventually([&] {
      tap.Discover(1ms);
      tap.Take(1ms, [this](bus::TapSample&& sample) {
        received.push_back(std::move(sample));
      });
      return condition();
    });
  }
  std::map<std::string, bus::TapChannel> channels() const {
    std::map<std::string, bus::TapChannel> all;
    for (std::uint32_t i = 0; i < tap.channel_count(); ++i) {
      all[tap.channel(i).topic] = tap.channel(i);
    }
    return all;
  }

  bus::Bus bus;
  std::vector<std::string> complaints;
  bus::TopicTap tap;
  std::vector<bus::TapSample> received;
};

test::ChildProgram TapPeer(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), test::PrivateTag());
  return {INTAGLIO_TAP_PEER, std::move(arguments)};
}

std::string TextAt(std::span<const std::byte> bytes, std::size_t offset) {
  std::uint32_t length = 0;
  if (bytes.size() < offset + 4) return {};
  std::memcpy(&length, bytes.data() + offset, 4);
  if (length == 0 || bytes.size() < offset + 4 + length) return {};
  return {reinterpret_cast<const char*>(bytes.data()) + offset + 4, length - 1};
}

// The reader keeps all: every sample of a writer that keeps one sample is received.
TEST(TopicTap, ReceivesEverySampleAndTheEndOfTheInstance) {
  constexpr std::size_t kCount = 200;
  // Longer than the 16 bytes that the library has for keys that it takes for short ones.
  const std::string kName = "sorter-of-a-host-with-a-long-name-4711";
  Listener listener;
  const auto peer = TapPeer({"instance", kName, std::to_string(kCount)});
  ASSERT_TRUE(listener.Until([&] {
    return !listener.received.empty() &&
           listener.received.back().kind() == bus::TapKind::kDisposed;
  }));
  const bus::TapChannel& channel = listener.tap.channel(0);
  EXPECT_EQ(channel.topic, "ServiceHealth");
  EXPECT_EQ(channel.type, "intaglio::ServiceHealth");
  EXPECT_TRUE(channel.keyed);
  EXPECT_EQ(channel.qos.at("reliability"), "reliable");
  EXPECT_EQ(channel.qos.at("durability"), "transient_local");
  const bus::TapSample& value = listener.received.front();
  const bus::TapSample& end = listener.received.back();
  // The writer itself may have replaced a sample before the reader was known everywhere.
  EXPECT_GT(listener.received.size(), kCount * 9 / 10);
  std::int64_t last = -1;
  for (const bus::TapSample& sample : listener.received) {
    // The clocks of two processors may differ by a little.
    EXPECT_GE(sample.received_ns() + 10'000'000, sample.source_ns());
    if (&sample == &end) break;
    EXPECT_EQ(sample.kind(), bus::TapKind::kValue);
    std::int64_t number = -1;
    std::memcpy(&number, sample.bytes().data() + sample.bytes().size() - 8, 8);
    EXPECT_GT(number, last);
    last = number;
  }
  EXPECT_EQ(last, std::int64_t{kCount} - 1);
  EXPECT_EQ(TextAt(value.bytes(), 4), kName);
  EXPECT_EQ(end.kind(), bus::TapKind::kDisposed);
  EXPECT_EQ(TextAt(end.bytes(), 4), kName);
  EXPECT_LT(end.bytes().size(), value.bytes().size());
  EXPECT_THAT(listener.complaints, IsEmpty());
}

TEST(TopicTap, CountsTheWritersThatAreThere) {
  Listener listener;
  const std::string topic = bus::kServiceHealth.name;
  std::optional<bus::Writer<intaglio_ServiceHealth>> own;
  EXPECT_EQ(listener.tap.WriterCount(topic), std::nullopt) << "none has come yet";
  {
    const auto peer = TapPeer({"instance", "s", "1000000"});
    EXPECT_TRUE(listener.Until([&] { return listener.tap.WriterCount(topic) == 1u; }));
    own.emplace(listener.bus, bus::kServiceHealth);
    EXPECT_TRUE(listener.Until([&] { return listener.tap.WriterCount(topic) == 2u; }));
  }
  EXPECT_TRUE(listener.Until([&] { return listener.tap.WriterCount(topic) == 1u; }));
}

TEST(TopicTap, ReportsThatTheWriterIsGone) {
  Listener listener;
  auto peer = TapPeer({"topics", "a"});
  ASSERT_TRUE(listener.Until([&] { return listener.channels().contains("Interlock"); }));
  peer.Kill();
  EXPECT_TRUE(listener.Until([&] {
    return std::any_of(listener.received.begin(), listener.received.end(),
                       [&](const auto& s) {
                         return s.kind() != bus::TapKind::kValue &&
                                listener.tap.channel(s.channel()).topic == "Interlock";
                       });
  }));
}

TEST(TopicTap, ReportsEveryTopicOfTheProduct) {
  Listener listener;
  std::map<std::string, const dds_topic_descriptor*> descriptors;
  bus::ForEachTopic(
      [&](const auto& topic) { descriptors[topic.name] = topic.descriptor; });
  const auto peer = TapPeer({"topics", "els-7"});
  ASSERT_TRUE(
      listener.Until([&] { return listener.tap.channel_count() == descriptors.size(); }));
  auto channels = listener.channels();
  for (const auto& [topic, channel] : channels) {
    EXPECT_THAT(channel.idl, HasSubstr("struct " + channel.type.substr(10))) << topic;
    EXPECT_EQ(channel.key_idl.empty(), !channel.keyed) << topic;
    const auto recipe = bus::RecipeDescriptor::Parse(channel.recipe);
    ASSERT_TRUE(recipe) << recipe.error().message;
    const dds_topic_descriptor& made = recipe->descriptor();
    const dds_topic_descriptor& compiled = *descriptors[topic];
    EXPECT_STREQ(made.m_typename, compiled.m_typename);
    EXPECT_EQ(made.m_size, compiled.m_size);
    EXPECT_EQ(made.m_nkeys, compiled.m_nkeys);
    EXPECT_EQ(made.m_flagset, compiled.m_flagset) << topic;
    EXPECT_EQ(made.type_information.sz, compiled.type_information.sz);
  }
  EXPECT_EQ(channels["MotionState"].partition, "els-7");
  EXPECT_EQ(channels["JobStatus"].partition, "");
  EXPECT_EQ(channels["PathBatch"].domain, bus::DomainKind::kBulk);
  EXPECT_THAT(listener.complaints, IsEmpty());
}

TEST(TopicTap, WritesTheTypeInIdl) {
  Listener listener([](const auto& channel) { return channel.topic == "TaskStatus"; });
  const auto peer = TapPeer({"topics", "a"});
  ASSERT_TRUE(listener.Until([&] { return listener.tap.channel_count() == 1; }));
  EXPECT_EQ(listener.tap.channel(0).idl, R"(module intaglio {
  enum Stage {
    STAGE_DISCRETIZE,
    STAGE_SORT,
    STAGE_ENGRAVE
  };
  enum TaskState {
    TASK_ACCEPTED,
    TASK_RUNNING,
    TASK_PAUSED,
    TASK_DONE,
    TASK_FAILED
  };
  enum ErrorCode {
    ERROR_NONE,
    ERROR_INVALID_VALUE,
    ERROR_MISSING,
    ERROR_NOT_FOUND,
    ERROR_UNREADABLE,
    ERROR_UNSUPPORTED,
    ERROR_OUTSIDE_BLOCK,
    ERROR_TOO_LARGE,
    ERROR_IO,
    ERROR_LINK_LOST,
    ERROR_TIMED_OUT,
    ERROR_REFUSED,
    ERROR_FAULT,
    ERROR_CANCELLED
  };
  enum PauseReason {
    PAUSE_NONE,
    PAUSE_OPERATOR,
    PAUSE_NOT_ARMED,
    PAUSE_FAULT,
    PAUSE_EMERGENCY_STOP,
    PAUSE_INTERLOCK,
    PAUSE_MACHINE_CHANGED,
    PAUSE_ABSENCE,
    PAUSE_CLOSED,
    PAUSE_UNCERTAIN_POINTS,
    PAUSE_LINE_LOST,
    PAUSE_SYNCHRONIZER_LOST,
    PAUSE_RESTART
  };
  @final
  struct PointCounts {
    uint64 planned;
    uint64 made;
    uint64 missed;
    uint64 skipped;
    uint64 uncertain;
    uint64 to_come;
    uint64 armed;
  };
  @final
  struct TaskStatus {
    @key string job_uid;
    @key intaglio::Stage stage;
    @key string worker;
    @key uint32 part;
    uint32 part_count;
    uint32 attempt;
    uint32 part_attempt;
    intaglio::TaskState state;
    uint64 done_count;
    uint64 total_count;
    double elapsed_s;
    uint64 estimate_ticks;
    intaglio::ErrorCode error_code;
    intaglio::PauseReason pause_reason;
    string message;
    intaglio::PointCounts counts;
    string alarm;
    sequence<octet> outcome;
  };
};
)");
  EXPECT_EQ(listener.tap.channel(0).key_idl, R"(module intaglio {
  enum Stage {
    STAGE_DISCRETIZE,
    STAGE_SORT,
    STAGE_ENGRAVE
  };
  @final
  struct TaskStatus_key {
    @key string job_uid;
    @key intaglio::Stage stage;
    @key string worker;
    @key uint32 part;
  };
};
)");
}

TEST(TopicTap, FilterKeepsReadersFromBeingMade) {
  Listener listener([](const auto& channel) { return channel.topic == "Alarm"; });
  const auto peer = TapPeer({"topics", "a"});
  ASSERT_TRUE(listener.Until([&] { return listener.received.size() > 5; }));
  EXPECT_EQ(listener.tap.channel_count(), 1u);
}

TEST(TopicTap, CellsAreChannelsOfTheirOwn) {
  Listener listener([](const auto& channel) { return channel.topic == "Interlock"; });
  const auto peer = TapPeer({"topics", "a", "b"});
  ASSERT_TRUE(listener.Until([&] { return listener.tap.channel_count() == 2; }));
  const std::set<std::string> cells{listener.tap.channel(0).partition,
                                    listener.tap.channel(1).partition};
  EXPECT_EQ(cells, (std::set<std::string>{"a", "b"}));
}

TEST(TypeRecipe, DamagedOneIsRefusedByItsEntry) {
  bus::TypeRecipe recipe{{"library", "cyclonedds 0.10"}, {"name", "T"}};
  EXPECT_THAT(bus::RecipeDescriptor::Parse(recipe).error().message, HasSubstr("size"));
  recipe["library"] = "other 1.0";
  EXPECT_EQ(bus::RecipeDescriptor::Parse(recipe).error().code, ErrorCode::kUnsupported);
}

}  // namespace
}  // namespace intaglio
