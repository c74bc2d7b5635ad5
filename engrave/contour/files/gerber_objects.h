#pragma once

// What a Gerber file draws, object by object: dark ones add copper, clear ones take away
// what was drawn before them, blocks are repeated.

#include <string>
#include <vector>

#include "engrave/contour/element.h"
#include "engrave/contour/files/gerber_parameters.h"
#include "engrave/contour/files/gerber_read.h"
#include "engrave/core/result.h"

namespace intaglio::contour {

/// All errors are sentences without a place.
class GerberObjects {
 public:
  explicit GerberObjects(const GerberLimits& limits) : limits_(limits) {}

  void SetClear(bool clear) { clear_ = clear; }
  Status Add(Element object);
  /// Ends the block before: it is copied, first along y and then along x, each copy with
  /// its dark and clear objects in their order (Ucamco 2022, ch. 4.11).
  Status Repeat(const GerberRepeat& next);
  /// What is left of the dark objects, in their order.
  Result<std::vector<Element>> Finish();
  Error TooMany() const;

 private:
  GerberLimits limits_;
  std::vector<Element> objects_;
  std::vector<char> are_clear_;
  bool clear_ = false;
  GerberRepeat repeat_;
  std::size_t repeat_begin_ = 0;
  std::uint64_t edge_count_ = 0;
};

}  // namespace intaglio::contour
