#pragma once

// The outline that a guide laser draws, as lists of a BJJCZ board: of a machine that
// makes points and of one that makes marks alike.
//
//   corners --Make--> closed way --Next--> a dark list to its first place, then lists of
//                                          jumps along it, again and again
//
// A list has jumps alone, and sets neither power nor frequency of the laser. The driver
// that sends it keeps the gate closed meanwhile, the guide laser off until the mirrors
// are on the way (board_outputs.h), and the oscillator of a fibre laser off.

#include <cstddef>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "proto/machine.pb.h"
#include "services/drivers/bjjcz/board_field.h"
#include "services/drivers/bjjcz/board_list.h"

namespace intaglio::drivers {

/// How a head jumps.
struct GuideJumps {
  double jump_mm_s = 0;
  double jump_delay_s = 0;
};

class GuideOutline {
 public:
  /// `corners_mm`: 1 to kMaxOutlineCorners, in the field; at most at `speed_mm_s` > 0,
  /// and no faster than jumps. kUnsupported: the profile names no guide laser.
  static Result<GuideOutline> Make(const BjjczBoard& board, const BoardField& field,
                                   const GuideJumps& jumps,
                                   std::span<const Vec2> corners_mm, double speed_mm_s);

  /// From `at`, which becomes the place where it ends.
  LmcList Next(BoardPlace& at);
  /// The list of Next was played.
  void SetPlayed() { is_there_ = true; }
  /// The mirrors are on the way.
  bool is_there() const { return is_there_; }

 private:
  GuideOutline(const BjjczBoard& board, const BoardField& field, const GuideJumps& jumps)
      : board_(board), field_(field), jumps_(jumps) {}

  /// Whole places a millisecond, no faster than jumps.
  double PlacesMs(double speed_mm_s) const;
  /// The longest straight way at this speed: half of a list's time.
  double StepMm(double speed_mm_s) const;
  LmcList ListAt(double speed_mm_s) const;
  /// False: the list has no room for it; one without a move has.
  bool AddWay(const BoardPlace& to, BoardPlace& at, double speed_mm_s,
              LmcList& list) const;

  BjjczBoard board_;
  BoardField field_;
  GuideJumps jumps_;
  std::vector<Vec2> way_mm_;  ///< in steps of a list; the last leads to the first
  double speed_mm_s_ = 0;
  std::size_t next_ = 0;
  bool has_begun_ = false;  ///< a list leads to the first place
  bool is_there_ = false;
};

}  // namespace intaglio::drivers
