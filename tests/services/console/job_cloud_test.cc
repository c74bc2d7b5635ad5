#include "services/console/job_cloud.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <future>

#include "engrave/formats/journal_file.h"
#include "engrave/formats/point_file.h"
#include "services/console/cloud_reader.h"
#include "tests/services/console/packed_plan.h"
#include "tests/test_folder.h"

namespace intaglio::console {
namespace {

using ::testing::HasSubstr;

/// A new folder of a job with a plan of `count` points on a line.
std::filesystem::path FolderWithPlan(const std::filesystem::path& folder, int count) {
  std::filesystem::create_directory(folder);
  formats::PointTable plan;
  for (int i = 0; i < count; ++i) plan.points_mm.push_back({0.001 * i, 25, 15});
  plan.columns.push_back(
      {"source", std::vector<std::uint32_t>(plan.points_mm.size(), 7)});
  EXPECT_TRUE(formats::WritePly(folder / "path.ply", plan));
  std::ofstream(folder / "job.json")
      << R"({"job": {"block": {"size_mm": {"x": 50, "y": 50, "z": 30}}}})";
  return folder;
}

TEST(JobCloud, ReadsThePlanPieceByPiece) {
  const int count = 40000;  // several pieces
  const auto folder = FolderWithPlan(test::FreshFolder() / "pieces", count);
  PointList path;
  for (int i = 0; i < count; ++i) path.push_back({0.001 * i, 25, 15});
  const auto read = ReadPlan(folder);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(*read, *PackPlan(path, {50, 50, 30}));
  EXPECT_EQ(*PlanBytes(folder), read->size());
}

Result<CloudReader::Bytes> PlanOf(CloudReader& reader,
                                  const std::filesystem::path& folder) {
  std::promise<Result<CloudReader::Bytes>> answer;
  EXPECT_TRUE(reader.AskForPlan(
      folder, [&](Result<CloudReader::Bytes> bytes) { answer.set_value(bytes); }));
  return answer.get_future().get();
}

TEST(CloudReader, HasAPlanOnceForAllPages) {
  CloudReader reader;
  const auto jobs = test::FreshFolder();
  const auto one = FolderWithPlan(jobs / "one", 100);
  const auto other = FolderWithPlan(jobs / "other", 100);
  const auto first = PlanOf(reader, one), second = PlanOf(reader, one);
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->get(), second->get());
  ASSERT_TRUE(PlanOf(reader, other));
  EXPECT_EQ(PlanOf(reader, one)->get(), first->get()) << "it is still being sent";
}

// 64 MB: 3.2 million points and 2.4 million are more.
TEST(CloudReader, ReadsNoLargePlanWhileAnotherIsSent) {
  CloudReader reader;
  const auto jobs = test::FreshFolder();
  const auto one = FolderWithPlan(jobs / "one", 3'200'000);
  const auto other = FolderWithPlan(jobs / "other", 2'400'000);
  auto sent = PlanOf(reader, one);
  ASSERT_TRUE(sent);
  const auto refused = PlanOf(reader, other);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  EXPECT_EQ(PlanOf(reader, one)->get(), sent->get());
  sent->reset();
  EXPECT_TRUE(PlanOf(reader, other));
}

/// A journal whose last record is cut.
std::string JournalOf(const std::vector<formats::JournalRecord>& records) {
  std::string bytes;
  const auto append = [&](const auto& encoded) {
    bytes.append(reinterpret_cast<const char*>(encoded.data()), encoded.size());
  };
  append(formats::EncodeJournalHeader({.point_count = 10, .epoch = 1}));
  for (const auto& record : records) append(formats::EncodeJournalRecord(record));
  return bytes + "torn";
}

TEST(JobCloud, ReadsTheJournalPieceByPiece) {
  using formats::JournalKind;
  using formats::PointOutcome;
  const auto folder = test::FreshFolder();
  std::ofstream(folder / "journal.bin", std::ios::binary) << JournalOf(
      {{.kind = JournalKind::kIntent, .point = 3},
       {.kind = JournalKind::kOutcome, .outcome = PointOutcome::kMade, .point = 3},
       {.kind = JournalKind::kOutcome, .outcome = PointOutcome::kMissed, .point = 4}});
  const auto all = ReadMade(folder, 0);
  ASSERT_TRUE(all) << all.error().message;
  ASSERT_EQ(all->size(), 12u);
  EXPECT_EQ(At<std::uint32_t>(*all, 0), 3u);
  EXPECT_EQ(At<std::uint32_t>(*all, 4), 3u | 1u << 29);
  EXPECT_EQ(At<std::uint32_t>(*all, 8), 4u | 2u << 29);
  const auto rest = ReadMade(folder, 2);
  ASSERT_TRUE(rest);
  ASSERT_EQ(rest->size(), 8u);
  EXPECT_EQ(At<std::uint32_t>(*rest, 0), 3u);
  const auto nothing = ReadMade(folder, 3);
  ASSERT_TRUE(nothing);
  EXPECT_EQ(nothing->size(), 4u);
  EXPECT_EQ(At<std::uint32_t>(*nothing, 0), 3u);
}

TEST(JobCloud, ReadsTheTicksOfWhatFired) {
  using formats::JournalKind;
  using formats::PointOutcome;
  const auto folder = test::FreshFolder();
  std::ofstream(folder / "journal.bin", std::ios::binary)
      << JournalOf({{.kind = JournalKind::kIntent, .tick = 6, .point = 3},
                    {.kind = JournalKind::kOutcome,
                     .outcome = PointOutcome::kMade,
                     .tick = 0x500000007,
                     .point = 3},
                    {.kind = JournalKind::kSession, .point = 77},
                    {.kind = JournalKind::kOutcome,
                     .outcome = PointOutcome::kSkipped,
                     .tick = 8,
                     .point = 4},
                    {.kind = JournalKind::kOutcome,
                     .outcome = PointOutcome::kMissed,
                     .tick = 9,
                     .point = 5}});
  const auto all = ReadTicks(folder, 0);
  ASSERT_TRUE(all) << all.error().message;
  ASSERT_EQ(all->size(), 4u + 3 * 8);
  std::vector<std::uint32_t> numbers;
  for (std::size_t at = 0; at < all->size(); at += 4)
    numbers.push_back(At<std::uint32_t>(*all, at));
  EXPECT_THAT(numbers, ::testing::ElementsAre(5u, 3u, 7u, kPowerUp, 0u, 5u, 9u));
  EXPECT_EQ(ReadTicks(folder, 4)->size(), 4u + 8);
}

TEST(JobCloud, ReadsTheChannelsOfThePoints) {
  const auto folder = test::FreshFolder();
  const std::uint32_t count = 40000;  // several pieces
  formats::PointTable plan;
  std::vector<std::uint32_t> sources;
  for (std::uint32_t i = 0; i < count; ++i) {
    plan.points_mm.push_back({0.001 * i, 25, 15});
    sources.push_back(i % 3 == 0 ? 1 : 0);
  }
  plan.columns.push_back({"source", sources});
  ASSERT_TRUE(formats::WritePly(folder / "path.ply", plan));
  std::ofstream(folder / "job.json")
      << R"({"job": {"models": [{"channels": [1]}, {"channels": [2, 4]}]}})";
  const auto channels = ReadChannels(folder);
  ASSERT_TRUE(channels) << channels.error().message;
  ASSERT_EQ(channels->size(), count);
  for (std::uint32_t i = 0; i < count; ++i)
    ASSERT_EQ((*channels)[i], i % 3 == 0 ? 0b1010 : 0b0001) << i;
}

TEST(JobCloud, NamesWhatIsNotThere) {
  const auto plan = ReadPlan(test::FreshFolder());
  ASSERT_FALSE(plan);
  EXPECT_EQ(plan.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(plan.error().message, HasSubstr("path.ply"));
  EXPECT_FALSE(ReadMade(test::FreshFolder("none"), 0));
}

}  // namespace
}  // namespace intaglio::console
