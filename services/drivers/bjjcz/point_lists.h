#pragma once

// Points in glass as lists of a BJJCZ board: a jump to each, and the laser on at rest.
// Places are the board's own, 0..65535; a point is at the nearest of them, so within half
// a place on each axis.
//
// A list has one power: a source needs some time behind a change, and has it between two
// lists.
//
// A list has laser.max_unsettled_points at most, so that no more are uncertain when all
// fails at once: the synchronizer arms no more than these, either.

#include <array>
#include <cstdint>

#include "engrave/core/geometry.h"
#include "proto/machine.pb.h"
#include "services/drivers/bjjcz/board_list.h"

namespace intaglio::drivers {

class PointLists {
 public:
  /// A machine that CheckBjjczPointProfile passes.
  explicit PointLists(const MachineSpec& machine);

  /// Places of the board for 1 mm of the field.
  double places_per_mm() const { return places_per_mm_; }
  Vec2 at_mm() const;
  bool empty() const { return list_.commands.empty(); }

  void BeginRun() { first_of_run_ = true; }
  /// From where the mirrors are to `to_mm`, and the laser on there, if it `fires`. False:
  /// the list has no room for it, or has its points, or points of another power; an empty
  /// one has room. `power_ratio`: of the largest, of a point that fires.
  bool Add(const Vec2& to_mm, bool fires, double power_ratio = 1);
  /// Dark, in no less than `seconds`: by hand.
  void AddSlow(const Vec2& to_mm, double seconds);
  /// A way that a guide laser shows: straight, dark, at most so fast. False: the list has
  /// no time for it; an empty one has, up to GuideStepMm. Such a list has nothing else,
  /// and sets neither power nor frequency of the laser.
  bool AddGuide(const Vec2& to_mm, double speed_mm_s);
  /// The longest way of AddGuide at this speed: half of a list's time.
  double GuideStepMm(double speed_mm_s) const;
  /// What was added since the last call; it begins with a jump, wherever the mirrors are.
  LmcList Take();
  /// What was taken was played to its end.
  void SetPlayed() { begun_at_ = at_; }
  /// As the mirrors are when the board is switched on.
  void SetCentred() { at_ = begun_at_ = {32768, 32768}; }
  /// What was added or taken since then is not played.
  void Drop();

 private:
  using Place = std::array<int, 2>;

  Place PlaceOf(const Vec2& at_mm) const;
  /// Whole places a millisecond, no faster than jumps.
  double GuidePlacesMs(double speed_mm_s) const;
  void AddJump(const Place& to);
  void Begin(double places_ms, double power_ratio);

  BjjczBoard board_;
  JumpAndDwell jumps_;
  double places_per_mm_;
  std::uint32_t max_points_, point_count_ = 0;  ///< of a list
  Place at_{32768, 32768};                      ///< where the list leads
  Place begun_at_{32768, 32768};                ///< where it begins
  LmcList list_;
  double power_ratio_ = 1;  ///< of the list
  bool first_of_run_ = true, has_jump_ = false;
};

}  // namespace intaglio::drivers
