#include "engrave/io/csv.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "tests/test_folder.h"

namespace intaglio::io {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

CsvTable Parsed(std::string_view text) {
  auto table = ParseCsv(text);
  EXPECT_TRUE(table.has_value()) << table.error().message;
  return table ? *table : CsvTable{};
}

void ExpectError(std::string_view text, ErrorCode code, const char* part,
                 const CsvLimits& limits = {}) {
  const auto table = ParseCsv(text, limits);
  ASSERT_FALSE(table.has_value()) << text;
  EXPECT_EQ(table.error().code, code);
  EXPECT_THAT(table.error().message, HasSubstr(part));
}

TEST(Csv, GivesTheFieldsOfARowByName) {
  const CsvTable table = Parsed("name,text\nAnna,Zum 50.\r\nBert,\"Smith, J.\"\n");
  EXPECT_THAT(table.names, ElementsAre("name", "text"));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(*table.Find(table.rows[0], "name"), "Anna");
  EXPECT_EQ(*table.Find(table.rows[1], "text"), "Smith, J.");
  EXPECT_EQ(table.Find(table.rows[1], "colour"), nullptr);
  EXPECT_EQ(table.rows[1].line_number, 3u);
}

TEST(Csv, TakesWhatSpreadsheetsWrite) {
  // A byte order mark, semicolons, decimal commas, quotes, line ends and empty lines.
  const CsvTable table = Parsed(
      "\xEF\xBB\xBF name ;\"height; mm\";note\r\nJosé;1,5;\"say \"\"hi\"\"\r\nto "
      "all\"\r\n"
      "\r\n Zoë ;;\"\"");
  EXPECT_THAT(table.names, ElementsAre("name", "height; mm", "note"));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_THAT(table.rows[0].fields, ElementsAre("José", "1,5", "say \"hi\"\r\nto all"));
  EXPECT_THAT(table.rows[1].fields, ElementsAre(" Zoë ", "", ""));
  EXPECT_EQ(table.rows[1].line_number, 5u) << "lines are counted inside quotes too";
  EXPECT_THAT(Parsed("name\nAnna\nBert").rows[1].fields, ElementsAre("Bert"));
}

// As a spreadsheet copies cells, or saves "text (tab delimited)".
TEST(Csv, TakesTabs) {
  const CsvTable table = Parsed("name\ttext, one line\r\nAnna\t\"1\t2\"\r\nBert\t\r\n");
  EXPECT_THAT(table.names, ElementsAre("name", "text, one line"));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_THAT(table.rows[0].fields, ElementsAre("Anna", "1\t2"));
  EXPECT_THAT(table.rows[1].fields, ElementsAre("Bert", ""));
}

// "CSV (Macintosh)".
TEST(Csv, TakesLinesThatEndWithCrAlone) {
  const CsvTable table = Parsed("name;year\rAnna;1999\r\rBert;2001");
  EXPECT_THAT(table.names, ElementsAre("name", "year"));
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_THAT(table.rows[1].fields, ElementsAre("Bert", "2001"));
  EXPECT_EQ(table.rows[1].line_number, 4u);
}

TEST(Csv, ReadsBackWhateverIsQuoted) {
  std::mt19937 random(8);
  constexpr std::string_view kLetters = "ab,;\"\n\r \xC3\xA9";
  for (int run = 0; run < 200; ++run) {
    std::vector<std::vector<std::string>> rows(1 + random() % 5);
    std::string text = "one,two,three\n";
    for (auto& row : rows) {
      row.resize(3);
      for (int f = 0; f < 3; ++f) {
        for (unsigned i = random() % 6; i > 0; --i) {
          row[f] += kLetters[random() % kLetters.size()];
        }
        text += '"';
        for (const char c : row[f]) text += c == '"' ? "\"\"" : std::string(1, c);
        text += f < 2 ? "\"," : "\"\r\n";
      }
    }
    const CsvTable table = Parsed(text);
    ASSERT_EQ(table.rows.size(), rows.size());
    for (std::size_t r = 0; r < rows.size(); ++r)
      EXPECT_EQ(table.rows[r].fields, rows[r]);
  }
}

TEST(Csv, ReadsBackEveryField) {
  EXPECT_EQ(CsvField("plain text"), "plain text");
  EXPECT_EQ(CsvField("say \"hi\""), "\"say \"\"hi\"\"\"");
  std::mt19937 random(9);
  constexpr std::string_view kLetters = "ab,;\t\"\n\r \xC3\xA9";
  for (int run = 0; run < 500; ++run) {
    std::string first, second;
    for (unsigned i = random() % 6; i > 0; --i)
      first += kLetters[random() % kLetters.size()];
    for (unsigned i = random() % 6; i > 0; --i)
      second += kLetters[random() % kLetters.size()];
    for (const char* separator : {",", ";", "\t"}) {
      const CsvTable table =
          Parsed(fmt::format("one{0}two{0}three\n1{0}{1}{0}{2}\n", separator,
                             CsvField(first), CsvField(second)));
      ASSERT_EQ(table.rows.size(), 1u);
      EXPECT_THAT(table.rows[0].fields, ElementsAre("1", first, second));
    }
  }
}

TEST(Csv, ReportsWhatIsWrongAndWhere) {
  ExpectError("", ErrorCode::kMissing, "it is empty");
  ExpectError("\n\n", ErrorCode::kMissing, "it is empty");
  ExpectError("a,,c\n", ErrorCode::kMissing, "line 1: column 2 has no name");
  ExpectError("a,b, a\n", ErrorCode::kInvalidValue, "two columns are named 'a'");
  ExpectError("a,b\n1,2\n1,2,3\n", ErrorCode::kUnreadable, "line 3 has 3 fields for 2");
  ExpectError("a,b\n\n1\n", ErrorCode::kUnreadable, "line 3 has 1 field for 2");
  ExpectError("a,b\n1,2\"x\n", ErrorCode::kUnreadable, "line 2 has a quote inside");
  ExpectError("a,b\n\"1\"x,2\n", ErrorCode::kUnreadable, "line 2 has text behind");
  ExpectError("a,b\n1,2\n3,\"4\n5,6\n", ErrorCode::kUnreadable,
              "line 3 has an opening quote");
  ExpectError(std::string_view("a\n1\0\n", 5), ErrorCode::kUnreadable, "a NUL byte");
}

TEST(Csv, KeepsItsLimits) {
  CsvLimits limits;
  limits.max_rows = 2;
  limits.max_columns = 2;
  limits.max_field_bytes = 3;
  EXPECT_TRUE(ParseCsv("a,b\n123,2\n\"123\",4\n", limits).has_value());
  ExpectError("a,b\n1,2\n3,4\n5,6\n", ErrorCode::kTooLarge, "the 2 rows", limits);
  ExpectError("a,b,c\n", ErrorCode::kTooLarge, "the 2 columns", limits);
  ExpectError("a,b\n1234,2\n", ErrorCode::kTooLarge, "line 2 has a field", limits);
  ExpectError("a,b\n\"1234\",2\n", ErrorCode::kTooLarge, "line 2 has a field", limits);
}

TEST(Csv, ErrorsNameTheFile) {
  const auto file = test::FreshFolder() / "series.csv";
  std::ofstream(file) << "a,b\n1\n";
  EXPECT_THAT(ReadCsv(file).error().message,
              HasSubstr("series.csv: line 2 has 1 field "));
  EXPECT_EQ(ReadCsv("/nonexistent.csv").error().code, ErrorCode::kNotFound);
}

}  // namespace
}  // namespace intaglio::io
