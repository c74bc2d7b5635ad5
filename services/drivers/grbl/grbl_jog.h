#pragma once

// The moves of a jog, and whether the controller has made them.
//
// grbl ends a jog at a feed hold (the button at its panel, '!') as it does at 0x85: it
// brakes, forgets what is queued, is idle, and no answer says so (gnea/grbl wiki "Grbl
// v1.1 Jogging"). A line behind it begins another jog. So:
//  - every move is relative to the end of the one before (G91): behind moves that were
//    dropped none leads to the place that was meant;
//  - a move is sent while one that was queued at the status before is still queued, for
//    then nothing was dropped between; else not before the controller rests;
//  - where it rests, with all answered, is the end of what was sent; or the jog was cut.
// Behind a hold nothing moves but what was sent already.
//
// Work coordinates, mm. Ends are whole steps.

#include <cstddef>
#include <optional>
#include <string>

#include "services/drivers/grbl/grbl_text.h"

namespace intaglio::drivers {

/// Within a step, and the three decimals of a status.
bool IsSameGrblPlace(const Vec3& a_mm, const Vec3& b_mm, const Vec3& steps_per_mm);

class GrblJogMoves {
 public:
  /// It rests at `from_mm`.
  void Begin(const Vec3& from_mm, const Vec3& steps_per_mm);
  /// Whether the next move may be sent.
  bool may_send() const { return !waits_for_rest_; }
  /// The next move, to the step nearest to `to_mm`; none: it is there. TakeSent follows
  /// when it was sent.
  std::optional<std::string> Line(const Vec3& to_mm, double speed_mm_s) const;
  void TakeSent(const Vec3& to_mm);
  /// `left`: moves that have not been executed by this status; `unanswered` of them the
  /// controller has not acknowledged.
  void TakeStatus(const GrblStatus& status, std::size_t left, std::size_t unanswered);
  /// It rests, and not where what was sent ends.
  bool was_cut() const { return was_cut_; }

 private:
  Vec3 Snapped(const Vec3& place_mm) const;

  Vec3 steps_per_mm_ = Vec3::Zero(), end_mm_ = Vec3::Zero();
  std::size_t sent_ = 0, answered_ = 0;  // since it rested; at the newest status
  bool waits_for_rest_ = false, was_cut_ = false;
};

/// A sentence about was_cut().
std::string WhyGrblJogWasCut();

}  // namespace intaglio::drivers
