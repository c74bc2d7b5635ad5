#include "engrave/motion/parabola_program.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engrave/core/check.h"

// The unit vectors of the arc, e along x5 and n along x3, turn its tangent between the
// angles +-theta, tan theta = 4 h / (2b). An axis has the share |e_i cos + n_i sin| of
// the speed; its greatest over the arc, at an end or where the tangent points along the
// axis, gives V0 and a0. They bound the speed exactly and the acceleration but for the
// centripetal one, so what is built is measured and slowed by the ratio that is missing:
// over s times the time, speeds fall as 1 / s and accelerations as 1 / s^2.

namespace intaglio::motion {
namespace {

constexpr double kHeightRatio = 0.1;
constexpr double kMaxHeightMm = 1.0;
/// A leap that is higher than half of its step goes up and down more than forward.
constexpr double kMaxHeightRatio = 0.5;

/// The maximum number of pieces into which an arc of the speed's law is cut. The
/// deviation falls with the fourth power of the count; steps of 5 to 50 mm need 8, all
/// others less.
constexpr std::uint64_t kMaxPieces = 16;

/// The parabola of a step in its place.
struct Arc {
  Arc(const Vec3& from_mm, const Vec3& to_mm, const Vec3& arch_mm)
      : start_mm(from_mm),
        along((to_mm - from_mm).normalized()),
        across(arch_mm.isZero(0.0) ? Vec3(Vec3::Zero()) : arch_mm.normalized()),
        curve(0.5 * (to_mm - from_mm).norm(), arch_mm.norm()) {}

  KnotState At(double length_mm, double speed_mm_s) const {
    const ParabolaState x = curve.At(length_mm, speed_mm_s);
    return {start_mm + x.x5_mm * along + x.x3_mm * across,
            x.x6_mm_s * along + x.x4_mm_s * across};
  }

  /// The largest |component| of the tangent along each axis.
  Vec3 LargestTangent() const {
    const double steepest = std::atan(curve.Slope(0.0));
    Vec3 largest;
    for (int axis = 0; axis < 3; ++axis) {
      const double e = along[axis];
      const double n = across[axis];
      const double cosine = std::cos(steepest);
      const double sine = std::sin(steepest);
      largest[axis] =
          std::max(std::abs(e * cosine + n * sine), std::abs(e * cosine - n * sine));
      if (std::abs(n) <= std::abs(e) * std::tan(steepest)) {
        largest[axis] = std::hypot(e, n);
      }
    }
    return largest;
  }

  Vec3 start_mm;
  Vec3 along;
  Vec3 across;
  Parabola curve;
};

/// How long the arcs of the speed's law last.
struct Timing {
  std::uint64_t ramp = 0;
  std::uint64_t cruise = 0;

  std::uint64_t end() const { return 2 * ramp + cruise; }
};

/// Over whole ticks, with ramps of this share of the time, 0..1/2.
Timing TimingOver(std::uint64_t ticks, double ramp_ratio) {
  const std::uint64_t total = ticks * kSubticksPerTick;
  const auto ramp =
      std::clamp(static_cast<std::uint64_t>(ramp_ratio * static_cast<double>(total)),
                 kShortestArcSubticks, total / 2);
  const std::uint64_t cruise = total - 2 * ramp;
  if (cruise < kShortestArcSubticks) return {total / 2, 0};
  return {ramp, cruise};
}

/// The program as a function of time.
class Program {
 public:
  Program(const Arc& arc, const Timing& timing, double rate_hz)
      : arc_(arc), rate_hz_(rate_hz), law_(0.0, 0.0, {}) {
    const double length_mm = arc.curve.length_mm();
    const double speed_mm_s =
        length_mm / DurationSeconds(timing.ramp + timing.cruise, rate_hz);
    law_ = Interpolator(0.0, length_mm,
                        {speed_mm_s, speed_mm_s / DurationSeconds(timing.ramp, rate_hz)});
  }

  KnotState At(double subticks) const {
    const AxisState along =
        law_.At(subticks / (static_cast<double>(kSubticksPerTick) * rate_hz_));
    return arc_.At(along.position_mm, along.speed_mm_s);
  }

 private:
  const Arc& arc_;
  double rate_hz_;
  Interpolator law_;
};

/// The knots of every arc cut into `pieces` equal pieces.
std::vector<std::uint64_t> PieceKnots(const Timing& timing, std::uint64_t pieces) {
  std::vector<std::uint64_t> knots;
  std::uint64_t start = 0;
  for (const std::uint64_t length : {timing.ramp, timing.cruise, timing.ramp}) {
    if (length == 0) continue;
    for (std::uint64_t i = 1; i <= pieces; ++i) {
      knots.push_back(start + length / pieces * i + length % pieces * i / pieces);
    }
    start += length;
  }
  return knots;
}

/// The largest distance of the pieces from the program, at three samples each.
double Deviation(const Program& program, const KnotState& start,
                 std::span<const Segment> pieces, double rate_hz) {
  double largest_mm = 0.0;
  KnotState from = start;
  double at = 0.0;
  for (const Segment& piece : pieces) {
    const double duration_s = DurationSeconds(piece.duration_subticks, rate_hz);
    for (const double share : {0.25, 0.5, 0.75}) {
      const Vec3 wanted_mm = program.At(at + share * piece.duration_subticks).position_mm;
      const Vec3 got_mm = HermitePosition(from, piece, share * duration_s, duration_s);
      largest_mm = std::max(largest_mm, (got_mm - wanted_mm).norm());
    }
    at += piece.duration_subticks;
    from = piece.end();
  }
  return largest_mm;
}

std::vector<Segment> Pieces(const Arc& arc, const Vec3& to_mm, const Timing& timing,
                            double rate_hz) {
  const Program program(arc, timing, rate_hz);
  const KnotState start{arc.start_mm, Vec3::Zero()};
  std::vector<Segment> pieces;
  for (std::uint64_t count = 1; count <= kMaxPieces; count *= 2) {
    pieces.clear();
    AppendThroughKnots(
        PieceKnots(timing, count),
        [&](std::uint64_t at) { return program.At(static_cast<double>(at)); }, pieces);
    EndAtRest(to_mm, pieces.back());
    if (Deviation(program, start, pieces, rate_hz) <= kMaxDeviationMm) break;
  }
  return pieces;
}

/// By what factor the time is too short, 1 where a limit is reached.
double TimeRatio(const KnotState& start, std::span<const Segment> pieces,
                 const Limits& limits, double rate_hz) {
  double speed_ratio = 0.0;
  double acceleration_ratio = 0.0;
  KnotState from = start;
  for (const Segment& piece : pieces) {
    const double duration_s = DurationSeconds(piece.duration_subticks, rate_hz);
    const Vec3 speed = MaxSpeed(from, piece, duration_s);
    const Vec3 acceleration = MaxAcceleration(from, piece, duration_s);
    speed_ratio =
        std::max({speed_ratio, (speed.array() / limits.max_speed_mm_s.array()).maxCoeff(),
                  speed.norm() / limits.max_speed_norm_mm_s});
    acceleration_ratio = std::max(
        {acceleration_ratio,
         (acceleration.array() / limits.max_acceleration_mm_s2.array()).maxCoeff(),
         acceleration.norm() / limits.max_acceleration_norm_mm_s2});
    from = piece.end();
  }
  return std::max(speed_ratio, std::sqrt(acceleration_ratio));
}

/// (86) along the arc, with the limits its direction leaves.
TimeOptimalChoice ChoiceAlong(const Arc& arc, const Limits& limits) {
  const Vec3 tangent = arc.LargestTangent();
  const double v0 = (tangent.array() / limits.max_speed_mm_s.array()).maxCoeff();
  const double a0 = (tangent.array() / limits.max_acceleration_mm_s2.array()).maxCoeff();
  return ChooseTimeOptimal(arc.curve.length_mm(),
                           {std::min(1.0 / v0, limits.max_speed_norm_mm_s),
                            std::min(1.0 / a0, limits.max_acceleration_norm_mm_s2)});
}

/// The distance from a place to the side of the travel in `direction`, in units of
/// `direction`.
double RoomAlong(const Vec3& direction, const Vec3& place_mm, const Box3& travel_mm) {
  double room = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const double d = direction[axis];
    if (d == 0.0) continue;
    const double side_mm = d > 0.0 ? travel_mm.max_mm[axis] : travel_mm.min_mm[axis];
    room = std::min(room, (side_mm - place_mm[axis]) / d);
  }
  return room;
}

}  // namespace

Vec3 ArchOfStep(const Vec3& from_mm, const Vec3& to_mm, const Box3& travel_mm,
                std::optional<double> height_mm_asked) {
  const double distance_mm = (to_mm - from_mm).norm();
  const Vec3 along = (to_mm - from_mm) / distance_mm;
  const double kUpright = 0.1;
  Vec3 across = Vec3::UnitZ() - along.z() * along;
  if (across.norm() < kUpright) across = Vec3::UnitX() - along.x() * along;
  across.normalize();
  const double height_mm = height_mm_asked
                               ? std::min(*height_mm_asked, kMaxHeightRatio * distance_mm)
                               : std::min(kHeightRatio * distance_mm, kMaxHeightMm);
  // The arc lies within its ends, each moved by the arch.
  const auto room_mm = [&](const Vec3& direction) {
    const double room = std::min(RoomAlong(direction, from_mm, travel_mm),
                                 RoomAlong(direction, to_mm, travel_mm));
    return std::max(0.0, room - kMaxDeviationMm);
  };
  const double up_mm = std::min(height_mm, room_mm(across));
  const double down_mm = std::min(height_mm, room_mm(-across));
  return up_mm >= down_mm ? Vec3(up_mm * across) : Vec3(-down_mm * across);
}

std::uint64_t ParabolaProgram::Append(const Vec3& from_mm, const Vec3& to_mm,
                                      std::vector<Segment>& out) const {
  const Arc arc(from_mm, to_mm,
                ArchOfStep(from_mm, to_mm, limits_.travel_mm, height_mm_));
  const TimeOptimalChoice choice = ChoiceAlong(arc, limits_);
  const double ramp_ratio =
      choice.speed_mm_s / choice.acceleration_mm_s2 / choice.seconds;
  std::uint64_t ticks = WholeTicks(choice.seconds, rate_hz_);
  while (true) {
    Require(ticks <= kMaxStepTicks, "a parabola of ({}, {}, {}) mm takes {} ticks",
            to_mm.x() - from_mm.x(), to_mm.y() - from_mm.y(), to_mm.z() - from_mm.z(),
            ticks);
    const std::vector<Segment> pieces =
        Pieces(arc, to_mm, TimingOver(ticks, ramp_ratio), rate_hz_);
    const double ratio = TimeRatio({from_mm, Vec3::Zero()}, pieces, limits_, rate_hz_);
    if (ratio <= 1.0 + kTickSlackRatio) {
      out.insert(out.end(), pieces.begin(), pieces.end());
      return ticks;
    }
    const double seconds = static_cast<double>(ticks) / rate_hz_ * ratio;
    ticks = std::max(ticks + 1, WholeTicks(seconds, rate_hz_));
  }
}

}  // namespace intaglio::motion
