#pragma once

// Points in glass as lists of a BJJCZ board: a jump to each, and the laser on at rest.
// Places are the board's own, 0..65535; a point is at the nearest of them, so within half
// a place on each axis.
//
// A list has one power: a source needs some time behind a change, and has it between two
// lists.
//
// Behind jump_and_dwell.pause_after_points the board rests by delays of its lists, none
// of which is longer than any other list: a stop takes effect as soon as ever.
//
// A list has laser.max_unsettled_points at most, so that no more are uncertain when all
// fails at once: the synchronizer arms no more than these, either.

#include <cstdint>

#include "engrave/core/geometry.h"
#include "proto/machine.pb.h"
#include "services/drivers/bjjcz/board_field.h"
#include "services/drivers/bjjcz/board_list.h"
#include "services/drivers/bjjcz/guide_outline.h"

namespace intaglio::drivers {

class PointLists {
 public:
  /// A machine that CheckBjjczPointProfile passes.
  explicit PointLists(const MachineSpec& machine);

  const BoardField& field() const { return field_; }
  GuideJumps guide_jumps() const { return {jumps_.jump_mm_s(), jumps_.jump_delay_s()}; }
  Vec2 at_mm() const { return field_.ToMm(at_); }
  bool empty() const { return list_.commands.empty(); }

  void BeginRun() {
    first_of_run_ = true;
    points_since_pause_ = 0;
    pause_s_ = 0;
  }
  /// From where the mirrors are to `to_mm`, and the laser on there, if it `fires`. False:
  /// the list has no room for it, or has its points, or points of another power, or the
  /// board rests in it; an empty one has room, unless a pause is due. Of a point that
  /// fires, `power_ratio`: of the largest; `pulses`: it dwells for so many, 0: for
  /// dwell_s.
  bool Add(const Vec2& to_mm, bool fires, double power_ratio = 1, unsigned pulses = 0);
  /// Dark, in no less than `seconds`: by hand.
  void AddSlow(const Vec2& to_mm, double seconds);
  /// What was added since the last call; it begins with a jump, wherever the mirrors are.
  LmcList Take();
  /// The next of an outline; nothing was added.
  LmcList TakeGuide(GuideOutline& outline) { return outline.Next(at_); }
  /// What was taken was played to its end.
  void SetPlayed() { begun_at_ = at_; }
  /// As the mirrors are when the board is switched on.
  void SetCentred() { at_ = begun_at_ = {}; }
  /// What was added or taken since then is not played.
  void Drop();

 private:
  void AddJump(const BoardPlace& to);
  void CountPoint();
  void Begin(double places_ms, double power_ratio);
  /// Adds what is left of a pause; false: the list has no room for all of it.
  bool AddPause();

  MachineSpec machine_;
  BjjczBoard board_;
  JumpAndDwell jumps_;
  BoardField field_;
  std::uint32_t max_points_, point_count_ = 0;  ///< of a list
  BoardPlace at_;                               ///< where the list leads
  BoardPlace begun_at_;                         ///< where it begins
  LmcList list_;
  double power_ratio_ = 1;  ///< of the list
  std::uint32_t points_since_pause_ = 0;
  double pause_s_ = 0;  ///< that is due
  bool first_of_run_ = true, has_jump_ = false;
};

}  // namespace intaglio::drivers
