#include "services/cli/terminal/text_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engrave/core/check.h"

namespace intaglio::cli {
namespace {

constexpr char kGap[] = "  ";
constexpr char kIndent[] = "        ";

}  // namespace

std::size_t ColumnsOf(const std::string& text) {
  // fmt pads to columns, so what it does not pad with is the text's own.
  const std::size_t enough = 2 * text.size();
  return text.size() + enough - fmt::formatted_size("{:<{}}", text, enough);
}

TextTable::TextTable(std::vector<Column> columns) : columns_(std::move(columns)) {
  for (const Column& column : columns_) widths_.push_back(ColumnsOf(column.title));
}

void TextTable::AddRow(std::vector<std::string> cells) {
  Require(cells.size() == columns_.size(), "a row of {} cells in a table of {} columns",
          cells.size(), columns_.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    widths_[i] = std::max(widths_[i], ColumnsOf(cells[i]));
  rows_.push_back({std::move(cells), {}});
}

void TextTable::AddBelow(const std::string& line) {
  Require(!rows_.empty(), "a line below a table without a row: {}", line);
  rows_.back().below.push_back(line);
}

std::string TextTable::LineOf(const std::vector<std::string>& cells) const {
  std::string line;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const std::string blanks(widths_[i] - ColumnsOf(cells[i]), ' ');
    const bool is_right = columns_[i].align == Align::kRight;
    line += (i == 0 ? "" : kGap) + (is_right ? blanks + cells[i] : cells[i] + blanks);
  }
  line.resize(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

std::string TextTable::Text() const {
  std::vector<std::string> titles;
  for (const Column& column : columns_) titles.push_back(column.title);
  std::string text = LineOf(titles);
  for (const Row& row : rows_) {
    text += LineOf(row.cells);
    for (const std::string& line : row.below) text += kIndent + line + "\n";
  }
  return text;
}

}  // namespace intaglio::cli
