#pragma once

// Where the marks of a test pattern lie, as somebody measured them.

#include <filesystem>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/io/csv.h"

namespace intaglio::client {

struct MarksFile {
  std::filesystem::path file;
  /// A picture has the side of a pixel in the block, and the diameter of a mark; > 0.
  double pixel_um = 0, mark_um = 0;
};

struct MeasuredMarks {
  std::vector<Vec2> places_mm;  ///< from above, x to the right, y up
  /// The number of each in the pattern, from 0; empty: they are not known.
  std::vector<int> numbers;
};

/// The field of a column that the table has, as a number; a comma is its decimal sign
/// where semicolons separate fields. kUnreadable, with line and column.
Result<double> NumberIn(const io::CsvTable& table, const io::CsvRow& row,
                        const char* column, const std::filesystem::path& file);

/// By the file's extension: a table .csv with columns x_mm and y_mm, and mark (from 1,
/// the order of engraving) when it is known; a picture .png, .jpg, .jpeg or .bmp, taken
/// from above; or points of any format, of which z is not used. Errors name file, line
/// and field.
Result<MeasuredMarks> ReadMarks(const MarksFile& marks);

}  // namespace intaglio::client
