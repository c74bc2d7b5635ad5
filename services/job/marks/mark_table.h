#pragma once

// What differs from repeat to repeat of a job of marks: fields of a table's row, and
// numbers in a row.

#include <cstddef>
#include <optional>
#include <string>

#include "engrave/core/result.h"
#include "engrave/io/csv.h"
#include "proto/mark.pb.h"
#include "services/job/marks/mark_shapes.h"

namespace intaglio {

class MarkTable {
 public:
  /// `marks` with its defaults; `file` the table's, if it has one. Errors begin with the
  /// field: a table that cannot be read, fewer rows than repeats.
  static Result<MarkTable> Make(const Marks& marks, const MarkFile& file);

  std::size_t repeat_count() const { return count_; }

  /// Whether the item has a placeholder, and so may differ.
  static bool Varies(const MarkItem& item);

  /// The item with the text of this repeat, from 0, as it is marked: no braces are left
  /// to be filled in. kNotFound: a column that the table lacks, by the item's path.
  Result<MarkItem> Fill(const MarkItem& item, const std::string& path,
                        std::size_t repeat) const;

  /// " (repeat 3, line 4 of names.csv)"; of an item that does not vary, nothing.
  std::string NameOf(const MarkItem& item, std::size_t repeat) const;

 private:
  std::optional<io::CsvTable> table_;
  std::string file_;
  std::size_t count_ = 1;
  std::uint64_t first_number_ = 1;
  std::size_t digits_ = 1;
};

}  // namespace intaglio
