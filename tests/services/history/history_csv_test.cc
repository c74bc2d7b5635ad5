#include "services/history/history_csv.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "engrave/io/csv.h"
#include "services/job_service/job_store.h"
#include "tests/test_folder.h"

namespace intaglio::history {
namespace {

constexpr std::size_t kAny = std::size_t(-1);

class HistoryCsvTest : public testing::Test {
 protected:
  HistoryCsvTest() : path_(test::FreshFolder() / "jobs.db"), store_(path_) {
    for (int number = 1; number <= 50; ++number) {
      job_service::JobRecord job;
      job.number = static_cast<std::uint32_t>(number);
      job.uid = fmt::format("{}-abc", number);
      job.submission_uid = fmt::format("s{}", number);
      job.name = number == 7 ? "=1+2, \"seven\"" : "cup";
      job.cell = "left";
      job.state = intaglio_JOB_DONE;
      store_.Keep(job);
      store_.KeepVerdict(job.uid, "", "");
    }
    SQLite::Database(path_.string(), SQLite::OPEN_READWRITE)
        .exec(
            "UPDATE jobs SET ended_utc = "
            "CASE WHEN number < 11 THEN '2026-11-20T10:00:00.000Z' "
            "ELSE '2026-11-21T10:00:00.000Z' END");
  }
  io::CsvTable Table(const Filter& filter, CsvRows rows) {
    const auto text = HistoryCsv(path_, filter, rows, kAny);
    EXPECT_TRUE(text.has_value()) << text.error().message;
    return *io::ParseCsv(*text);
  }
  std::filesystem::path path_;
  job_service::JobStore store_;
};

TEST_F(HistoryCsvTest, HasARowForEachJob) {
  const auto table = Table({.until = "2026-11-20"}, CsvRows::kJobs);
  ASSERT_EQ(table.rows.size(), 10u);
  EXPECT_EQ(*table.Find(table.rows[6], "job"), "7");
  EXPECT_EQ(*table.Find(table.rows[6], "name"), "'=1+2, \"seven\"");
  EXPECT_EQ(*table.Find(table.rows[6], "state"), "done");
}

TEST_F(HistoryCsvTest, OrForEachDayAndMachine) {
  const auto table = Table({}, CsvRows::kDays);
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(*table.Find(table.rows[0], "day"), "2026-11-20");
  EXPECT_EQ(*table.Find(table.rows[0], "cell"), "left");
  EXPECT_EQ(*table.Find(table.rows[0], "pieces"), "10");
  EXPECT_EQ(*table.Find(table.rows[1], "pieces"), "40");
  EXPECT_EQ(*table.Find(table.rows[1], "good"), "0");
  EXPECT_EQ(*table.Find(table.rows[1], "unknown"), "40") << "no report has said";
}

TEST_F(HistoryCsvTest, NoMoreThanItsLimitIsKept) {
  for (const CsvRows rows : {CsvRows::kJobs, CsvRows::kDays}) {
    const auto all = HistoryCsv(path_, {}, rows, kAny);
    EXPECT_EQ(HistoryCsv(path_, {}, rows, all->size()).value(), *all);
    const auto cut = HistoryCsv(path_, {}, rows, all->size() - 1);
    ASSERT_FALSE(cut.has_value());
    EXPECT_EQ(cut.error().code, ErrorCode::kTooLarge);
    EXPECT_THAT(cut.error().message, testing::HasSubstr("since and until"));
  }
  EXPECT_EQ(HistoryCsv(path_.string() + "x", {}, CsvRows::kJobs, kAny).error().code,
            ErrorCode::kNotFound);
}

}  // namespace
}  // namespace intaglio::history
