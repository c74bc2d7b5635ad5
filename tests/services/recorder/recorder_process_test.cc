#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>
#include <thread>

#include "proto/task.pb.h"
#include "services/platform/bus/samples.h"
#include "services/platform/bus/topics.h"
#include "services/platform/recording/cdr_value.h"
#include "services/platform/recording/conventions.h"
#include "services/platform/recording/mcap_reader.h"
#include "tests/engrave/io/small_disk.h"
#include "tests/services/platform/bus/child_program.h"
#include "tests/services/platform/recording/recorded.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using recording::McapReader;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

std::uint64_t WallNow() {
  return static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch() /
                                    1ns);
}

class RecorderProcess : public ::testing::Test {
 protected:
  RecorderProcess() : folder_(test::FreshFolder()), file_(folder_ / "s.mcap") {}
  test::ChildProgram Start(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"--tag",      test::PrivateTag(),
                                          "--out",      file_.string(),
                                          "--log-file", (folder_ / "log").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return {INTAGLIO_BIN_DIR "/intaglio-recorder", arguments};
  }
  static test::ChildProgram Peer() {
    return {INTAGLIO_TAP_PEER, {test::PrivateTag(), "topics", "els-7"}};
  }
  /// The file as it is at the moment, by the way a killed one is read.
  bool Holds(std::size_t topics) const {
    const auto reader = McapReader::Open(file_);
    if (!reader) return false;
    const auto& counts = reader->contents().statistics.message_counts;
    return TopicsOf(*reader).size() >= topics &&
           counts.size() == reader->contents().channels.size();
  }
  static std::set<std::string> TopicsOf(const McapReader& reader) {
    std::set<std::string> topics;
    for (const auto& [id, channel] : reader.contents().channels) {
      topics.insert(recording::StreamOf(channel)->topic);
    }
    return topics;
  }

  std::string Log() const { return test::ContentOf(folder_ / "log"); }

  fs::path folder_, file_;
};

std::set<std::string> AllTopics() {
  std::set<std::string> names;
  bus::ForEachTopic([&](const auto& topic) { names.insert(topic.name); });
  return names;
}

TEST_F(RecorderProcess, RecordsEveryTopicOfBothDomains) {
  auto recorder = Start();
  auto peer = Peer();
  ASSERT_TRUE(test::Eventually([&] { return Holds(AllTopics().size()); }, 20s));
  peer.Signal(SIGTERM);
  recorder.Signal(SIGTERM);
  EXPECT_EQ(recorder.ExitCode(), 0);
  const auto reader = McapReader::Open(file_).value();
  EXPECT_TRUE(reader.contents().complete);
  EXPECT_EQ(TopicsOf(reader), AllTopics());
  std::map<std::uint16_t, std::uint32_t> next;
  std::uint64_t before = 0;
  for (const auto& message : recording::MessagesOf(reader)) {
    EXPECT_EQ(message.sequence, next[message.channel_id]++);
    EXPECT_GE(message.log_time_ns, before);
    EXPECT_LE(message.publish_time_ns, message.log_time_ns);
    before = message.log_time_ns;
    const auto& channel = reader.contents().channels.at(message.channel_id);
    const recording::Schema* schema = reader.SchemaOf(channel);
    ASSERT_NE(schema, nullptr);
    const auto types = recording::ParseIdl(schema->text);
    ASSERT_TRUE(types) << types.error().message << "\n" << schema->text;
    const auto value = recording::DecodeCdr(*types, schema->name, message.payload);
    ASSERT_TRUE(value) << channel.topic << ": " << value.error().message;
  }
}

TEST_F(RecorderProcess, FiltersAreKept) {
  auto recorder = Start({"--topic", "Job*", "--topic", "Interlock", "--not-topic",
                         "JobCommand*", "--not-partition", "els-7"});
  auto peer = Peer();
  ASSERT_TRUE(test::Eventually([&] { return Holds(3); }, 20s));
  recorder.Signal(SIGINT);
  EXPECT_EQ(recorder.ExitCode(), 0);
  EXPECT_EQ(TopicsOf(*McapReader::Open(file_)),
            (std::set<std::string>{"JobCount", "JobStatus", "JobSubmission"}));
}

TEST_F(RecorderProcess, KilledOneLosesLessThanASecond) {
  auto recorder = Start();
  auto peer = Peer();
  ASSERT_TRUE(test::Eventually([&] { return Holds(AllTopics().size()); }, 20s));
  const std::uint64_t killed_ns = WallNow();
  recorder.Kill();
  const auto reader = McapReader::Open(file_).value();
  EXPECT_FALSE(reader.contents().complete);
  EXPECT_TRUE(reader.contents().damages.empty());
  EXPECT_GT(reader.contents().statistics.end_ns + 1'000'000'000, killed_ns);
}

TEST_F(RecorderProcess, RestartedOneGoesOnInAnotherFile) {
  for (int i = 0; i < 2; ++i) {
    auto recorder = Start();
    const fs::path file = i == 0 ? file_ : folder_ / "s-0002.mcap";
    ASSERT_TRUE(test::Eventually([&] { return fs::exists(file); }, 20s));
    recorder.Kill();
  }
  EXPECT_TRUE(fs::exists(file_));
}

TEST_F(RecorderProcess, KeepsTheAttachmentsOfAJob) {
  auto recorder = Start();
  FrozenJob job;
  job.set_job_uid("7-abc");
  job.set_software_version("1.2.3");
  job.mutable_job()->set_name("lion");
  const std::string bytes = job.SerializeAsString();
  const std::vector<std::uint8_t> frozen(bytes.begin(), bytes.end());
  bus::Bus bus(test::PrivateBusOptions());
  bus::Writer<intaglio_StageTask> writer(bus, bus::kDiscretizeTask);
  intaglio_StageTask task{};
  const std::string uid = job.job_uid();
  task.job_uid = bus::Borrow(uid);
  bus::Borrow(task.frozen_job, frozen);
  ASSERT_TRUE(writer.Write(task));
  ASSERT_TRUE(test::Eventually(
      [&] {
        const auto reader = McapReader::Open(file_);
        return reader && reader->contents().attachments.size() == 5;
      },
      20s));
  recorder.Signal(SIGTERM);
  EXPECT_EQ(recorder.ExitCode(), 0);
  const auto reader = McapReader::Open(file_).value();
  std::map<std::string, std::string> attachments;
  for (const auto& index : reader.contents().attachments) {
    const auto attachment = reader.Read(index).value();
    attachments[attachment.name] =
        std::string(reinterpret_cast<const char*>(attachment.content.data()),
                    attachment.content.size());
  }
  EXPECT_EQ(attachments.at("jobs/7-abc/frozen_job.binpb"), bytes);
  EXPECT_EQ(attachments.at("jobs/7-abc/software_version.txt"), "1.2.3");
  EXPECT_THAT(attachments.at("jobs/7-abc/job.textproto"), HasSubstr("lion"));
}

// The format's own library reads the file, checks its checksums, and understands every
// message as `intaglio recording export` does.
TEST_F(RecorderProcess, ReferenceLibraryAgrees) {
  const fs::path reference = fs::path(INTAGLIO_REFERENCE_LIBRARY);
  if (!fs::exists(reference / "node_modules" / "@mcap" / "core")) {
    GTEST_SKIP() << "no packages in " << reference
                 << ": install npm and run `npm ci` there";
  }
  auto recorder = Start();
  auto peer = Peer();
  ASSERT_TRUE(test::Eventually([&] { return Holds(AllTopics().size()); }, 20s));
  peer.Kill();
  recorder.Signal(SIGTERM);
  ASSERT_EQ(recorder.ExitCode(), 0);
  const std::string exported = (folder_ / "export.jsonl").string();
  const std::string command =
      std::string(INTAGLIO_BIN_DIR "/intaglio recording export ") + file_.string() +
      " --out " + exported + " && node " +
      (reference / "compare_recording.mjs").string() + " " + file_.string() + " " +
      exported;
  FILE* out = popen(command.c_str(), "r");
  ASSERT_NE(out, nullptr);
  std::string sent(4096, '\0');
  sent.resize(std::fread(sent.data(), 1, sent.size(), out));
  EXPECT_EQ(pclose(out), 0) << sent;
  EXPECT_THAT(sent, HasSubstr("agree"));
}

TEST_F(RecorderProcess, ADiskThatIsFullAtTheStartIsWaitedFor) {
  const fs::path disk = folder_ / "disk";
  fs::create_directories(disk);
  if (!io::MountSmallDisk(disk, 1 << 20)) GTEST_SKIP() << "it takes root";
  {
    std::ofstream full(disk / "full", std::ios::binary);
    const std::string block(4096, 'x');
    while (full.write(block.data(), static_cast<std::streamsize>(block.size())).flush()) {
    }
  }
  file_ = disk / "s.mcap";
  auto recorder = Start();
  ASSERT_TRUE(test::Eventually(
      [&] { return Log().find("No space left on device") != std::string::npos; }, 20s))
      << Log();
  EXPECT_THAT(Log(), HasSubstr("s.mcap"));
  EXPECT_THAT(Log(), HasSubstr("free space"));
  fs::remove(disk / "full");
  EXPECT_TRUE(test::Eventually([&] { return fs::exists(file_); }, 20s)) << Log();
  recorder.Signal(SIGTERM);
  EXPECT_EQ(recorder.ExitCode(), 0);
  EXPECT_TRUE(McapReader::Open(file_).value().contents().complete);
  EXPECT_FALSE(fs::exists(disk / "s-0002.mcap")) << "a try leaves no file behind";
}

TEST_F(RecorderProcess, AFolderThatThereIsNotIsAMistake) {
  file_ = folder_ / "absent" / "s.mcap";
  auto recorder = Start();
  EXPECT_EQ(recorder.ExitCode(), 2);
}

}  // namespace
}  // namespace intaglio
