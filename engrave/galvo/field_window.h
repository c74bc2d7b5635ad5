#pragma once

// Where in its field a scan head with a correction can mark: the places whose command
// lies in the field, too. A head whose optics shrink the picture (a barrel) needs
// commands beyond its border for places near it, so its window is narrower than its
// field, most at the corners; one whose optics widen it reaches the whole field.

#include <span>
#include <vector>

#include "engrave/galvo/correction_table.h"

namespace intaglio::galvo {

/// mm; empty where it ends before it begins.
struct Span {
  double from_mm = 0, to_mm = 0;

  bool empty() const { return !(from_mm <= to_mm); }
  double width_mm() const { return to_mm - from_mm; }
};

/// Frame: field, mm. Known by lines along x, each 1/512 of the field from the next:
/// between two of them the narrower one counts.
class FieldWindow {
 public:
  /// Without a correction: the whole field. `field_mm` > 0.
  explicit FieldWindow(double field_mm);
  /// `commands`: commands minus targets.
  FieldWindow(double field_mm, const CorrectionTable& commands);

  double field_mm() const { return field_mm_; }
  /// No correction narrows it.
  bool is_whole_field() const { return square_mm_ >= field_mm_; }
  /// Width of the largest square around the centre that lies in it; 0: there is none.
  double square_mm() const { return square_mm_; }

  /// x around 0 that can be marked at each y from `min_y_mm` to `max_y_mm`. Neither
  /// allocates nor throws.
  Span AlongX(double min_y_mm, double max_y_mm) const;
  bool Has(const Vec2& place_mm) const;

  /// Displacements along x that bring all of these places into the window, nowhere nearer
  /// than `margin_mm` to its border.
  Span Displacements(std::span<const Vec2> places_mm, double margin_mm) const;

 private:
  double SquareMm() const;
  /// Without a correction its lines are the two borders, and alike.
  bool is_square() const { return lines_.size() == 2; }
  Span InSquare(std::span<const Vec2> places_mm, double margin_mm) const;

  double field_mm_;
  std::vector<Span> lines_;  // at y = -field / 2 + i field / (lines - 1)
  double square_mm_ = 0;
};

}  // namespace intaglio::galvo
