#pragma once

// Numbers of Excellon files: which unit they have, and where the point is that most files
// leave out.

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::contour {

enum class Zeros {
  kLeading,   ///< those in front are written (LZ)
  kTrailing,  ///< those behind are written (TZ)
};

/// All errors are sentences without a place.
class ExcellonNumbers {
 public:
  /// METRIC or INCH, then LZ, TZ or digits as 000.000, in any order: the line of a
  /// header.
  Status ReadUnits(std::string_view line);
  /// The same of a person who knows better: what it has is kept, whatever the file says.
  Status Replace(std::string_view line);
  /// What a layout program writes as a comment, ";FILE_FORMAT=4:4": the digits before and
  /// behind the point. Other comments change nothing.
  Status ReadComment(std::string_view line);
  void SetUnit(double unit_mm);  ///< 1 or 25.4
  /// What was read since the last call and differs from what replaces it, such as "INCH
  /// of the file, METRIC as given".
  std::vector<std::string> TakeReplaced() { return std::exchange(replaced_texts_, {}); }
  std::optional<double> unit_mm() const { return unit_mm_; }

  /// mm. kMissing: no unit; a number without a point that neither declared zeros nor its
  /// number of digits make clear.
  Result<double> Length(std::string_view number) const;
  /// The same of a number that always has its point.
  Result<double> Diameter(std::string_view number) const;

 private:
  struct Declared {
    std::optional<double> unit_mm;
    std::optional<Zeros> zeros;
    std::optional<std::pair<int, int>> digits;  ///< before and behind the point
  };
  static Result<Declared> Read(std::string_view line);
  void Declare(const Declared& declared);
  std::pair<int, int> Digits() const;

  std::optional<Zeros> zeros_;
  std::optional<double> unit_mm_;
  std::pair<int, int> digits_{0, 0};  ///< before and behind the point; 0, 0: by the unit
  Declared replacing_;
  std::vector<std::string> replaced_texts_;
};

}  // namespace intaglio::contour
