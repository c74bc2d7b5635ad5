#include "services/platform/recording/recording_copy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "services/platform/recording/conventions.h"
#include "services/platform/recording/mcap_writer.h"
#include "tests/services/platform/recording/recorded.h"
#include "tests/test_folder.h"

namespace intaglio::recording {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

class RecordingCopy : public ::testing::Test {
 protected:
  RecordingCopy() : folder_(test::FreshFolder()) {}
  /// Messages at `first_ns`, +10, +20 ... of topics A and B in turn.
  fs::path Write(const std::string& name, std::uint64_t first_ns, bool close = true) {
    const fs::path file = folder_ / name;
    auto writer = McapWriter::Create(file, {.library = "x", .chunk_bytes = 500}).value();
    const Stream a{"A", "m::A", false, "cell", SampleKind::kValue, true, {}};
    Stream a_end = a;
    a_end.kind = SampleKind::kDisposed;
    const Stream b{"B", "m::B", true, "", SampleKind::kValue, false, {}};
    std::vector<std::uint16_t> ids;
    for (const Stream& stream : {a, b, a_end})
      ids.push_back(writer.AddChannel(ChannelOf(stream)));
    const Bytes payload(20);
    for (std::uint32_t i = 0; i < 60; ++i) {
      EXPECT_TRUE(
          writer.Write(MessageView{ids[i % 3], i, first_ns + 10 * i, 0, payload}));
    }
    EXPECT_TRUE(writer.Write(Metadata{kTypeRecord, {{"name", "m::A"}}}));
    EXPECT_TRUE(writer.Write(Attachment{0, 0, "job", "text/plain", payload}));
    EXPECT_TRUE(close ? writer.Close() : writer.Flush());
    return file;
  }
  std::vector<McapReader> Open(const std::vector<fs::path>& files) {
    std::vector<McapReader> readers;
    for (const fs::path& file : files) readers.push_back(McapReader::Open(file).value());
    return readers;
  }
  fs::path folder_;
};

/// Files of other writers, which are closed without a summary.
fs::path OfOthers(const char* name) {
  return fs::path(INTAGLIO_SOURCE_DIR) / "tests/data/recordings/others" / name;
}

TEST_F(RecordingCopy, AFileThatIsClosedWithoutASummaryIsWhole) {
  for (const auto& [name, count] : {std::pair("complete_without_summary.mcap", 5U),
                                    std::pair("last_time_stamp.mcap", 4U)}) {
    const auto sources = Open({OfOthers(name)});
    EXPECT_TRUE(sources[0].contents().complete) << name;
    EXPECT_EQ(sources[0].contents().torn_bytes, 0U);
    EXPECT_THAT(sources[0].contents().blocks, SizeIs(1));
    EXPECT_EQ(sources[0].contents().statistics.message_count, count);
    // One of the messages has the last time that there is.
    const auto report = CopyRecordings(sources, folder_ / "out.mcap", {});
    ASSERT_TRUE(report) << report.error().message;
    EXPECT_EQ(report->message_count, count) << name;
    EXPECT_THAT(report->damages, IsEmpty());
  }
}

// Cut anywhere behind the data, it is not.
TEST_F(RecordingCopy, AFileThatIsCutBehindItsDataIsNotWhole) {
  const std::string whole = test::ContentOf(OfOthers("complete_without_summary.mcap"));
  for (std::size_t left_out = 1; left_out < 37; ++left_out) {
    std::ofstream(folder_ / "cut.mcap", std::ios::binary)
        << whole.substr(0, whole.size() - left_out);
    const auto reader = McapReader::Open(folder_ / "cut.mcap");
    ASSERT_TRUE(reader);
    EXPECT_FALSE(reader->contents().complete) << left_out;
    EXPECT_EQ(reader->contents().statistics.message_count, 5U);
  }
}

TEST_F(RecordingCopy, MergesByTimeAndWritesWhatIsAlikeOnce) {
  const auto sources = Open({Write("a.mcap", 1000), Write("b.mcap", 1005)});
  const auto report = CopyRecordings(sources, folder_ / "out.mcap", {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->message_count, 120u);
  const auto merged = McapReader::Open(folder_ / "out.mcap").value();
  EXPECT_TRUE(merged.contents().complete);
  EXPECT_THAT(merged.contents().channels, SizeIs(3));
  EXPECT_THAT(merged.contents().attachments, SizeIs(1));
  EXPECT_THAT(merged.contents().metadata, SizeIs(1));
  std::uint64_t expected = 1000;
  for (const Recorded& message : MessagesOf(merged)) {
    EXPECT_EQ(message.log_time_ns, expected);
    expected += 5;
  }
}

// The messages of a cut were there twice.
TEST_F(RecordingCopy, AFileAndACutOfItMakeThatFile) {
  const auto whole = Write("a.mcap", 1000);
  CopyOptions options;
  options.from_ns = 1100;
  options.to_ns = 1200;
  ASSERT_TRUE(CopyRecordings(Open({whole}), folder_ / "cut.mcap", options));
  const auto report =
      CopyRecordings(Open({whole, folder_ / "cut.mcap"}), folder_ / "out.mcap", {});
  ASSERT_TRUE(report) << report.error().message;
  EXPECT_EQ(report->message_count, 60u);
  EXPECT_EQ(report->copy_count, 10u);
  EXPECT_EQ(MessagesOf(McapReader::Open(folder_ / "out.mcap").value()),
            MessagesOf(McapReader::Open(whole).value()));
}

TEST_F(RecordingCopy, CutsByTimeAndTopicWithTheEndsOfItsInstances) {
  const auto sources = Open({Write("a.mcap", 1000)});
  CopyOptions options;
  options.from_ns = 1100;
  options.to_ns = 1200;
  options.topics = {"A"};
  ASSERT_TRUE(CopyRecordings(sources, folder_ / "out.mcap", options));
  const auto cut = McapReader::Open(folder_ / "out.mcap").value();
  std::vector<std::string> topics;
  for (const auto& [id, channel] : cut.contents().channels)
    topics.push_back(channel.topic);
  EXPECT_THAT(topics, ::testing::UnorderedElementsAre("A", "A/disposed"));
  for (const Recorded& message : MessagesOf(cut)) {
    EXPECT_GE(message.log_time_ns, 1100u);
    EXPECT_LT(message.log_time_ns, 1200u);
    EXPECT_NE(message.sequence % 3, 1u);
  }
  options.topics = {"C"};
  const auto unknown = CopyRecordings(sources, folder_ / "out2.mcap", options);
  ASSERT_FALSE(unknown);
  EXPECT_THAT(unknown.error().message, HasSubstr("has no topic C"));
  EXPECT_FALSE(fs::exists(folder_ / "out2.mcap"));
  EXPECT_FALSE(fs::exists(folder_ / "out2.mcap.part"));
}

TEST_F(RecordingCopy, RepairsACutFile) {
  const fs::path file = Write("a.mcap", 1000, false);
  fs::resize_file(file, fs::file_size(file) * 2 / 3);
  const auto sources = Open({file});
  const auto before = MessagesOf(sources.front());
  ASSERT_FALSE(before.empty());
  ASSERT_TRUE(CopyRecordings(sources, folder_ / "out.mcap", {}));
  const auto repaired = McapReader::Open(folder_ / "out.mcap").value();
  EXPECT_TRUE(repaired.contents().complete);
  EXPECT_EQ(repaired.contents().statistics.message_count, before.size());
}

TEST_F(RecordingCopy, DoesNotWriteOverWhatItReads) {
  const fs::path file = Write("a.mcap", 1000);
  const auto sources = Open({file});
  EXPECT_EQ(CopyRecordings(sources, file, {}).error().code, ErrorCode::kInvalidValue);
  EXPECT_EQ(MessagesOf(McapReader::Open(file).value()).size(), 60u);
}

TEST_F(RecordingCopy, DoesNotWriteOverWhatAKilledCopyLeft) {
  const fs::path left = Write("a.mcap.part", 1000, false);
  const auto sources = Open({left});
  EXPECT_EQ(CopyRecordings(sources, folder_ / "a.mcap", {}).error().code,
            ErrorCode::kInvalidValue);
  EXPECT_EQ(MessagesOf(McapReader::Open(left).value()).size(), 60u);
}

TEST(Conventions, ChannelsReportTheirStream) {
  const Stream stream{
      "JobStatus", "intaglio::JobStatus",        true, "els-03", SampleKind::kNoWriter,
      true,        {{"reliability", "reliable"}}};
  const Channel channel = ChannelOf(stream);
  EXPECT_EQ(channel.topic, "JobStatus/no_writer");
  EXPECT_EQ(StreamOf(channel), stream);
  EXPECT_EQ(StreamOf(Channel{0, 0, "foreign", "ros1", {}}), std::nullopt);
}

}  // namespace
}  // namespace intaglio::recording
