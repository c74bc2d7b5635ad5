#include "services/cli/terminal/text_table.h"

#include <gtest/gtest.h>

namespace intaglio::cli {
namespace {

using Align = TextTable::Align;

TEST(TextTable, ColumnsAreAsWideAsTheirWidestCellInCharacters) {
  TextTable table({{"job", Align::kRight}, {"name"}, {"time", Align::kRight}, {"why"}});
  table.AddRow({"7", "Zoë", "1.4 s", ""});
  table.AddRow({"12345", "Anna", "-", "paused"});
  table.AddBelow("to do: intaglio resume 12345");
  EXPECT_EQ(table.Text(),
            "  job  name   time  why\n"
            "    7  Zoë   1.4 s\n"
            "12345  Anna      -  paused\n"
            "        to do: intaglio resume 12345\n");
}

TEST(TextTable, AWideCharacterTakesTwoColumns) {
  TextTable table({{"name"}, {"why"}});
  table.AddRow({"龍", "paused"});
  table.AddRow({"Zoë 7", "made"});
  EXPECT_EQ(table.Text(),
            "name   why\n"
            "龍     paused\n"
            "Zoë 7  made\n");
  EXPECT_EQ(ColumnsOf("龍 ガラス"), 9u);
  EXPECT_EQ(ColumnsOf(""), 0u);
}

TEST(TextTable, WithoutRowsItHasItsTitles) {
  EXPECT_EQ(TextTable({{"job"}, {"name"}}).Text(), "job  name\n");
}

TEST(TextTable, ARowOfOtherLengthIsADefect) {
  TextTable table({{"job"}, {"name"}});
  EXPECT_ANY_THROW(table.AddRow({"1"}));
  EXPECT_ANY_THROW(table.AddBelow("of no row"));
}

}  // namespace
}  // namespace intaglio::cli
