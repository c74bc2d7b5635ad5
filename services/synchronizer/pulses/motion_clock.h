#pragma once

// The clock of a motion controller that runs on an oscillator of its own, against the
// lamp: from stamps "the lamp's tick n was received at t", t in the controller's time,
// its phase and its drift. A stamp is never early; it is late by what the line took, 0 to
// some milliseconds, seldom twice the same. So the true line lies just below all stamps:
// of the lower convex hull of the newest ones it is the edge below their middle (Moon,
// Skelly, Towsley 1999, "Estimation and removal of clock skew from network delay
// measurements", sec. 4). With n stamps that are late by 0..J it is off by some J / n,
// where a mean or a least-squares line is by J / 2 and by J / sqrt(n).
//
// When some part of the stamps stays away from the line, or a stamp is far ahead of it,
// the stamps lie on two lines: the oscillator has changed its pace. From then on only the
// newest stamps count, and steps() has grown.
//
// A lamp sync that is left out or late makes every later stamp late by as much: all
// places that are on their way to the stage then belong to other ticks. So a shift of a
// tenth of a tick that is clearly more than the jitter counts as a step after eight
// stamps. A line that was held up shows otherwise: its stamps come together, each less
// late than the one before. No stamp is early by a tenth of a tick: a lamp sync came that
// is none.
//
// What was fired until then was fired at places that are not those of its points. A stamp
// that is less than a tenth of a tick beside its line proves that no lamp sync up to it
// was left out or late by more, unless by less than the jitter: such a tick is certain,
// and all before it.
//
// A delay that is always the same is not seen; it is a part of the stage's lag. Not
// thread-safe.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

namespace intaglio::synchronizer {

class MotionClock {
 public:
  /// Forgets everything; ticks pass `rate_hz` times a second of the lamp's clock.
  void Reset(double rate_hz);

  /// How many ticks ahead the line is used: it is laid through four times as many.
  void SetAhead(double ticks);

  /// Controller's time since its power-up, ns, when it received `tick`. A tick that does
  /// not follow is another power-up of the laser: everything before is forgotten.
  void Observe(std::uint64_t tick, std::uint64_t controller_ns);

  /// Controller's time at a tick, also one to come, ns. Needs a stamp.
  double ControllerNsAt(double tick) const;
  /// The places of a run are laid by this clock from now on: ticks are certain, or not,
  /// for its line of now, whatever line follows.
  void BeginRun();
  /// Newest tick of the run that is certain; before its first one, the newest tick.
  std::uint64_t certain_through() const { return certain_through_; }
  /// Since BeginRun a lamp sync was left out, late or too many, or it became another
  /// clock: no tick becomes certain any more.
  bool lost_run() const { return lost_run_; }
  /// How much later its ticks come than where the run was planned, ticks, as far as it is
  /// known; 0 or more.
  double LateTicks() const;
  /// Good enough to move by: 16 us, or a three-hundredth of a tick.
  bool settled() const { return settled_; }
  /// The controller's clock against the lamp's; above 0: it is fast.
  double drift_ppm() const { return 1e6 * line_.slope_ns / tick_ns_; }
  /// How often the pace was seen to change.
  std::uint32_t steps() const { return steps_; }
  bool empty() const { return stamps_.empty(); }
  /// Newest tick that a stamp has come of; 0: none.
  std::uint64_t newest_tick() const { return newest_tick_; }

 private:
  struct Stamp {
    double tick = 0;     // since the base
    double late_ns = 0;  // behind a clock without drift that was right at the base
  };
  struct Line {
    double offset_ns = 0, slope_ns = 0;
    double LateNsAt(double tick) const { return offset_ns + slope_ns * tick; }
  };
  void CountCertain(const Stamp& stamp);
  void Fit();
  void FitLine();
  void Measure();
  bool LeavesLine() const;
  bool IsShifted() const;
  bool IsEarly() const;
  void CountStep(std::size_t kept_stamps, const Line& before);
  bool RunsAhead();
  void KeepNewest(std::size_t count);

  double tick_ns_ = 0;
  std::size_t window_ = 0;
  std::uint64_t base_tick_ = 0, newest_tick_ = 0;
  std::uint64_t base_ns_ = 0;
  std::deque<Stamp> stamps_;
  std::size_t unfitted_ = 0;
  std::vector<Stamp> hull_;
  std::vector<double> above_ns_;  // of each stamp over the line
  Line line_;
  std::deque<Line> earlier_lines_;  // of the last quarter of a window, one a fit
  /// What ControllerNsAt may be off by at the newest stamps.
  double uncertainty_ns_ = 0;
  double jitter_ns_ = 0;
  double limit_ns_ = 0;  // what no chance takes a stamp or the minimum of a part beyond
  bool settled_ = false;
  std::uint32_t steps_ = 0;
  std::uint64_t certain_through_ = 0;
  bool lost_run_ = false;
  std::optional<Line> run_line_;  // before the first step of the run; none: line_
};

}  // namespace intaglio::synchronizer
