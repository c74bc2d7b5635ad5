#pragma once

// From a run's segments to lines of G1, with the pulses in them.
//
// Time of this family is progress. A grbl gives no time at which a line is executed: it
// slows down for its look-ahead, its buffers and a barrier. So a tick is a place in the
// program: of a segment of n ticks that goes from knot A to knot B, tick i is reached
// when the stage has passed the place that the segment has after i ticks. The tick rate
// is that of the plan (the laser's rate), and the lines' feed is the segment's highest
// speed, so that a controller that keeps up passes ticks at about that rate.
//
//   knots   A----------------B----------------C        segments, ends at ticks
//   pieces  A---+---+---+----B---+---+---+----C        chords of at most 50 ms
//   lines       G1 S0        |=|-- G1 S0               a pulse at B: the lit block begins
//                            lit                       at B, with the first step of the
//                            block                     way that follows
//
// - A pulse is the rising edge of the laser output, at the point's own step. The block is
//   lit for kLit_s at the way's speed (a 328P's PWM takes effect up to 1 ms late), at
//   most half the way to the next knot. Its lit and its dark block leave in one write.
// - Where no way follows (the end of the run, a knot that rests, a way of a few steps)
// the
//   stage does a step aside and back: a few steps, lit on the way out.
// - A controller goes on with the lines behind one that it refuses. So a lit line is sent
//   when each move before it was acknowledged: else it would begin where the refused one
//   begins (lights(), GrblDriver::SendPending). And each line has its own S: a refused S0
//   leaves none lit that follows.
// - A lit block's line number (N) is its tick modulo 1000, plus 1: so a controller that
//   reports or records line numbers shows which pulse it was.
// - With M4 both are dark at rest, whatever becomes of the host.
// - A piece is given out only when the tick of its beginning is decided; so the stage is
//   ahead of the decisions by one piece at most, and never by a knot.
//
// Places are whole steps of the controller. Used from one thread.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/core/result.h"
#include "engrave/motion/segments/segment.h"
#include "services/drivers/lockstep/piece_queue.h"
#include "services/drivers/lockstep/tick_powers.h"

namespace intaglio::drivers {

/// What one line, or a piece without one, is when it has been executed.
struct GrblMove {
  bool has_line = true;
  double planned_s = 0;          ///< of the plan, 0 for what the plan does not have
  std::uint64_t pulse_tick = 0;  ///< of a lit block; else 0
  std::uint64_t through_tick =
      0;                         ///< the last tick that has passed after it; 0: none more
  std::uint64_t first_tick = 0;  ///< of `places_mm`
  PointList places_mm;           ///< of the ticks that pass with it
  Vec3 to_mm = Vec3::Zero();
  bool ends_program = false;
};

/// Lines that leave in one write; moves without a line are among them.
struct GrblWrite {
  std::vector<std::string> lines;
  std::vector<GrblMove> moves;
  std::uint64_t knot_tick = 0;  ///< of the knot with a pulse that it begins at; else 0
  /// One of the lines is lit: the place where it begins has to be certain.
  bool lights() const;
  /// Makes the same way dark, without a pulse, before it leaves.
  void Darken();
};

class GrblProgram {
 public:
  static constexpr double kLit_s = 0.0025;
  static constexpr double kMaxPiece_s = PieceQueue::kMaxPiece_s;

  /// Of the controller. `travel` of the profile, machine frame.
  void SetController(const Vec3& steps_per_mm, double max_power);
  /// Of the pulses of this tick and later ones, 0..1 of the controller's largest S.
  void SetPowerRatio(std::uint64_t first_tick, double ratio) {
    powers_.Set(first_tick, ratio);
  }
  void SetTravel(const Box3& travel) { pieces_.SetTravel(travel); }
  /// The controller's modal state is that after the set-up: G1, no F.
  void ForgetModes() { feed_text_.clear(); }

  void Begin(std::uint64_t start_tick, const Vec3& from_mm);
  /// What the segments are appended to.
  PieceQueue& pieces() { return pieces_; }
  const PieceQueue& pieces() const { return pieces_; }
  /// What was not given out yet is forgotten.
  void Drop();

  /// What can be given out next: ticks up to `decided_through` are decided, and
  /// `fires` answers once for each knot with a pulse.
  std::optional<GrblWrite> Next(std::uint64_t decided_through,
                                const std::function<bool(std::uint64_t)>& fires);
  /// Between runs: where the stage rests.
  void RestAt(const Vec3& place_mm) { place_mm_ = Snapped(place_mm); }
  /// A pulse beside the way, where the stage rests.
  GrblWrite Aside(std::uint64_t tick);

  /// Of a knot with a pulse that is next to be given out; 0: none.
  std::uint64_t pulse_tick() const { return pulse_tick_; }
  /// Where everything that was given out ends.
  const Vec3& place_mm() const { return place_mm_; }

 private:
  Vec3 Snapped(const Vec3& place_mm) const { return pieces_.Snapped(place_mm); }
  double PulsePower(std::uint64_t tick) const;
  double Steps(const Vec3& from_mm, const Vec3& to_mm) const;
  std::string Line(const Vec3& to_mm, double speed_mm_s, std::uint64_t pulse_tick = 0);
  bool LightBeginning(const Piece& piece, GrblWrite& write);
  void AddAside(std::uint64_t tick, GrblWrite& write);
  GrblMove MoveOf(const Piece& piece) const;

  double max_power_ = 1000;
  TickPowers powers_;
  std::string feed_text_;

  PieceQueue pieces_;
  Vec3 place_mm_ = Vec3::Zero();  // of what was given out
  std::uint64_t pulse_tick_ = 0;  // of a pulse at place_mm_ that is not given out yet
};

}  // namespace intaglio::drivers
