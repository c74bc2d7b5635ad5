#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "services/platform/recording/mcap_reader.h"
#include "services/platform/recording/mcap_writer.h"
#include "services/platform/recording/message_cursor.h"
#include "tests/services/platform/recording/memory_source.h"
#include "tests/services/platform/recording/recorded.h"
#include "tests/test_folder.h"

namespace intaglio::recording {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uint64_t kSecond = 1'000'000'000;

Bytes Text(const std::string& text) {
  const auto raw = std::as_bytes(std::span(text));
  return {raw.begin(), raw.end()};
}

class McapFile : public ::testing::Test {
 protected:
  McapFile() : folder_(test::FreshFolder()) {}

  /// Two topics over three seconds, in several chunks, with attachment and metadata.
  std::vector<Recorded> WriteSession(const fs::path& file, bool compress,
                                     bool close = true) const {
    WriterOptions options{.library = "intaglio test", .chunk_bytes = 4000};
    options.compress = compress;
    auto writer = McapWriter::Create(file, options).value();
    const auto schema = writer.AddSchema("shop::Status", "omgidl", "module shop {};");
    const auto fast =
        writer.AddChannel({0, schema, "Status", "cdr", {{"partition", "a"}}});
    const auto slow = writer.AddChannel({0, 0, "Raw", "cdr", {}});
    EXPECT_TRUE(writer.Write(Attachment{1, 2, "job", "text/plain", Text("a job")}));
    std::mt19937 random(7);
    std::vector<Recorded> all;
    for (std::uint32_t i = 0; i < 300; ++i) {
      Recorded message{i % 7 == 0 ? slow : fast, i, 5 * kSecond + i * kSecond / 100,
                       4 * kSecond + i, Bytes(random() % 120)};
      for (auto& byte : message.payload) byte = std::byte(random());
      EXPECT_TRUE(writer.Write(message.view()));
      all.push_back(std::move(message));
    }
    EXPECT_TRUE(writer.Write(Metadata{"missing", {{"topic", "Raw"}, {"count", "3"}}}));
    if (close) {
      EXPECT_TRUE(writer.Close());
    } else {
      EXPECT_TRUE(writer.Flush());
    }
    return all;
  }

  fs::path folder_;
};

TEST_F(McapFile, GivesBackWhatWasWritten) {
  for (const bool compress : {false, true}) {
    const auto written = WriteSession(folder_ / "a.mcap", compress);
    const auto reader = McapReader::Open(folder_ / "a.mcap");
    ASSERT_TRUE(reader) << reader.error().message;
    const RecordingContents& contents = reader->contents();
    EXPECT_TRUE(contents.complete);
    EXPECT_THAT(contents.damages, IsEmpty());
    EXPECT_EQ(contents.header.library, "intaglio test");
    EXPECT_EQ(contents.header.profile, "");
    ASSERT_THAT(contents.channels, SizeIs(2));
    EXPECT_EQ(contents.channels.at(0).topic, "Status");
    EXPECT_EQ(contents.channels.at(0).metadata.at("partition"), "a");
    EXPECT_EQ(reader->SchemaOf(contents.channels.at(0))->text, "module shop {};");
    EXPECT_EQ(reader->SchemaOf(contents.channels.at(1)), nullptr);
    EXPECT_EQ(contents.statistics.message_count, 300u);
    EXPECT_EQ(contents.statistics.start_ns, 5 * kSecond);
    EXPECT_GT(contents.blocks.size(), 3u);
    EXPECT_EQ(MessagesOf(*reader), written);
    ASSERT_THAT(contents.attachments, SizeIs(1));
    EXPECT_EQ(reader->Read(contents.attachments[0])->content, Text("a job"));
    const auto missing = reader->ReadMetadata("missing");
    ASSERT_TRUE(missing);
    ASSERT_THAT(*missing, SizeIs(1));
    EXPECT_EQ((*missing)[0].entries.at("count"), "3");
  }
}

// Files of today have to be read for ever, and a change of what is written has to be
// meant: INTAGLIO_WRITE_GOLDEN=1 writes the golden file anew.
TEST_F(McapFile, IsTheGoldenFileByteForByte) {
  const fs::path golden = INTAGLIO_SOURCE_DIR "/tests/data/formats/recording.mcap";
  const auto written = WriteSession(folder_ / "a.mcap", false);
  if (std::getenv("INTAGLIO_WRITE_GOLDEN") != nullptr) {
    fs::copy_file(folder_ / "a.mcap", golden, fs::copy_options::overwrite_existing);
  }
  EXPECT_EQ(BytesOf(folder_ / "a.mcap"), BytesOf(golden));
  EXPECT_EQ(MessagesOf(McapReader::Open(golden).value()), written);
}

TEST_F(McapFile, AnEmptyRecordingIsWhole) {
  auto writer = McapWriter::Create(folder_ / "a.mcap", {.library = "x"}).value();
  ASSERT_TRUE(writer.Close());
  const auto reader = McapReader::Open(folder_ / "a.mcap");
  ASSERT_TRUE(reader);
  EXPECT_TRUE(reader->contents().complete);
  EXPECT_THAT(MessagesOf(*reader), IsEmpty());
}

TEST_F(McapFile, SummaryAndWalkReportTheSame) {
  WriteSession(folder_ / "a.mcap", true);
  WriteSession(folder_ / "b.mcap", true, false);
  const auto whole = McapReader::Open(folder_ / "a.mcap");
  const auto open = McapReader::Open(folder_ / "b.mcap");
  ASSERT_TRUE(whole && open);
  EXPECT_FALSE(open->contents().complete);
  EXPECT_EQ(open->contents().torn_bytes, 0u);
  EXPECT_EQ(MessagesOf(*open), MessagesOf(*whole));
  EXPECT_EQ(open->contents().channels, whole->contents().channels);
  EXPECT_EQ(open->contents().schemas, whole->contents().schemas);
  const Statistics& a = whole->contents().statistics;
  const Statistics& b = open->contents().statistics;
  EXPECT_EQ(a.message_counts, b.message_counts);
  EXPECT_EQ(a.chunk_count, b.chunk_count);
  EXPECT_EQ(a.start_ns, b.start_ns);
  EXPECT_EQ(a.end_ns, b.end_ns);
  EXPECT_EQ(a.attachment_count, b.attachment_count);
  EXPECT_EQ(a.metadata_count, b.metadata_count);
}

TEST_F(McapFile, TimesAndChannelsSelect) {
  const auto written = WriteSession(folder_ / "a.mcap", true);
  const auto reader = McapReader::Open(folder_ / "a.mcap").value();
  MessageQuery query{.from_ns = written[50].log_time_ns,
                     .to_ns = written[90].log_time_ns,
                     .channels = std::set<std::uint16_t>{1}};
  std::vector<Recorded> expected;
  for (std::size_t i = 50; i < 90; ++i) {
    if (written[i].channel_id == 1) expected.push_back(written[i]);
  }
  EXPECT_EQ(MessagesOf(reader, query), expected);
}

TEST_F(McapFile, MessagesComeByTimeWhateverTheirChunks) {
  WriterOptions options{.library = "x", .chunk_bytes = 200};
  auto writer = McapWriter::Create(folder_ / "a.mcap", options).value();
  const auto channel = writer.AddChannel({0, 0, "T", "cdr", {}});
  std::mt19937 random(3);
  std::vector<std::uint64_t> times;
  for (std::uint32_t i = 0; i < 100; ++i) {
    times.push_back(1000 + random() % 500);
    const Bytes payload(16);
    ASSERT_TRUE(writer.Write(MessageView{channel, i, times.back(), 0, payload}));
  }
  ASSERT_TRUE(writer.Close());
  std::sort(times.begin(), times.end());
  std::vector<std::uint64_t> read;
  for (const auto& message : MessagesOf(McapReader::Open(folder_ / "a.mcap").value())) {
    read.push_back(message.log_time_ns);
  }
  EXPECT_EQ(read, times);
}

TEST_F(McapFile, ChunkIsWrittenWhenItIsASecondOld) {
  auto writer = McapWriter::Create(folder_ / "a.mcap", {.library = "x"}).value();
  const auto channel = writer.AddChannel({0, 0, "T", "cdr", {}});
  ASSERT_TRUE(writer.Write(MessageView{channel, 0, 10 * kSecond, 0, {}}));
  ASSERT_TRUE(writer.FlushIfOld(11 * kSecond - 1));
  EXPECT_EQ(writer.statistics().chunk_count, 0u);
  ASSERT_TRUE(writer.FlushIfOld(11 * kSecond));
  EXPECT_EQ(writer.statistics().chunk_count, 1u);
  EXPECT_THAT(MessagesOf(McapReader::Open(folder_ / "a.mcap").value()), SizeIs(1));
}

// Every length from the last chunk on, and every 13th before it; the messages that are
// read are those of the chunks that lie whole in front of the cut.
TEST_F(McapFile, CutAtEveryByteIsReadUpToTheLastWholeChunk) {
  const auto written = WriteSession(folder_ / "a.mcap", true);
  const Bytes bytes = BytesOf(folder_ / "a.mcap");
  const auto blocks = McapReader::Open(folder_ / "a.mcap")->contents().blocks;
  const std::size_t last = blocks.back().offset;
  for (std::size_t size = 0; size < bytes.size(); size += size < last ? 13 : 1) {
    const auto cut = McapReader::Open(
        MakeMemorySource("cut", Bytes(bytes.begin(), bytes.begin() + long(size))));
    if (size < kMagicSize) {
      EXPECT_FALSE(cut);
      continue;
    }
    ASSERT_TRUE(cut) << size << ": " << cut.error().message;
    std::size_t whole = 0;
    while (whole < blocks.size() && blocks[whole].offset + blocks[whole].length <= size) {
      ++whole;
    }
    ASSERT_THAT(cut->contents().blocks, SizeIs(whole)) << size;
    EXPECT_FALSE(cut->contents().complete);
    EXPECT_THAT(cut->contents().damages, IsEmpty());
    const bool at_a_chunk =
        whole > 0 && blocks[whole - 1].offset + blocks[whole - 1].length == size;
    if (!at_a_chunk) continue;
    const auto read = MessagesOf(*cut);
    ASSERT_LE(read.size(), written.size());
    EXPECT_TRUE(std::equal(read.begin(), read.end(), written.begin())) << size;
    EXPECT_EQ(read.back().log_time_ns, blocks[whole - 1].end_ns);
  }
}

TEST_F(McapFile, DamagedChunkCostsItsOwnMessagesOnly) {
  for (const bool close : {true, false}) {
    const auto written = WriteSession(folder_ / "a.mcap", true, close);
    Bytes bytes = BytesOf(folder_ / "a.mcap");
    const auto blocks = McapReader::Open(folder_ / "a.mcap")->contents().blocks;
    const MessageBlock& hit = blocks[1];
    bytes[hit.offset + hit.length / 2] ^= std::byte(0x40);
    const auto reader = McapReader::Open(MakeMemorySource("hit.mcap", bytes)).value();
    MessageCursor cursor(reader);
    std::size_t count = 0, errors = 0;
    for (;;) {
      const auto message = cursor.Next();
      if (!message) {
        ++errors;
        EXPECT_THAT(message.error().message, HasSubstr("hit.mcap"));
        EXPECT_THAT(message.error().message, HasSubstr(std::to_string(hit.offset)));
        EXPECT_THAT(message.error().message, HasSubstr("repair"));
        continue;
      }
      if (!*message) break;
      ++count;
    }
    const auto lost = static_cast<std::size_t>(
        std::count_if(written.begin(), written.end(), [&](const Recorded& message) {
          return message.log_time_ns >= hit.start_ns && message.log_time_ns <= hit.end_ns;
        }));
    EXPECT_EQ(count, written.size() - lost);
    EXPECT_EQ(errors + reader.contents().damages.size(), 1u);
  }
}

// Any one bit: an error or a reading, never a crash, and never a message that was not
// written.
TEST_F(McapFile, FlippedBitMakesNoWrongMessage) {
  const auto written = WriteSession(folder_ / "a.mcap", true);
  const Bytes bytes = BytesOf(folder_ / "a.mcap");
  std::mt19937 random(11);
  for (int i = 0; i < 2000; ++i) {
    Bytes hit = bytes;
    hit[random() % hit.size()] ^= std::byte(1u << (random() % 8));
    const auto reader = McapReader::Open(MakeMemorySource("hit", std::move(hit)));
    if (!reader) continue;
    for (const auto& message : MessagesOf(*reader)) {
      ASSERT_LT(message.sequence, written.size());
      EXPECT_EQ(message.payload, written[message.sequence].payload);
    }
  }
}

TEST_F(McapFile, WhatIsNoRecordingIsRefusedByName) {
  std::ofstream(folder_ / "a.mcap") << "solid cube";
  const auto text = McapReader::Open(folder_ / "a.mcap");
  ASSERT_FALSE(text);
  EXPECT_EQ(text.error().code, ErrorCode::kUnreadable);
  EXPECT_THAT(text.error().message, HasSubstr("a.mcap"));
  EXPECT_EQ(McapReader::Open(folder_ / "none").error().code, ErrorCode::kNotFound);
  EXPECT_EQ(McapReader::Open(folder_).error().code, ErrorCode::kIo);
}

TEST_F(McapFile, ClaimedSizesAreBounded) {
  Bytes bytes;
  PutRaw(bytes, std::as_bytes(std::span(kMagic, kMagicSize)));
  Encode(bytes, Header{"", "x"});
  ChunkHead head{1, 2, 1ull << 60, 1, "zstd", 4};
  EncodeChunkHead(bytes, head);
  Put<std::uint32_t>(bytes, 0);
  const auto reader = McapReader::Open(MakeMemorySource("bomb", bytes));
  ASSERT_TRUE(reader);
  EXPECT_THAT(reader->contents().blocks, IsEmpty());
  EXPECT_THAT(reader->contents().damages, ElementsAre(HasSubstr("more than")));
}

TEST_F(McapFile, LanesGatherInChunksOfTheirOwn) {
  auto writer = McapWriter::Create(folder_ / "a.mcap", {.library = "x"}).value();
  const auto small = writer.AddChannel({0, 0, "S", "cdr", {}}, Lane::kSmall);
  const auto large = writer.AddChannel({0, 0, "L", "cdr", {}}, Lane::kLarge);
  const Bytes payload(100);
  for (std::uint32_t i = 0; i < 10; ++i) {
    ASSERT_TRUE(writer.Write(MessageView{i % 2 == 0 ? small : large, i, i, 0, payload}));
  }
  ASSERT_TRUE(writer.Close());
  const auto reader = McapReader::Open(folder_ / "a.mcap").value();
  ASSERT_THAT(reader.contents().blocks, SizeIs(2));
  EXPECT_THAT(reader.contents().blocks[0].channels, ElementsAre(small));
  EXPECT_THAT(reader.contents().blocks[1].channels, ElementsAre(large));
  const auto messages = MessagesOf(reader);
  for (std::uint32_t i = 0; i < 10; ++i) EXPECT_EQ(messages[i].sequence, i);
}

TEST_F(McapFile, FullDiskIsReportedWithTheRemedy) {
  auto writer = McapWriter::Create("/dev/full", {.library = "x"});
  ASSERT_FALSE(writer);
  EXPECT_EQ(writer.error().code, ErrorCode::kIo);
  EXPECT_THAT(writer.error().message, HasSubstr("free space"));
}

/// The system's limit on the size of files represents a full disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

// One lane is given up, the other is kept in memory and written when there is room again;
// the file is readable at any time.
TEST_F(McapFile, RefusedChunkIsKeptUntilThereIsRoom) {
  WriterOptions options{.library = "x", .chunk_bytes = 1000};
  options.compress = false;
  auto writer = McapWriter::Create(folder_ / "a.mcap", options).value();
  const auto small = writer.AddChannel({0, 0, "S", "cdr", {}}, Lane::kSmall);
  const auto large = writer.AddChannel({0, 0, "L", "cdr", {}}, Lane::kLarge);
  const Bytes payload(300);
  ASSERT_TRUE(writer.Write(MessageView{small, 0, 0, 0, payload}));
  ASSERT_TRUE(writer.Flush());
  {
    const FileSizeLimit full(writer.file_bytes() + 100);
    bool refused = false;
    for (std::uint32_t i = 1; i < 20; ++i) {
      refused =
          !writer.Write(MessageView{i % 2 == 0 ? small : large, i, i, 0, payload}) ||
          refused;
    }
    EXPECT_TRUE(refused);
    EXPECT_FALSE(writer.Flush());
    EXPECT_EQ(fs::file_size(folder_ / "a.mcap"), writer.file_bytes());
    EXPECT_THAT(MessagesOf(McapReader::Open(folder_ / "a.mcap").value()), SizeIs(1));
    const auto dropped = writer.Drop(Lane::kLarge);
    ASSERT_TRUE(dropped.contains(large));
    EXPECT_EQ(dropped.at(large).count, 10u);
    EXPECT_EQ(dropped.at(large).from_ns, 1u);
    EXPECT_EQ(dropped.at(large).to_ns, 19u);
  }
  ASSERT_TRUE(writer.Close());
  const auto reader = McapReader::Open(folder_ / "a.mcap").value();
  EXPECT_TRUE(reader.contents().complete);
  const auto messages = MessagesOf(reader);
  ASSERT_THAT(messages, SizeIs(10));
  for (std::uint32_t i = 0; i < 10; ++i) EXPECT_EQ(messages[i].sequence, 2 * i);
}

}  // namespace
}  // namespace intaglio::recording
