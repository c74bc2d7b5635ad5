#include "services/recorder/recording_series.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include "services/platform/recording/mcap_reader.h"
#include "services/recorder/series_files.h"
#include "services/recorder/write_queue.h"
#include "tests/services/platform/recording/recorded.h"
#include "tests/test_folder.h"

namespace intaglio::recorder {
namespace {

namespace fs = std::filesystem;
using recording::Bytes;
using recording::McapReader;
using recording::Stream;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uint64_t kSecond = 1'000'000'000;

class Series : public ::testing::Test {
 protected:
  Series() : folder_(test::FreshFolder()) {
    options_.file = folder_ / "s.mcap";
    options_.version = "9.9";
    options_.host = "here";
    options_.writer.compress = false;
  }
  RecordingSeries Open() { return RecordingSeries::Open(options_, 0).value(); }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& file : FilesOf(options_.file)) names.push_back(file.path.filename());
    return names;
  }
  std::uint64_t MessagesIn(const std::string& name) const {
    return McapReader::Open(folder_ / name)->contents().statistics.message_count;
  }

  fs::path folder_;
  SeriesOptions options_;
  Stream control_{
      "Status", "m::Status", false, "cell", {}, true, {{"durability", "volatile"}}};
  Stream bulk_{"Points", "m::Points", true, "", {}, false, {}};
  StreamTypes types_{"module m {};", "", {{"name", "m::Status"}}};
  Bytes payload_ = Bytes(1000);
};

TEST_F(Series, ReportsStreamsTypesAndItself) {
  auto series = Open();
  const auto stream = series.AddStream(control_, types_);
  EXPECT_EQ(series.AddStream(control_, types_), stream);
  series.Write(stream, kSecond, 5, payload_);
  series.Write(stream, 2 * kSecond, 6, payload_);
  ASSERT_TRUE(series.Close());
  const auto reader = McapReader::Open(options_.file).value();
  ASSERT_THAT(reader.contents().channels, SizeIs(1));
  const recording::Channel& channel = reader.contents().channels.begin()->second;
  EXPECT_EQ(recording::StreamOf(channel), control_);
  EXPECT_EQ(reader.SchemaOf(channel)->text, types_.idl);
  EXPECT_EQ(reader.contents().header.library, "intaglio 9.9");
  const auto messages = recording::MessagesOf(reader);
  ASSERT_THAT(messages, SizeIs(2));
  EXPECT_EQ(messages[1].sequence, 1u);
  EXPECT_EQ(messages[1].publish_time_ns, 6u);
  EXPECT_THAT(*reader.ReadMetadata(recording::kTypeRecord), SizeIs(1));
  EXPECT_EQ(reader.ReadMetadata(recording::kRecordingRecord)->at(0).entries.at("host"),
            "here");
}

TEST_F(Series, SplitsBySizeAndEveryFileIsCompleteByItself) {
  options_.split_bytes = 10'000;
  auto series = Open();
  series.Attach({0, 0, "job", "text/plain", payload_});
  const auto stream = series.AddStream(control_, types_);
  for (std::uint64_t i = 0; i < 40; ++i) {
    series.Write(stream, i * kSecond, i, payload_);
    series.Turn(i * kSecond);
  }
  ASSERT_TRUE(series.Close());
  const auto names = Names();
  ASSERT_GE(names.size(), 4u);
  EXPECT_EQ(names[1], "s-0002.mcap");
  std::uint64_t total = 0;
  for (const std::string& name : names) {
    const auto reader = McapReader::Open(folder_ / name).value();
    EXPECT_TRUE(reader.contents().complete) << name;
    EXPECT_THAT(reader.contents().attachments, SizeIs(1)) << name;
    EXPECT_EQ(reader.ReadMetadata(recording::kTypeRecord)->size(),
              reader.contents().channels.size());
    total += MessagesIn(name);
  }
  EXPECT_EQ(total, 40u);
}

TEST_F(Series, SplitsByTime) {
  options_.split_ns = 10 * kSecond;
  auto series = Open();
  for (std::uint64_t i = 0; i <= 25; ++i) series.Turn(i * kSecond);
  ASSERT_TRUE(series.Close());
  EXPECT_THAT(Names(), ElementsAre("s.mcap", "s-0002.mcap", "s-0003.mcap"));
}

TEST_F(Series, OldestFilesGoWhenThereAreTooMany) {
  options_.split_bytes = 10'000;
  options_.keep_bytes = 30'000;
  auto series = Open();
  const auto stream = series.AddStream(control_, types_);
  for (std::uint64_t i = 0; i < 100; ++i) {
    series.Write(stream, i * kSecond, i, payload_);
    series.Turn(i * kSecond);
  }
  ASSERT_TRUE(series.Close());
  std::uint64_t total = 0;
  for (const auto& file : FilesOf(options_.file)) total += file.bytes;
  // The limit, and the file that is being written.
  EXPECT_LT(total, 30'000u + 13'000u);
  EXPECT_GE(Names().size(), 2u);
  EXPECT_NE(Names().front(), "s.mcap");
}

// They are of recorders before this one, which itself never splits.
TEST_F(Series, OldFilesGoWithoutANewOne) {
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(Open().Close());
  const auto now = fs::file_time_type::clock::now();
  fs::last_write_time(folder_ / "s.mcap", now - std::chrono::hours(3));
  options_.keep_ns = 7200 * kSecond;
  auto series = Open();
  series.Turn(kSecond);
  EXPECT_THAT(Names(), ElementsAre("s-0002.mcap", "s-0003.mcap", "s-0004.mcap"));
  fs::last_write_time(folder_ / "s-0002.mcap", now - std::chrono::hours(3));
  for (std::uint64_t i = 1; i < 63; ++i) series.Turn(i * kSecond);
  EXPECT_THAT(Names(), ElementsAre("s-0003.mcap", "s-0004.mcap"));
}

TEST_F(Series, NeverOverwrites) {
  for (int i = 0; i < 3; ++i) {
    auto series = Open();
    ASSERT_TRUE(series.Close());
  }
  EXPECT_THAT(Names(), ElementsAre("s.mcap", "s-0002.mcap", "s-0003.mcap"));
}

// Another recorder of the same name was begun meanwhile.
TEST_F(Series, DoesNotTakeTheNameOfAnothersFile) {
  options_.split_ns = 10 * kSecond;
  auto series = Open();
  const auto other = Open();
  ASSERT_EQ(other.file(), folder_ / "s-0002.mcap");
  const auto size = fs::file_size(other.file());
  ASSERT_GT(size, 0u);
  series.Turn(10 * kSecond);
  EXPECT_EQ(series.file(), folder_ / "s-0003.mcap");
  EXPECT_EQ(fs::file_size(other.file()), size);
}

TEST_F(Series, GoesOnWhenNoNextFileCanBeMade) {
  options_.split_ns = 10 * kSecond;
  auto series = Open();
  const auto bulk = series.AddStream(bulk_, types_);
  const fs::path aside = folder_.string() + "-aside";
  fs::remove_all(aside);
  fs::rename(folder_, aside);
  for (std::uint64_t i = 10; i < 20; ++i) {
    series.Turn(i * kSecond);
    ASSERT_TRUE(series.trouble());
    series.Write(bulk, i * kSecond, 0, payload_);
  }
  fs::rename(aside, folder_);
  series.Turn(20 * kSecond);
  EXPECT_FALSE(series.trouble());
  EXPECT_EQ(series.missing_count(), 0u);
  ASSERT_TRUE(series.Close());
  EXPECT_EQ(MessagesIn("s.mcap"), 10u);
  EXPECT_EQ(Names().size(), 2u);
}

TEST_F(Series, AFullDiskIsNotFilledWithBeginnings) {
  options_.split_ns = 10 * kSecond;
  auto series = Open();
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, SIG_IGN);
  const rlimit full{0, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  for (std::uint64_t i = 10; i < 20; ++i) series.Turn(i * kSecond);
  setrlimit(RLIMIT_FSIZE, &before);
  ASSERT_TRUE(series.trouble());
  EXPECT_THAT(Names(), ElementsAre("s.mcap"));
  series.Turn(20 * kSecond);
  EXPECT_FALSE(series.trouble());
  ASSERT_TRUE(series.Close());
  EXPECT_THAT(Names(), ElementsAre("s.mcap", "s-0002.mcap"));
}

// The attachments of all jobs since the recorder was begun would fill memory and files.
TEST_F(Series, CarriesTheNewestAttachmentsOver) {
  options_.split_bytes = 20'000;
  auto series = Open();
  for (int i = 0; i < 100; ++i)
    series.Attach({0, 0, std::to_string(i), "text/plain", payload_});
  const auto stream = series.AddStream(control_, types_);
  for (std::uint64_t i = 0; i < 40; ++i) {
    series.Turn(i * kSecond);
    series.Write(stream, i * kSecond, i, payload_);
  }
  ASSERT_TRUE(series.Close());
  EXPECT_LE(Names().size(), 6u);
  EXPECT_THAT(McapReader::Open(folder_ / "s.mcap")->contents().attachments, SizeIs(100));
  const auto later = McapReader::Open(folder_ / "s-0002.mcap").value();
  ASSERT_THAT(later.contents().attachments, SizeIs(5));
  EXPECT_EQ(later.contents().attachments.back().name, "99");
}

// After a clock was set back, files are as long as before.
TEST_F(Series, SplitsByTimeAlsoWhenTheClockIsSetBack) {
  options_.split_ns = 10 * kSecond;
  auto series = Open();
  for (std::uint64_t i = 1000; i < 1015; ++i) series.Turn(i * kSecond);
  for (std::uint64_t i = 500; i < 515; ++i) series.Turn(i * kSecond);
  ASSERT_TRUE(series.Close());
  EXPECT_EQ(Names().size(), 4u);
}

TEST_F(Series, ReportsWhatIsMissing) {
  auto series = Open();
  const auto stream = series.AddStream(bulk_, types_);
  series.CountMissing(stream, 7 * kSecond, "the disk is too slow", 3);
  series.CountMissing(stream, 9 * kSecond, "the disk is too slow", 2);
  series.ReportUnrecorded("Odd", "its type is not available");
  ASSERT_TRUE(series.Close());
  const auto records =
      McapReader::Open(options_.file)->ReadMetadata(recording::kMissingRecord).value();
  ASSERT_THAT(records, SizeIs(2));
  EXPECT_THAT(recording::MissingSentences(McapReader::Open(options_.file).value()),
              ElementsAre("Odd is missing: its type is not available",
                          "5 messages of Points are missing: the disk is too slow"));
  EXPECT_EQ(records[0].entries.at("topic"), "Odd");
  const auto& missing = records[1].entries;
  EXPECT_EQ(missing.at("topic"), "Points");
  EXPECT_EQ(missing.at("count"), "5");
  EXPECT_EQ(missing.at("from_ns"), std::to_string(7 * kSecond));
  EXPECT_EQ(missing.at("to_ns"), std::to_string(9 * kSecond));
}

// The system's limit on the size of files represents a full disk.
TEST_F(Series, FullDiskCostsBulkAndNoControl) {
  auto series = Open();
  const auto control = series.AddStream(control_, types_);
  const auto bulk = series.AddStream(bulk_, types_);
  series.Write(control, kSecond, 0, payload_);
  series.Turn(3 * kSecond);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  signal(SIGXFSZ, SIG_IGN);
  const rlimit full{fs::file_size(options_.file) + 500, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  for (std::uint64_t i = 0; i < 20; ++i) {
    series.Write(i % 2 == 0 ? control : bulk, (4 + i) * kSecond, 0, payload_);
    series.Turn((4 + i) * kSecond);
  }
  ASSERT_TRUE(series.trouble());
  EXPECT_EQ(series.trouble()->code, ErrorCode::kIo);
  setrlimit(RLIMIT_FSIZE, &before);
  series.Turn(30 * kSecond);
  EXPECT_FALSE(series.trouble());
  ASSERT_TRUE(series.Close());
  const auto reader = McapReader::Open(options_.file).value();
  EXPECT_TRUE(reader.contents().complete);
  std::uint64_t controls = 0, bulks = 0, missing = 0;
  for (const auto& message : recording::MessagesOf(reader)) {
    const bool is_bulk =
        reader.contents().channels.at(message.channel_id).topic == "Points";
    ++(is_bulk ? bulks : controls);
  }
  const auto records = reader.ReadMetadata(recording::kMissingRecord).value();
  for (const auto& record : records) {
    EXPECT_EQ(record.entries.at("topic"), "Points");
    missing += std::stoull(record.entries.at("count"));
  }
  EXPECT_EQ(controls, 11u);
  EXPECT_EQ(bulks + missing, 10u);
  EXPECT_GT(missing, 0u);
}

TEST(WriteQueue, RefusesLargeOnesFirst) {
  WriteQueue<int> queue({.large_bytes = 100, .total_bytes = 200});
  EXPECT_TRUE(queue.Push(1, 90, true));
  EXPECT_FALSE(queue.Push(2, 20, true));
  EXPECT_TRUE(queue.Push(3, 20, false));
  EXPECT_TRUE(queue.Push(4, 80, false));
  EXPECT_FALSE(queue.Push(5, 20, false));
  EXPECT_THAT(queue.Take(std::chrono::milliseconds(0)), ElementsAre(1, 3, 4));
  // What was taken is still in memory until the next time.
  EXPECT_FALSE(queue.Push(6, 20, true));
  EXPECT_THAT(queue.Take(std::chrono::milliseconds(0)), IsEmpty());
  EXPECT_TRUE(queue.Push(7, 1000, true));
}

// A power failure leaves what was synced and nothing else: at any of these moments that
// is a recording that lacks no more than its last second.
TEST_F(Series, APowerFailureCostsASecondAtMost) {
  constexpr std::uint64_t kTurnNs = kSecond / 10, kMessages = 20;
  options_.writer.chunk_ns = kSecond / 2;  // as the recorder has it
  auto series = Open();
  const auto stream = series.AddStream(control_, types_);
  const fs::path left = folder_ / "left.mcap";
  for (std::uint64_t turn = 0; turn < 50; ++turn) {
    const std::uint64_t begin = turn * kTurnNs;
    for (std::uint64_t i = 0; i < kMessages; ++i) {
      const std::uint64_t at = begin + i * kTurnNs / kMessages;
      series.Write(stream, at, at, payload_);
    }
    series.Turn(begin + kTurnNs);
    const std::uint64_t now = begin + kTurnNs;
    if (now < kSecond) continue;
    fs::copy_file(series.file(), left, fs::copy_options::overwrite_existing);
    fs::resize_file(left, series.synced_bytes());
    const auto reader = McapReader::Open(left);
    ASSERT_TRUE(reader) << "at " << now << ": " << reader.error().message;
    // Until the next turn nothing more reaches the disk.
    EXPECT_GE(reader->contents().statistics.end_ns + kSecond, now + kTurnNs)
        << "at " << now;
  }
  ASSERT_TRUE(series.Close());
  EXPECT_EQ(series.synced_bytes(), fs::file_size(series.file()));
}

}  // namespace
}  // namespace intaglio::recorder
