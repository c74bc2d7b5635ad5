#pragma once

// An order of marks while it is made, without their ways: a mark is an edge that has to
// be passed from one end to the other; of a closed one both ends are its first place. For
// jump_order.cc alone.

#include <cstdint>
#include <utility>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/mark/mark.h"

namespace intaglio::mark {

/// Beyond what rounding does to a way, as a share of it.
inline constexpr double kMargin = 1e-9;

/// A mark and the direction in which it is made.
struct Visit {
  std::uint32_t mark;
  bool back;
};

class Ends {
 public:
  explicit Ends(const std::vector<Mark>& marks) {
    for (const Mark& mark : marks) {
      const Vec2 first = mark.places.front().at_mm;
      ends_.emplace_back(first, mark.closed ? first : mark.places.back().at_mm);
    }
  }
  std::size_t size() const { return ends_.size(); }
  const Vec2& Begin(const Visit& v) const {
    return v.back ? ends_[v.mark].second : ends_[v.mark].first;
  }
  const Vec2& End(const Visit& v) const {
    return v.back ? ends_[v.mark].first : ends_[v.mark].second;
  }

 private:
  std::vector<std::pair<Vec2, Vec2>> ends_;
};

/// Parts of up to 50 marks are reversed and marks moved within such a part while that
/// shortens the way that begins at `start_mm`.
void ImproveVisits(const Ends& ends, const Vec2& start_mm, bool may_reverse,
                   std::vector<Visit>& order);

}  // namespace intaglio::mark
