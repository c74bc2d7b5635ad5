#include "services/history/message_csv.h"

#include <gtest/gtest.h>

#include "engrave/io/csv.h"
#include "proto/shop.pb.h"

namespace intaglio::history {
namespace {

// What is written reads back by the product's own reader of tables.
TEST(MessageCsv, ReadsBack) {
  JobStatistics job;
  job.set_job(12);
  job.set_name("cup, \"Anna\";\nsecond line");
  job.set_duration_s(12.5);
  job.set_priority(-3);
  job.add_warnings()->set_text("3 of 9 rays, \"odd\"");
  job.add_warnings()->set_text("may break");
  const auto table = io::ParseCsv(CsvHeader(*JobStatistics::descriptor()) + CsvLine(job));
  ASSERT_TRUE(table.has_value()) << table.error().message;
  ASSERT_EQ(table->rows.size(), 1u);
  EXPECT_EQ(*table->Find(table->rows[0], "job"), "12");
  EXPECT_EQ(*table->Find(table->rows[0], "name"), job.name());
  EXPECT_EQ(*table->Find(table->rows[0], "duration_s"), "12.5");
  EXPECT_EQ(*table->Find(table->rows[0], "priority"), "-3");
  EXPECT_EQ(*table->Find(table->rows[0], "recording"), "");
  EXPECT_EQ(*table->Find(table->rows[0], "warnings"), "3 of 9 rays, \"odd\"; may break");
}

TEST(MessageCsv, AFormulaIsAText) {
  for (const std::string name :
       {"=HYPERLINK(\"http://x\")", "+1", "-1", "@SUM(A1)", "\t=1"}) {
    JobStatistics job;
    job.set_name(name);
    job.set_message("x = 1");
    job.set_priority(-3);
    job.add_warnings()->set_text("=1");
    const auto table =
        io::ParseCsv(CsvHeader(*JobStatistics::descriptor()) + CsvLine(job));
    ASSERT_TRUE(table.has_value()) << name;
    EXPECT_EQ(*table->Find(table->rows[0], "name"), "'" + name);
    EXPECT_EQ(*table->Find(table->rows[0], "message"), "x = 1");
    EXPECT_EQ(*table->Find(table->rows[0], "priority"), "-3") << "a number stays one";
    EXPECT_EQ(*table->Find(table->rows[0], "warnings"), "'=1");
  }
}

}  // namespace
}  // namespace intaglio::history
