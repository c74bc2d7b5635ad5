#pragma once

// Patterns of Excellon files: holes and slots between M25 and M01, which M02 makes again
// elsewhere until M08. All errors are sentences without a place.

#include <cstdint>
#include <optional>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

struct DrillFile;

class ExcellonPattern {
 public:
  bool IsOpen() const { return begin_.has_value() && !end_; }
  Status Begin(const DrillFile& file);
  Status End(const DrillFile& file);
  /// Appends the pattern `count` times, each a step farther than the one before it.
  Status Repeat(int count, const Vec2& step_mm, std::uint64_t max_holes, DrillFile& file);
  void Finish();

 private:
  struct Counts {
    std::size_t holes = 0;
    std::size_t slots = 0;
  };
  std::optional<Counts> begin_;
  std::optional<Counts> end_;
  Vec2 offset_mm_ = Vec2::Zero();  ///< of the last repeat
};

}  // namespace intaglio::contour
