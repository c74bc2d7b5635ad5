#pragma once

// Tables as spreadsheets write them: CSV as of RFC 4180, for series with one piece per
// row.
//
// The first record names the columns. Fields are separated by commas, by semicolons (as
// where the comma is the decimal sign) or by tabs, whichever the header line has most of
// outside quotes; a header with none is a single column. A field that holds the
// separator, a quote or a line end is enclosed in double quotes; a quote inside it is
// written twice. Records end with LF, CR LF or CR. A UTF-8 byte order mark and empty
// lines are skipped. Text is UTF-8 and taken as it is; blanks belong to it, except around
// the names of the header.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::io {

/// A field as written in a table: in double quotes when it holds a comma, a semicolon, a
/// tab, a quote or a line end. ParseCsv gives it back.
std::string CsvField(std::string_view text);

struct CsvRow {
  std::vector<std::string> fields;  ///< as many as there are columns
  std::size_t line_number = 0;      ///< of its first line in the file, from 1
};

struct CsvTable {
  std::vector<std::string> names;  ///< not empty, no two alike
  std::vector<CsvRow> rows;

  /// The field of a row by its column's name; null when there is no such column.
  const std::string* Find(const CsvRow& row, std::string_view name) const;
};

/// Limits on the time and memory of reading; beyond them: ErrorCode::kTooLarge.
struct CsvLimits {
  std::uint64_t max_file_bytes = 16 << 20;  ///< far more than anyone's list of pieces
  std::size_t max_rows = 100'000;
  std::size_t max_columns = 256;
  std::size_t max_field_bytes = 64 << 10;
};

/// Errors name the line and the remedy: kUnreadable (a quote that is not closed or that
/// is inside an unquoted field, a NUL byte, a row with more or fewer fields than there
/// are names), kMissing (no header, a column without a name), kInvalidValue (two columns
/// of one name), kTooLarge.
Result<CsvTable> ParseCsv(std::string_view bytes, const CsvLimits& limits = {});

/// Errors name the file too, and are kNotFound and kIo besides.
Result<CsvTable> ReadCsv(const std::filesystem::path& file, const CsvLimits& limits = {});

}  // namespace intaglio::io
