#pragma once

// A representative program of contours to be cut: closed rectangles, gears, curves in
// short chords and zigzag ornaments, in the shares and sizes of the measured program of
// docs/measurements.md ("Speed through corners"). Only lines. One seed gives one program.

#include <cstdint>
#include <vector>

#include "engrave/course/plan.h"

namespace intaglio::course {

/// The machine of the measured program: w 150 and 220 rad/s, xi .3.
AxisPair MeasuredMachine(LoopKind loop = LoopKind::kFirstOrder);

/// Compensated, the acceleration limited by the motors alone: at 11 m/s^2 the greatest
/// that the source's law asks of this machine, as published.
PlanOptions CompensatedOptions(double motor_mm_s2 = 11000);

/// Shares of the cut length, whose sum is 1.
struct ProgramMix {
  double rectangles = 0.45, gears = 0.15, curves = 0.2, ornaments = 0.2;
};

std::vector<Path> CutProgram(double length_m, double feed_mm_s, std::uint64_t seed,
                             const ProgramMix& mix = {});

/// The contours as one, each begins where the one before ends; at most `max_segments`.
Path JoinedPath(const std::vector<Path>& program, std::size_t max_segments = 100'000);

double LengthMm(const std::vector<Path>& program);
std::size_t SegmentCount(const std::vector<Path>& program);

/// A path of straight pieces with one feed.
Path PolylinePath(const std::vector<Vec2>& points_mm, double feed_mm_s);
/// Two legs of this length with the corner at the origin, the first along `angle_rad`.
Path CornerPath(double angle_rad, double turn_rad, double leg_mm, double feed_mm_s);

/// Cut with a stop at every node.
double StoppingDurationS(const std::vector<Path>& program, double acceleration_mm_s2);

}  // namespace intaglio::course
