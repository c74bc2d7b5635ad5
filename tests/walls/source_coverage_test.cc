// docs/source_coverage*.md against the tree: its counts, its files and its tests.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>
#include <vector>

#include "tests/test_name.h"
#include "tests/walls/tree_files.h"

namespace intaglio::walls {
namespace {

namespace fs = std::filesystem;

/// The cells of a row of a table; "\|" is a character.
std::vector<std::string> CellsOf(const std::string& row) {
  std::vector<std::string> cells(1);
  for (std::size_t i = 1; i < row.size(); ++i) {
    if (row[i] == '|' && row[i - 1] != '\\') {
      cells.emplace_back();
    } else {
      cells.back() += row[i];
    }
  }
  cells.pop_back();
  for (std::string& cell : cells) {
    const auto begin = cell.find_first_not_of(' ');
    cell = begin == std::string::npos
               ? ""
               : cell.substr(begin, cell.find_last_not_of(' ') - begin + 1);
  }
  return cells;
}

struct Item {
  std::string chapter, state, files, tests, text;
};

class SourceCoverage : public ::testing::TestWithParam<const char*> {
 protected:
  std::string Document() const { return TextOfFile(kRoot / GetParam()); }
  std::vector<Item> Items() const;
};

std::vector<Item> SourceCoverage::Items() const {
  std::vector<Item> items;
  std::istringstream document(Document());
  std::string line, chapter;
  while (std::getline(document, line)) {
    if (line.starts_with("## ")) chapter = line.substr(3);
    if (!line.starts_with("|") || chapter.empty()) continue;
    const auto cells = CellsOf(line);
    if (cells.size() != 6 || cells[0] == "place" || cells[0].starts_with("---")) continue;
    items.push_back({chapter, cells[2], cells[3], cells[4], line});
  }
  return items;
}

std::vector<std::string> QuotedIn(const std::string& cell) {
  static const std::regex kQuoted("`([^`]+)`");
  std::vector<std::string> quoted;
  for (auto it = std::sregex_iterator(cell.begin(), cell.end(), kQuoted);
       it != std::sregex_iterator(); ++it)
    quoted.push_back((*it)[1]);
  return quoted;
}

using Counts = std::map<std::string, int>;

constexpr const char* kStates[] = {"works", "in tests only", "partly", "missing",
                                   "left out"};

std::string RowOf(Counts counts) {
  int sum = 0;
  std::string row;
  for (const char* state : kStates) {
    sum += counts[state];
    row += fmt::format(" {} |", counts[state]);
  }
  return fmt::format("| {} |{}", sum, row);
}

TEST_P(SourceCoverage, ItsCountsAreThoseOfItsRows) {
  std::map<std::string, Counts> chapters;
  Counts all;
  for (const Item& item : Items()) {
    ++chapters[item.chapter][item.state];
    ++all[item.state];
  }
  for (const auto& [state, unused] : all) {
    EXPECT_NE(std::find(std::begin(kStates), std::end(kStates), state), std::end(kStates))
        << state << " is none of the five states";
  }
  const std::string document = Document();
  for (const auto& [chapter, counts] : chapters) {
    EXPECT_NE(document.find("| " + chapter + " " + RowOf(counts) + "\n"),
              std::string::npos)
        << chapter << " " << RowOf(counts);
  }
  const std::string sentence = fmt::format(
      "**{} items: {} work, {} only in tests, {} work in part, {} are missing, {} are "
      "left "
      "out.**",
      Items().size(), all["works"], all["in tests only"], all["partly"], all["missing"],
      all["left out"]);
  EXPECT_NE(document.find(sentence), std::string::npos) << sentence;
}

TEST_P(SourceCoverage, WhatWorksHasAFileAndATest) {
  for (const Item& item : Items()) {
    if (item.state != "works" && item.state != "in tests only") continue;
    EXPECT_FALSE(item.files.empty()) << item.text;
    EXPECT_FALSE(item.tests.empty()) << item.text;
  }
}

// What lies in tests/ alone is in no program; it does not count as working.
TEST_P(SourceCoverage, WhatIsInTestsOnlyIsMarked) {
  for (const Item& item : Items()) {
    const auto files = QuotedIn(item.files);
    if (files.empty()) continue;
    const bool in_tests =
        std::all_of(files.begin(), files.end(),
                    [](const std::string& file) { return file.starts_with("tests/"); });
    EXPECT_EQ(in_tests, item.state == "in tests only") << item.text;
  }
}

TEST_P(SourceCoverage, ItsFilesAndTestsExist) {
  // "Suite.Test", with a parameter "Test/Name".
  static const std::regex kTest(
      "(?:[A-Za-z0-9_]+\\.)?([A-Za-z0-9_]+)(?:/[A-Za-z0-9_]+)?");
  for (const Item& item : Items()) {
    for (const std::string& file : QuotedIn(item.files)) {
      if (file.find('/') == std::string::npos) continue;
      EXPECT_TRUE(fs::exists(kRoot / file)) << file << "\n" << item.text;
    }
    std::string tests_of, name;
    for (const std::string& quoted : QuotedIn(item.tests)) {
      if (quoted.ends_with(".cc")) {
        EXPECT_TRUE(fs::exists(kRoot / quoted)) << quoted << "\n" << item.text;
        name = quoted;
        tests_of = TextOfFile(kRoot / quoted);
      } else if (std::smatch test;
                 std::regex_match(quoted, test, kTest) && !tests_of.empty()) {
        EXPECT_NE(tests_of.find(test[1]), std::string::npos)
            << quoted << " is not in " << name;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sources, SourceCoverage,
                         ::testing::Values("docs/source_coverage.md",
                                           "docs/source_coverage_boards.md",
                                           "docs/source_coverage_corners.md",
                                           "docs/source_coverage_drives.md",
                                           "docs/source_coverage_scan_heads.md"),
                         [](const auto& row) { return test::AsTestName(row.param); });

}  // namespace
}  // namespace intaglio::walls
