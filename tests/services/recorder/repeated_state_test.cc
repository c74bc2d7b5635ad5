// Every file of a series begins with what was retained by then.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <tuple>

#include "services/platform/recording/recording_copy.h"
#include "services/recorder/recording_series.h"
#include "services/recorder/series_files.h"
#include "tests/services/platform/recording/recorded.h"
#include "tests/services/platform/recording/status_samples.h"
#include "tests/test_folder.h"

namespace intaglio::recorder {
namespace {

namespace fs = std::filesystem;
using recording::Bytes;
using recording::McapReader;
using recording::SampleKind;
using recording::StatusKeyOf;
using recording::StatusOf;
using recording::Stream;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uint64_t kSecondNs = 1'000'000'000;

/// A message as its readers see it, whatever the ids in its file.
struct Reported {
  std::string channel;
  std::uint32_t sequence = 0;
  std::uint64_t log_time_ns = 0, publish_time_ns = 0;
  Bytes payload;
  auto operator<=>(const Reported&) const = default;
};

/// Reads the messages, or the repeats.
std::vector<Reported> Read(const fs::path& file, bool repeated) {
  const auto reader = McapReader::Open(file).value();
  EXPECT_TRUE(reader.contents().complete);
  std::vector<Reported> reported;
  for (const auto& message : recording::MessagesOf(reader)) {
    const auto& channel = reader.contents().channels.at(message.channel_id);
    if (recording::StreamOf(channel)->repeated != repeated) continue;
    reported.push_back({channel.topic, message.sequence, message.log_time_ns,
                        message.publish_time_ns, message.payload});
  }
  return reported;
}

class RepeatedState : public ::testing::Test {
 protected:
  RepeatedState() : folder_(test::FreshFolder()) {
    options_.file = folder_ / "s.mcap";
    options_.split_ns = 10 * kSecondNs;
  }
  void Open() {
    series_.emplace(RecordingSeries::Open(options_, 0).value());
    values_ = series_->AddStream(recording::StatusStream(), types_);
    ends_ = series_->AddStream(recording::StatusStream(SampleKind::kDisposed), types_);
    Stream passing = recording::StatusStream();
    passing.topic = "Passing";
    passing.qos["durability"] = "volatile";
    passing_ = series_->AddStream(passing, types_);
  }
  /// At a time in seconds, sent a millisecond before.
  void Send(double at_s, std::uint32_t stream, const Bytes& payload) {
    const auto at_ns = static_cast<std::uint64_t>(at_s * 1e9);
    series_->Write(stream, at_ns, at_ns - 1'000'000, payload);
  }
  fs::path File(std::uint32_t number) const { return PathOf(options_.file, number); }
  fs::path Merge(const std::vector<std::uint32_t>& numbers, std::uint64_t messages,
                 std::uint64_t repeats) {
    std::vector<McapReader> readers;
    for (const std::uint32_t number : numbers)
      readers.push_back(McapReader::Open(File(number)).value());
    const auto report = recording::CopyRecordings(readers, folder_ / "merged.mcap", {});
    EXPECT_EQ(report.value().message_count, messages);
    EXPECT_EQ(report.value().repeat_count, repeats);
    return folder_ / "merged.mcap";
  }
  /// Three files: instances 1 and 2 live on, 3 ends, 2 changes in the second file.
  void RecordThree() {
    Open();
    Send(1, values_, StatusOf(1, 10));
    Send(2, values_, StatusOf(2, 20));
    Send(3, values_, StatusOf(3, 30));
    Send(4, values_, StatusOf(1, 11));
    Send(5, passing_, StatusOf(9, 90));
    Send(6, ends_, StatusKeyOf(3));
    series_->Turn(10 * kSecondNs);
    Send(12, values_, StatusOf(2, 21));
    Send(13, passing_, StatusOf(9, 91));
    series_->Turn(20 * kSecondNs);
    Send(22, values_, StatusOf(1, 12));
    ASSERT_TRUE(series_->Close());
  }

  fs::path folder_;
  SeriesOptions options_;
  std::optional<RecordingSeries> series_;
  StreamTypes types_{recording::kStatusIdl,
                     recording::kStatusKeyIdl,
                     {{"name", "m::Status"}, {"keys", recording::kStatusKeys}}};
  std::uint32_t values_ = 0, ends_ = 0, passing_ = 0;
};

constexpr std::uint64_t kMs = 1'000'000;

TEST_F(RepeatedState, EveryFileBeginsWithTheNewestOfWhatLives) {
  RecordThree();
  EXPECT_THAT(Read(File(1), true), IsEmpty());
  EXPECT_THAT(
      Read(File(2), true),
      ElementsAre(
          Reported{"Status", 1, 10 * kSecondNs, 2 * kSecondNs - kMs, StatusOf(2, 20)},
          Reported{"Status", 3, 10 * kSecondNs, 4 * kSecondNs - kMs, StatusOf(1, 11)}));
  EXPECT_THAT(
      Read(File(3), true),
      ElementsAre(
          Reported{"Status", 3, 20 * kSecondNs, 4 * kSecondNs - kMs, StatusOf(1, 11)},
          Reported{"Status", 4, 20 * kSecondNs, 12 * kSecondNs - kMs, StatusOf(2, 21)}));
  EXPECT_THAT(Read(File(2), false), SizeIs(2));
  EXPECT_THAT(Read(File(3), false), SizeIs(1));
  EXPECT_EQ(series_->message_count(), 9u);
  // With all that a replay of this file alone needs.
  const auto reader = McapReader::Open(File(3)).value();
  EXPECT_THAT(*reader.ReadMetadata(recording::kTypeRecord), SizeIs(1));
  for (const auto& [id, channel] : reader.contents().channels)
    EXPECT_EQ(reader.SchemaOf(channel)->text, recording::kStatusIdl);
}

TEST_F(RepeatedState, AMergedSeriesIsTheUnsplitRecording) {
  RecordThree();
  const auto merged = Read(Merge({3, 1, 2}, 9, 4), false);
  EXPECT_THAT(Read(folder_ / "merged.mcap", true), IsEmpty());
  options_.file = folder_ / "whole.mcap";
  options_.split_ns = 0;
  RecordThree();
  EXPECT_EQ(merged, Read(options_.file, false));
}

TEST_F(RepeatedState, WhatNoSourceHasFromBeforeStaysRepeated) {
  RecordThree();
  const auto merged = Merge({2, 3}, 5, 2);
  EXPECT_EQ(Read(merged, true), Read(File(2), true));
  EXPECT_THAT(Read(merged, false), SizeIs(3));
  // The second file is gone: its state is known from the third only.
  const auto gap = Merge({1, 3}, 8, 1);
  ASSERT_THAT(Read(gap, true), SizeIs(1));
  EXPECT_EQ(Read(gap, true)[0].payload, StatusOf(2, 21));
}

// The recorder's queue may still hold what came before the file was begun.
TEST_F(RepeatedState, NothingInTheFileIsEarlier) {
  Open();
  Send(1, values_, StatusOf(1, 10));
  series_->Turn(10 * kSecondNs);
  Send(9.9, values_, StatusOf(1, 11));
  ASSERT_TRUE(series_->Close());
  const auto repeats = Read(File(2), true);
  ASSERT_THAT(repeats, SizeIs(1));
  EXPECT_EQ(repeats[0].log_time_ns, 9'900 * kMs);
  const auto all = recording::MessagesOf(McapReader::Open(File(2)).value());
  ASSERT_THAT(all, SizeIs(2));
  EXPECT_EQ(all[0].payload, StatusOf(1, 10));
  EXPECT_EQ(all[1].payload, StatusOf(1, 11));
}

TEST_F(RepeatedState, AQuietFileHasItToo) {
  Open();
  Send(1, values_, StatusOf(1, 10));
  series_->Turn(10 * kSecondNs);
  series_->Turn(11 * kSecondNs);
  series_->Turn(12 * kSecondNs);  // half of what is written a second after its log time
  EXPECT_EQ(McapReader::Open(File(2))->contents().statistics.message_count, 1u);
  series_->Turn(20 * kSecondNs);
  ASSERT_TRUE(series_->Close());
  for (const std::uint32_t number : {2u, 3u}) {
    EXPECT_THAT(Read(File(number), true), SizeIs(1)) << number;
    EXPECT_THAT(Read(File(number), false), IsEmpty()) << number;
  }
}

TEST_F(RepeatedState, IsBoundedAndReportsWhatItForgot) {
  options_.retained_bytes = 20'000;
  options_.writer.compress = false;
  Open();
  for (std::uint32_t id = 0; id < 100; ++id)
    Send(1 + 0.01 * id, values_, StatusOf(id, id, 1000));
  series_->Turn(10 * kSecondNs);
  ASSERT_TRUE(series_->Close());
  const auto repeats = Read(File(2), true);
  EXPECT_LT(fs::file_size(File(2)), 25'000u);
  ASSERT_GE(repeats.size(), 10u);
  EXPECT_EQ(repeats.back().payload, StatusOf(99, 99, 1000));
  const auto reader = McapReader::Open(File(2)).value();
  const auto forgotten = reader.ReadMetadata(recording::kForgottenRecord).value();
  ASSERT_THAT(forgotten, SizeIs(1));
  EXPECT_EQ(forgotten[0].entries.at("count"), std::to_string(100 - repeats.size()));
  EXPECT_EQ(forgotten[0].entries.at("file_number"), "2");
}

// More state than a file holds must not make one file after the other.
TEST_F(RepeatedState, LeavesAFileRoomForWhatIsNew) {
  options_.split_ns = 0;
  options_.split_bytes = 50'000;
  options_.writer.compress = false;
  Open();
  for (std::uint32_t i = 0; i < 300; ++i) {
    Send(1 + i, values_, StatusOf(i, i, 1000));
    series_->Turn((1 + i) * kSecondNs);
  }
  ASSERT_TRUE(series_->Close());
  EXPECT_LE(FilesOf(options_.file).size(), 300u * 1100 / 25'000 + 1);
}

}  // namespace
}  // namespace intaglio::recorder
