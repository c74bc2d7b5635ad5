#pragma once

// The stage that carries the block under a scan head, and its side of the controller: it
// goes straight from rest to rest, with limited speed and acceleration, and follows its
// command exactly. Its own axes, mm.

#include <optional>

#include "engrave/core/geometry.h"
#include "services/virtual_engraver/jog_course.h"

namespace intaglio::virtual_engraver {

struct BlockStageOptions {
  Vec2 travel_min_mm = Vec2::Zero(), travel_max_mm = Vec2::Zero();
  double max_speed_mm_s = 50;       ///< > 0
  double acceleration_mm_s2 = 500;  ///< > 0, also of braking
};

class BlockStage {
 public:
  explicit BlockStage(const BlockStageOptions& options) : options_(options) {}

  bool Reaches(const Vec2& place_mm) const;
  /// From rest to a place that it reaches.
  void MoveTo(const Vec2& place_mm, double speed_mm_s);
  void Brake();
  void Advance(double seconds);
  /// Somebody moves it; a motion ends.
  void Push(const Vec2& by_mm);
  bool moves() const { return course_.has_value(); }
  const Vec2& at_mm() const { return at_mm_; }

 private:
  BlockStageOptions options_;
  Vec2 at_mm_ = Vec2::Zero();
  std::optional<JogCourse> course_;
};

}  // namespace intaglio::virtual_engraver
