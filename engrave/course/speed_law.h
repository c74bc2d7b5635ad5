#pragma once

// The speed along a path, planned with look-ahead: constant acceleration, constant speed,
// constant deceleration on each segment, under a speed limit at each node, the segments'
// feeds and an acceleration for each segment. The fastest such law.
//
// Source: Zarudnev 2007 (law of motion of three phases), corrected: phases 2 and 3 count
// the time from their own begin; phase 3 is s2 + V t - a t^2 / 2; a segment too short for
// its feed has the peak sqrt((v0^2 + v1^2) / 2 + a L).

#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "engrave/course/path.h"
#include "engrave/course/swing.h"

namespace intaglio::course {

/// From here on, until the next phase: s + v t + a t^2 / 2.
struct Phase {
  double begin_s = 0;  ///< time from the begin of the law
  double s_mm = 0;
  double v_mm_s = 0;
  double a_mm_s2 = 0;
};

struct SpeedLaw {
  std::vector<Phase> phases;            ///< in the order of time; one or more
  std::vector<double> node_speed_mm_s;  ///< that are passed, one for each node
  double duration_s = 0;
  double length_mm = 0;
  /// On the clock of the setpoints, whose instants are whole periods: that of a part of a
  /// longer course.
  double begin_s = 0;
  /// What the reference leaves the path by at its corners; null: nothing.
  std::shared_ptr<const Swings> swings;
};

struct SpeedLimits {
  /// For each node, >= 0. The first and the last are the speeds at the path's ends, 0: at
  /// rest.
  std::span<const double> node_mm_s;
  /// For each segment, positive; beside the segment's feed.
  std::span<const double> segment_mm_s;
  std::span<const double> acceleration_mm_s2;  ///< for each segment, positive
};

/// Throws PreconditionError when the sizes do not fit the path.
SpeedLaw PlanSpeeds(const Path& path, const SpeedLimits& limits);

/// The same acceleration on all segments, at rest at both ends, inner nodes as given
/// (node_count() - 2 values).
SpeedLaw PlanSpeeds(const Path& path, std::span<const double> inner_node_mm_s,
                    double acceleration_mm_s2);

/// Segments of a block whose duration AlignBlocks makes whole.
inline constexpr std::size_t kBlockSegments = 256;

/// Slows each block of kBlockSegments segments, the last one left out, by less than a
/// period in all, so that it lasts whole periods of the setpoints. Without it a change of
/// one node's speed moved all nodes behind it on the clock of the setpoints, and with it
/// the loads that their corners have there (by up to 4 %): some node of a long path was
/// over its limit whatever was corrected. The speed has steps of at most one period in a
/// block's duration at the blocks' ends.
void AlignBlocks(const Path& path, double period_s, SpeedLaw& law);

/// The law at the times first_s + i period_s, i from 0 to count - 1, as arc length, mm.
/// Before its begin and behind its end it goes on with the speed there. With smooth_s >
/// 0 it is the mean over a window of that length around each time, to whole periods: the
/// jerk along the path is then at most 2 a / smooth_s.
std::vector<double> SampleLaw(const SpeedLaw& law, double period_s, double first_s,
                              std::size_t count, double smooth_s = 0);

/// Its speed, mm/s, at such times.
std::vector<double> SampleSpeed(const SpeedLaw& law, double period_s, double first_s,
                                std::size_t count);

}  // namespace intaglio::course
