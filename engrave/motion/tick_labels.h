#pragma once

// The number of ticks of each step of a path when the stage need not stop: a dynamic
// programme over labels. A label at a point is a number of ticks from the start and the
// box of velocities with which the point can be passed at that tick (axis_reach.h), so
// feasibility is exact; at each point a fixed number of labels is kept. A label whose box
// lies inside that of another label with no more ticks is never kept.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "engrave/core/geometry.h"
#include "engrave/motion/axis/axis_reach.h"
#include "engrave/motion/segments/segment.h"
#include "engrave/motion/step_limits.h"

namespace intaglio::motion {

/// Velocities per axis, mm/s.
struct VelocityBox {
  SpeedInterval axis[3];
};

struct LabelOptions {
  /// Labels kept at a point, 1..256. 4 are enough up to 200 Hz; above that, where a step
  /// takes several ticks, 16.
  int width = 4;
  /// Ticks tried beyond the first that serve, for each label, 0..64.
  int extra_ticks = 2;
};

/// The ticks of the step to a point and the velocities open at it.
struct TimedStep {
  std::uint32_t ticks = 1;
  std::uint32_t choice = 0;  ///< Of the step's limits.
  VelocityBox box;
};

/// Keeps its memory between calls; not for two threads at once.
class TickLabels {
 public:
  /// Of `choices` every step takes one (StepLimitsOf): `levels` groups of equal size, one
  /// behind the other, of which a step takes one of its level's.
  TickLabels(std::vector<StepLimits> choices, std::size_t levels, double rate_hz,
             const LabelOptions& options);

  /// The fewest ticks found from `start` through steps of `steps_mm` to rest at the end
  /// of the last. `timed` gets an entry a step. The start velocity is one from which the
  /// way can be made within the limits. `near_walls`: NearWalls of the way's points.
  /// `levels`: of each step, empty: 0. Near walls a step that cannot be made with its
  /// level takes level 0.
  void Choose(const KnotState& start, std::span<const Vec3> steps_mm, bool near_walls,
              std::span<const std::uint32_t> levels, std::vector<TimedStep>& timed);

 private:
  struct Label {
    SpeedEnds box[3];  ///< Per axis.
    std::uint32_t ticks = 0;
    std::uint32_t step_ticks = 0;
    std::uint32_t choice = 0;
    std::int32_t parent = -1;

    bool Covers(const Label& other) const;
    bool HasRest() const;
  };

  /// A label offered, while the best are chosen; less is better.
  struct Scored {
    double score;
    std::uint32_t index;
  };

  /// A step in a number of ticks under one choice of limits.
  struct Trial {
    const Vec3& start_mm;
    const Vec3& step_mm;
    std::uint32_t ticks;
    std::uint32_t choice;
    double seconds;
    std::array<AxisReach, 3> reach;  ///< Of axes without a limit of jerk.
  };

  template <bool kPlain>
  void Extend(const Vec3& start_mm, const Vec3& step_mm, std::uint32_t level,
              bool to_rest);
  Trial MakeTrial(const Vec3& start_mm, const Vec3& step_mm, std::uint32_t ticks,
                  std::uint32_t choice) const;
  template <bool kPlain>
  void Open(const Trial& trial);
  template <bool kPlain>
  void TryAll(const Trial& trial, bool to_rest);
  /// Whether a label of the last point, or any of them, might gain by that number of
  /// ticks.
  bool IsWorthATry(std::uint32_t label, std::uint32_t ticks) const;
  bool IsWorthATry(std::uint32_t ticks) const;
  template <bool kPlain>
  bool MakeLabel(std::uint32_t from_index, const Trial& trial, Label& to) const;
  void KeepOpen(const KnotState& start, std::span<const Vec3> steps_mm,
                std::vector<TimedStep>& timed) const;
  void Offer(const Label& label);
  double Score(const Label& label) const;
  void KeepBest();

  std::vector<StepLimits> choices_;
  std::uint32_t level_size_;
  bool near_walls_ = false;
  Vec3 fastest_mm_s_;  ///< Of any choice.
  double rate_hz_;
  LabelOptions options_;
  std::vector<Label> labels_;         ///< Of all points, one after another.
  std::vector<std::uint32_t> first_;  ///< Of each point in labels_.
  std::vector<Label> offered_;        ///< For the current point.
  std::vector<Scored> scored_;        ///< Of these.
  std::vector<std::uint32_t> last_;   ///< Of each label: the last number of ticks to try.
  SpeedEnds usable_[3];               ///< At the start of the step that is tried.
  SpeedEnds open_[3];                 ///< At its end; where there are walls.
  std::uint32_t rest_ticks_ = 0;      ///< The fewest ticks to rest at the current point.
};

}  // namespace intaglio::motion
