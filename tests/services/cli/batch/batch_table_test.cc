#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>
#include <string>
#include <vector>

#include "services/cli/batch/batch_run.h"

namespace intaglio::cli {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

BatchJobResult& Add(BatchResults& results, const char* id, const std::string& name) {
  BatchJobResult& job = *results.add_jobs();
  job.set_id(id);
  job.set_name(name);
  job.set_cell("els-03");
  job.set_state("done");
  return job;
}

TEST(BatchTable, ShowsEveryJobWithItsName) {
  BatchResults results;
  Add(results, "1", "cup of Anna");
  Add(results, "2", "cup of Zoë");
  const auto lines = LinesOf(TableOf(results));
  ASSERT_EQ(lines.size(), 4u);
  EXPECT_THAT(lines[0], HasSubstr("id  name"));
  EXPECT_THAT(lines[1], HasSubstr("1   cup of Anna    -  els-03"));
  EXPECT_THAT(lines[2], HasSubstr("2   cup of Zoë     -  els-03"))
      << "a character of two bytes takes one column";
}

TEST(BatchTable, AVerdictWithWarningsIsCountedForItselfAndNotAFailure) {
  BatchResults results;
  Add(results, "1", "cup").set_verdict("good_with_warnings");
  results.set_good_with_warnings(1);
  const std::string table = TableOf(results);
  EXPECT_THAT(table, HasSubstr("good_with_warnings"));
  EXPECT_THAT(table, HasSubstr(": 1 good with warnings\n"));
  EXPECT_EQ(ExitCodeOf(results, false), 0);
}

TEST(BatchTable, ALongNameOrOneOfTwoLinesStaysInItsColumn) {
  BatchResults results;
  Add(results, "1", "first\nsecond");
  Add(results, "2", std::string(31, 'a') + "ëb and more");
  const std::string table = TableOf(results);
  EXPECT_THAT(table, HasSubstr("first second"));
  EXPECT_THAT(table, HasSubstr(std::string(31, 'a') + "ë..."));
  EXPECT_THAT(table, Not(HasSubstr("and more")));
}

}  // namespace
}  // namespace intaglio::cli
