#pragma once

// The published tables of tests/data/contours.

#include <gtest/gtest.h>

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "engrave/contour/element.h"
#include "engrave/io/csv.h"
#include "engrave/io/number_text.h"

namespace intaglio::contour::test {

inline std::filesystem::path DataFile(const std::string& name) {
  return std::filesystem::path(INTAGLIO_SOURCE_DIR) / "tests/data/contours" / name;
}

inline io::CsvTable Table(const std::string& name) {
  auto table = io::ReadCsv(DataFile(name));
  EXPECT_TRUE(table) << table.error().message;
  return table ? *table : io::CsvTable{};
}

inline double NumberOf(const io::CsvTable& table, const io::CsvRow& row,
                       std::string_view name) {
  return io::ParseNumber(*table.Find(row, name)).value_or(0);
}

/// An element by the code of the published project files.
inline Element ElementOf(int code, const Vec2& a, const Vec2& b, double size) {
  switch (code) {
    case 1:
      return {Circle{a, size}, {}};
    case 2:
      return {Square{a, size}, {}};
    case 3:
      return {Octagon{a, size}, {}};
    default:
      return {Track{a, b, size}, {}};
  }
}

/// "1 0 0 2|4 0 0 5 0 1": code, x, y, of a track x2, y2, size.
inline std::vector<Element> ElementsOf(const std::string& text) {
  std::vector<Element> elements;
  std::istringstream rows(text);
  for (std::string row; std::getline(rows, row, '|');) {
    std::istringstream in(row);
    int code = 0;
    Vec2 a = Vec2::Zero();
    Vec2 b = Vec2::Zero();
    double size = 0;
    in >> code >> a.x() >> a.y();
    if (code == 4) in >> b.x() >> b.y();
    in >> size;
    EXPECT_FALSE(in.fail()) << row;
    elements.push_back(ElementOf(code, a, b, size));
  }
  return elements;
}

}  // namespace intaglio::contour::test
