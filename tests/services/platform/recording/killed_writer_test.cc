#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <filesystem>
#include <random>
#include <thread>

#include "services/platform/recording/mcap_reader.h"
#include "services/platform/recording/message_cursor.h"
#include "tests/services/platform/bus/child_program.h"
#include "tests/services/platform/recording/recorded.h"
#include "tests/test_folder.h"

namespace intaglio::recording {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

std::uint64_t WallNow() {
  return static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch() /
                                    1ns);
}

// The instants are random, the file is read as the kill left it. The writer's chunks are
// 20 ms old at most here; a second is what a loaded host may add.
TEST(KilledWriter, EveryFileIsReadableAndLacksLessThanASecond) {
  const fs::path folder = test::FreshFolder();
  constexpr int kKills = 200;
  std::mt19937 random(2026);
  std::uint64_t longest_ns = 0;
  for (int kill = 0; kill < kKills; ++kill) {
    const fs::path file = folder / "killed.mcap";
    fs::remove(file);
    test::ChildProgram writer(INTAGLIO_KILLED_WRITER, {file.string()});
    ASSERT_TRUE(
        test::Eventually([&] { return fs::exists(file) && fs::file_size(file) > 1000; }));
    std::this_thread::sleep_for(std::chrono::microseconds(random() % 40'000));
    const std::uint64_t killed_ns = WallNow();
    writer.Kill();
    const auto reader = McapReader::Open(file);
    ASSERT_TRUE(reader) << reader.error().message;
    EXPECT_FALSE(reader->contents().complete);
    EXPECT_TRUE(reader->contents().damages.empty());
    const auto messages = MessagesOf(*reader);
    ASSERT_FALSE(messages.empty());
    // What was kept of a topic has no gap.
    std::map<std::uint16_t, std::uint64_t> counts;
    for (const Recorded& message : messages) ++counts[message.channel_id];
    EXPECT_EQ(counts, (std::map<std::uint16_t, std::uint64_t>(
                          reader->contents().statistics.message_counts.begin(),
                          reader->contents().statistics.message_counts.end())));
    const std::uint64_t last_ns = messages.back().log_time_ns;
    const std::uint64_t lost_ns = killed_ns > last_ns ? killed_ns - last_ns : 0;
    EXPECT_LT(lost_ns, 1'000'000'000u);
    longest_ns = std::max(longest_ns, lost_ns);
  }
  RecordProperty("longest_loss_us", std::to_string(longest_ns / 1000));
}

}  // namespace
}  // namespace intaglio::recording
