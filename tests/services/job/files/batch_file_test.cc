#include "services/job/files/batch_file.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "tests/services/job/test_job.h"
#include "tests/test_folder.h"

namespace intaglio {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string Mistakes(const Result<std::vector<BatchLine>>& lines) {
  EXPECT_FALSE(lines.has_value());
  return lines ? "" : lines.error().message;
}

std::string OrderMistakes(const std::string& csv) {
  std::string all;
  for (const Error& error : CheckBatchOrder(ParseBatchCsv(csv).value())) {
    all += error.message + "\n";
  }
  return all;
}

TEST(BatchFile, JsonLinesAndCsvReportTheSame) {
  const auto json = ParseBatchJson(
      R"({"id":"a","job":"cup.textproto","overrides":{"block.margin_mm":4.5,)"
      R"("glass":"K8","block.clip":true,"laser.channels":[1,2]},"priority":3})"
      "\n\n"
      R"({"job":"cup.textproto","after":["a"],"cell":"left"})"
      "\r\n");
  const auto csv = ParseBatchCsv(
      "id,job,after,cell,block.margin_mm,glass,block.clip,laser.channels,priority\n"
      "a,cup.textproto,,,4.5,K8,true,1 2,3\n"
      ",cup.textproto, a ,left,,,,,\n");
  for (const auto* lines : {&json, &csv}) {
    ASSERT_TRUE(lines->has_value()) << lines->error().message;
    ASSERT_EQ((*lines)->size(), 2u);
    const BatchLine& first = (**lines)[0];
    EXPECT_EQ(first.id, "a");
    EXPECT_EQ(first.job_file, "cup.textproto");
    EXPECT_THAT(first.after, IsEmpty());
    const auto job = JobOf(first, GoodJob(), "/");
    ASSERT_TRUE(job.has_value()) << job.error().message;
    EXPECT_EQ(job->block().margin_mm(), 4.5);
    EXPECT_EQ(job->glass(), "K8");
    EXPECT_TRUE(job->block().clip());
    EXPECT_THAT(job->laser().channels(), ElementsAre(1, 2));
    EXPECT_EQ(job->priority(), 3);
    EXPECT_EQ(job->name(), GoodJob().name() + " a") << "told apart by its id";
    const BatchLine& second = (**lines)[1];
    EXPECT_EQ(second.id, "2") << "its number, when it has none";
    EXPECT_THAT(second.after, ElementsAre("a"));
    EXPECT_EQ(second.cell, "left");
    EXPECT_EQ(JobOf(second, GoodJob(), "/")->priority(), GoodJob().priority());
  }
  EXPECT_EQ((*json)[1].line_number, 3u);
}

TEST(BatchFile, AByteOrderMarkIsNoPartOfTheFirstJob) {
  const auto lines =
      ParseBatchJson("\xEF\xBB\xBF{\"id\":\"a\",\"job\":\"cup.textproto\"}\r\n");
  ASSERT_TRUE(lines.has_value()) << lines.error().message;
  EXPECT_EQ(lines->front().id, "a");
}

TEST(BatchFile, EveryMistakeIsReportedWithItsLine) {
  const std::string message =
      Mistakes(ParseBatchJson("{\"id\":\"a b\"}\n"
                              "{\"idd\":\"x\"}\n"
                              "{\"id\":\"ok\"}\n"
                              "not json\n"
                              "{\"overrides\":{\"block\":{\"margin_mm\":5}}}\n"
                              "{\"overrides\":{\"glass\":null}}\n"));
  EXPECT_THAT(message, HasSubstr("line 1: id 'a b'"));
  EXPECT_THAT(message, AllOf(HasSubstr("line 2: "), HasSubstr("idd"),
                             HasSubstr("Did you mean id?")));
  EXPECT_THAT(message, HasSubstr("line 4: "));
  EXPECT_THAT(message, HasSubstr("line 5: overrides.block: "));
  EXPECT_THAT(message, HasSubstr("\"block.margin_mm\": 5"));
  EXPECT_THAT(message, HasSubstr("line 6: overrides.glass"));
  EXPECT_THAT(message, testing::Not(HasSubstr("line 3")));
}

TEST(BatchFile, OrdersThatCannotBeKeptAreRefused) {
  EXPECT_EQ(OrderMistakes("id,after\na,\nb,a\nc,a b\n"), "");
  EXPECT_THAT(OrderMistakes("id,after\na,x\nb,\n"),
              HasSubstr("line 2: after 'x': no job of this file has that id"));
  EXPECT_THAT(OrderMistakes("id,after\na,\na,\n"),
              HasSubstr("line 3: id 'a': is already used in line 2"));
  EXPECT_THAT(OrderMistakes("id,after\na,a\n"), HasSubstr("a after a;"));
  const std::string circle = OrderMistakes("id,after\na,c\nb,a\nc,b\nd,c\n");
  EXPECT_THAT(circle, HasSubstr("in a cycle, a after "));
  EXPECT_THAT(circle, testing::Not(HasSubstr("line 3"))) << "one circle is told once";
  EXPECT_THAT(circle, testing::Not(HasSubstr("line 5"))) << "who waits for it is no part";
}

// A long chain is no circle, and costs no stack.
TEST(BatchFile, TenThousandJobsInARow) {
  std::string csv = "id,after\n0,\n";
  for (int i = 1; i < 10'000; ++i) {
    csv += std::to_string(i) + "," + std::to_string(i - 1) + "\n";
  }
  const auto lines = ParseBatchCsv(csv);
  ASSERT_TRUE(lines.has_value()) << lines.error().message;
  EXPECT_THAT(CheckBatchOrder(*lines), IsEmpty());
  EXPECT_EQ(ParseBatchCsv(csv + "x,\n").error().code, ErrorCode::kTooLarge);
}

TEST(BatchFile, FilesAreNamedWithTheirEnding) {
  namespace fs = std::filesystem;
  const fs::path folder = test::FreshFolder();
  const auto write = [&](const char* name, const char* text) {
    std::ofstream(folder / name) << text;
    return ReadBatchFile(folder / name);
  };
  EXPECT_TRUE(write("a.jsonl", "{}\n"));
  EXPECT_TRUE(write("a.csv", "id\nx\n"));
  EXPECT_THAT(Mistakes(write("b.jsonl", "{\n}\n")), HasSubstr("b.jsonl, line 1: "));
  EXPECT_THAT(Mistakes(write("a.txt", "{}\n")), HasSubstr(".jsonl"));
  EXPECT_EQ(write("empty.jsonl", "\n").error().code, ErrorCode::kMissing);
  EXPECT_EQ(ReadBatchFile(folder / "absent.csv").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace intaglio
