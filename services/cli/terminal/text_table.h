#pragma once

// A table for people: each column is as wide as its widest cell, so that what is printed
// fits a terminal of 80 columns where its contents do.

#include <cstddef>
#include <string>
#include <vector>

namespace intaglio::cli {

/// That a terminal shows a text of UTF-8 in: two for a wide character, as of Chinese.
std::size_t ColumnsOf(const std::string& text);

class TextTable {
 public:
  enum class Align { kLeft, kRight };
  struct Column {
    std::string title;
    Align align = Align::kLeft;
  };

  explicit TextTable(std::vector<Column> columns);

  /// As many cells as there are columns.
  void AddRow(std::vector<std::string> cells);
  /// Lines below the last row, indented, of any length.
  void AddBelow(const std::string& line);
  /// With the titles first; no line ends with a blank.
  std::string Text() const;

 private:
  struct Row {
    std::vector<std::string> cells, below;
  };
  std::string LineOf(const std::vector<std::string>& cells) const;

  std::vector<Column> columns_;
  std::vector<std::size_t> widths_;
  std::vector<Row> rows_;
};

}  // namespace intaglio::cli
