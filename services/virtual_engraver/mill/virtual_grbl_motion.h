#pragma once

// The planner, the stepper and the laser output of a virtual grbl, by the microsecond.
//
// A block is a straight line between two step positions. Its speed profile is a trapezoid
// (as grbl's planner.c): not above its nominal speed, with its acceleration, and at each
// junction not faster than the junction deviation allows (centripetal acceleration on a
// circle that is tangent to both blocks) and than the blocks behind it allow to brake to
// rest at the end of the buffer.
//
// Machine frame; steps, mm, mm/s, us.

#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

#include "engrave/core/geometry.h"

namespace intaglio::grbl {

using Steps = std::array<std::int64_t, 3>;

/// What makes the laser light during a block and after it.
enum class Beam : std::uint8_t {
  kDark,      ///< M5, S0, or G0
  kDynamic,   ///< M4: power goes with the speed, so it is dark at rest
  kConstant,  ///< M3: stays lit at rest, also when the buffer is empty
};

/// One time for which the laser output was on without a break.
struct Flash {
  double on_us = 0, off_us = 0;
  Steps on_at{}, off_at{};
  double at_rest_us = 0;  ///< of that time, with no motion
  std::int64_t line = 0;  ///< line number (N) of the block that lit it; 0: none
};

/// An end of a straight way of the tool, and how it came there.
struct WayEnd {
  double at_us = 0;
  Steps at{};
  bool on = false;   ///< the output, on the way from the end before
  double power = 0;  ///< S of that way's block
};

struct MotionOptions {
  std::size_t planner_blocks = 15;
  double steps_per_mm = 250;
  double max_speed_mm_s = 100;
  double acceleration_mm_s2 = 1000;
  double junction_deviation_mm = 0.01;
  /// The output changes only at multiples of this (the PWM of a 328P: about 1000 us); 0:
  /// at once.
  double pwm_period_us = 0;
  /// One in so many M4 blocks that begin while the stage accelerates stays dark; 0: none.
  std::uint32_t lose_dynamic_every = 0;
};

class VirtualGrblMotion {
 public:
  explicit VirtualGrblMotion(const MotionOptions& options) : options_(options) {}

  /// To `target` at up to `speed_mm_s`; a block without a step is left out.
  void Add(const Steps& target, double speed_mm_s, Beam beam, bool jog, std::int64_t line,
           double power = 0);
  bool is_full() const { return blocks_.size() >= options_.planner_blocks; }
  std::size_t free_blocks() const { return options_.planner_blocks - blocks_.size(); }
  bool is_empty() const { return blocks_.empty(); }

  void Advance(double us);

  /// Brakes to rest and stays there; the blocks stay.
  void Hold() { holding_ = true; }
  void Resume() { holding_ = false; }
  bool moving() const { return speed_mm_s_ > 0; }
  /// Stops the steps at once and forgets all blocks: steps may be lost.
  void Kill();
  /// Forgets all blocks; at rest.
  void Flush();
  /// Brakes, and forgets the blocks when it has come to rest.
  void CancelJog() { holding_ = flush_at_rest_ = true; }

  /// Light at rest: that of M3 after a G1, until it is taken back.
  void SetRestingBeam(bool lit) { resting_lit_ = lit; }
  /// Whatever the blocks ask for, the output is off.
  void ForceDark(bool dark) { forced_dark_ = dark; }

  const Steps& at() const { return at_; }
  /// Where the queued blocks end.
  const Steps& planned_end() const {
    return blocks_.empty() ? at_ : blocks_.back().target;
  }
  /// The stage goes there at once, and the counter with it.
  void MoveTo(const Steps& at) { at_ = at; }
  /// The controller counts the place where the stage is as `at` from now on.
  void CountAs(const Steps& at);
  /// Where the stage is, counted from the first power-up, whatever the controller counts.
  Steps TrueSteps() const { return PlusUncounted(at_); }
  double speed_mm_s() const { return speed_mm_s_; }
  /// Line number of the block that is executed; 0: none.
  std::int64_t line() const { return blocks_.empty() ? 0 : blocks_.front().line; }
  Vec3 Position_mm() const {
    return Vec3(double(at_[0]), double(at_[1]), double(at_[2])) / options_.steps_per_mm;
  }

  // The record: of true places, over power cycles, homing and lost steps.
  const std::vector<Flash>& flashes() const { return flashes_; }
  bool lit() const { return lit_; }
  /// All that the tool did, in order; the way that is under way is not in it.
  const std::vector<WayEnd>& way() const { return way_; }
  /// Sum of the time that the output was on while nothing moved.
  double lit_at_rest_us() const { return lit_at_rest_us_; }
  double now_us() const { return now_us_; }
  std::uint64_t steps_made() const { return steps_made_; }

 private:
  struct Block {
    Steps from{}, target{};
    Vec3 unit = Vec3::Zero();
    double length_mm = 0, done_mm = 0;
    double nominal_mm_s = 0;
    double junction_mm_s = 0;  ///< largest speed at its beginning, by the junction
    double entry_mm_s = 0;     ///< the same, by the blocks behind it, too
    Beam beam = Beam::kDark;
    bool jog = false, begun = false, lost = false;
    std::int64_t line = 0;
    double power = 0;
  };

  double JunctionSpeed(const Block& before, const Block& block) const;
  void Replan();
  /// Runs the block in front for up to `us`; returns what it took.
  double RunBlock(double us);
  double Accelerate(Block& block, double from, double to, double us);
  void Move(Block& block, double mm);
  void EndBlock();
  void Begin(Block& block);
  Steps PlusUncounted(const Steps& counted) const;
  bool CommandedLit() const;
  /// The output for the next `us`, with or without motion.
  void Pass(double us, bool moves);
  void SetOutput(bool lit);
  void EndWay();

  MotionOptions options_;
  std::deque<Block> blocks_;
  Steps at_{};
  Steps uncounted_{};  // of the true place, what the counter does not have
  double speed_mm_s_ = 0, now_us_ = 0;
  bool holding_ = false, flush_at_rest_ = false;
  bool resting_lit_ = false, forced_dark_ = false, lit_ = false;
  double lit_at_rest_us_ = 0;
  std::uint32_t dynamic_starts_ = 0;
  std::uint64_t steps_made_ = 0;
  std::vector<Flash> flashes_;
  std::vector<WayEnd> way_;
};

}  // namespace intaglio::grbl
