// A recorder with --scene: viewers find messages of theirs in the file, and our own
// programs what was in it without.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <filesystem>
#include <numeric>

#include "proto/foxglove.pb.h"
#include "services/platform/bus/samples.h"
#include "services/platform/bus/topics.h"
#include "services/platform/recording/conventions.h"
#include "services/platform/recording/mcap_reader.h"
#include "tests/services/platform/bus/child_program.h"
#include "tests/services/platform/bus/private_bus.h"
#include "tests/services/platform/recording/recorded.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using recording::McapReader;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::size_t kPoints = 40;

class RecorderScene : public ::testing::Test {
 protected:
  static void WritePath(bus::Writer<intaglio_PathBatch>& writer) {
    const std::vector<double> x(kPoints, 1), y(kPoints, 2), z(kPoints, 3);
    const std::vector<std::uint32_t> source(kPoints, 0);
    const std::string job = "5-a";
    intaglio_PathBatch path{};
    path.job_uid = bus::Borrow(job);
    path.total_count = kPoints;
    path.last = true;
    bus::Borrow(path.x_mm, x);
    bus::Borrow(path.y_mm, y);
    bus::Borrow(path.z_mm, z);
    bus::Borrow(path.source, source);
    ASSERT_TRUE(writer.Write(path));
  }
  static void WritePulses(bus::Writer<intaglio_PulseEventBatch>& writer) {
    std::vector<std::uint64_t> tick(kPoints);
    std::vector<std::uint32_t> point(kPoints);
    std::iota(tick.begin(), tick.end(), 100);
    std::iota(point.begin(), point.end(), 0);
    const std::vector<std::uint8_t> made(kPoints, intaglio_PULSE_MADE),
        reason(kPoints, 0);
    const std::string job = "5-a";
    intaglio_PulseEventBatch batch{};
    batch.job_uid = bus::Borrow(job);
    bus::Borrow(batch.tick, tick);
    bus::Borrow(batch.point, point);
    bus::Borrow(batch.outcome, made);
    bus::Borrow(batch.reason, reason);
    ASSERT_TRUE(writer.Write(batch));
  }
  std::vector<recording::Recorded> MessagesOf(const std::string& topic) const {
    const auto reader = McapReader::Open(file_);
    if (!reader) return {};
    recording::MessageQuery query;
    query.channels.emplace();
    for (const auto& [id, channel] : reader->contents().channels)
      if (channel.topic == topic) query.channels->insert(id);
    return recording::MessagesOf(*reader, query);
  }

  fs::path folder_ = test::FreshFolder(), file_ = folder_ / "s.mcap";
};

TEST_F(RecorderScene, IsInTheFileBesideTheMessages) {
  test::ChildProgram recorder(INTAGLIO_BIN_DIR "/intaglio-recorder",
                              {"--tag", test::PrivateTag(), "--out", file_.string(),
                               "--log-file", (folder_ / "log").string(), "--scene"});
  bus::Bus bus(test::PrivateBusOptions("els-03"));
  bus::Writer<intaglio_PathBatch> path(bus, bus::kPathBatch);
  bus::Writer<intaglio_PulseEventBatch> pulses(bus, bus::kPulseEventBatch);
  ASSERT_TRUE(test::Eventually(
      [&] {
        if (MessagesOf("/job-5/plan").empty()) WritePath(path);
        return !MessagesOf("/job-5/plan").empty();
      },
      20s));
  ASSERT_TRUE(test::Eventually(
      [&] {
        if (MessagesOf("/job-5/new").empty()) WritePulses(pulses);
        return !MessagesOf("/job-5/new").empty();
      },
      20s));
  recorder.Signal(SIGTERM);
  EXPECT_EQ(recorder.ExitCode(), 0);
  const auto made = MessagesOf("/job-5/made");
  ASSERT_FALSE(made.empty());
  foxglove::PointCloud cloud;
  ASSERT_TRUE(cloud.ParseFromArray(made.back().payload.data(),
                                   static_cast<int>(made.back().payload.size())));
  EXPECT_EQ(cloud.data().size(), kPoints * cloud.point_stride());

  const auto reader = McapReader::Open(file_).value();
  EXPECT_TRUE(reader.contents().complete);
  EXPECT_TRUE(reader.contents().damages.empty());
  for (const auto& [id, channel] : reader.contents().channels)
    EXPECT_EQ(recording::StreamOf(channel).has_value(), channel.topic.front() != '/')
        << channel.topic << ": what viewers read is none of the bus";
  const fs::path lines = folder_ / "lines.jsonl";
  test::ChildProgram exported(
      INTAGLIO_BIN_DIR "/intaglio",
      {"recording", "export", file_.string(), "--out", lines.string()});
  EXPECT_EQ(exported.ExitCode(), 0);
  EXPECT_THAT(test::ContentOf(lines), HasSubstr("\"topic\":\"PulseEventBatch\""));
  EXPECT_THAT(test::ContentOf(lines), Not(HasSubstr("/job-5/")));
}

}  // namespace
}  // namespace intaglio
