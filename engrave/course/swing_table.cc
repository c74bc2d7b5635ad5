#include "engrave/course/swing_table.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace intaglio::course {
namespace {

/// Lengths of a swing on each side, in lengths of the kernel, the longest first.
constexpr std::array kHalfLengths{2.2, 1.5, 1.2, 0.75, 0.4};
/// A swing shares a leg with that of the other node: this much of the leg's duration.
constexpr double kLegShare = 0.6;
/// What a swing is made for, of the limits: the middle of a class is not the corner, and
/// neighbours take the rest.
constexpr double kErrorShare = 0.95, kMotorShare = 0.95;
/// Less gain is not worth the swing.
constexpr double kMinGain = 1.03;

/// How long a leg lasts at least: as its nodes are passed with swings.
double LegDuration(const Path& path, std::size_t segment, double acceleration_mm_s2,
                   double node_mm_s) {
  const Segment& leg = path.segments()[segment];
  const double peak =
      std::min(leg.feed_mm_s,
               std::sqrt(node_mm_s * node_mm_s + acceleration_mm_s2 * leg.length_mm));
  const double changing_s = 2 * (peak - node_mm_s) / acceleration_mm_s2;
  const double even_mm = leg.length_mm - changing_s * (peak + node_mm_s) / 2;
  return changing_s + std::max(0.0, even_mm) / peak;
}

double Angle(const Vec2& v) { return std::atan2(v.y(), v.x()); }

Vec2 Direction(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad)}; }

/// What a swing is made for, and the way from there to a corner.
struct CornerClass {
  int bisector = 0, turn = 0;  ///< in kClassRad; the bisector 0..kHalfTurn - 1
  Eigen::Matrix2d path_from_class;
};

CornerClass ClassOf(const Path& path, std::size_t node) {
  const double turn_rad = path.TurnAt(node);
  double middle_rad = Angle(path.DirectionBefore(node)) + turn_rad / 2;
  // A turn to the right is one to the left in the mirror of the y axis.
  Eigen::Matrix2d mirror = Eigen::Matrix2d::Identity();
  if (turn_rad < 0) {
    mirror(0, 0) = -1;
    middle_rad = std::numbers::pi - middle_rad;
  }
  CornerClass found;
  // Half a turn on, a corner is the same with the other sign.
  constexpr int kHalfTurn = 16;
  const int bisector = static_cast<int>(std::lround(middle_rad / kClassRad));
  found.bisector = ((bisector % kHalfTurn) + kHalfTurn) % kHalfTurn;
  found.turn = static_cast<int>(std::lround(std::abs(turn_rad) / kClassRad));
  const double turned_rad = middle_rad - kClassRad * found.bisector;
  Eigen::Matrix2d turned;
  turned << std::cos(turned_rad), -std::sin(turned_rad), std::sin(turned_rad),
      std::cos(turned_rad);
  found.path_from_class = mirror * turned;
  return found;
}

}  // namespace

std::optional<SwingShape> SwingTable::Find(const Key& key, const Tracking& tracking,
                                           const Allowed& allowed) {
  {
    const std::scoped_lock lock(mutex_);
    if (const auto known = made_.find(key); known != made_.end()) return known->second;
  }
  const double middle = kClassRad * key.bisector, turn = kClassRad * key.turn;
  Allowed made_for = allowed;
  made_for.error_mm = kErrorShare * key.error_mm;
  made_for.motor_mm_s2 = kMotorShare * key.motor_mm_s2;
  made_for.jerk_mm_s3 = kMotorShare * key.jerk_mm_s3;
  auto shape = SwingMaker(tracking, made_for, key.acceleration_mm_s2)
                   .Make({Direction(middle - turn / 2), Direction(middle + turn / 2),
                          key.feed_mm_s, key.half_s});
  const std::scoped_lock lock(mutex_);
  return made_.emplace(key, std::move(shape)).first->second;
}

void SwingTable::AddTo(const Path& path, const Tracking& tracking, const Allowed& allowed,
                       const Limits& limits, Speeds& speeds) {
  const double acceleration_mm_s2 = limits.acceleration_mm_s2;
  auto swings = std::make_shared<Swings>();
  swings->of_node.resize(path.node_count());
  std::map<Key, int> used;
  const auto shape_of = [&](const Key& key) {
    const auto [at, fresh] = used.try_emplace(key, -1);
    if (!fresh) return at->second;
    if (const auto shape = Find(key, tracking, allowed)) {
      at->second = static_cast<int>(swings->shapes.size());
      swings->longest_half_s = std::max(swings->longest_half_s, shape->half_s());
      swings->shapes.push_back(*shape);
    }
    return at->second;
  };
  const double kernel_s = tracking.kernel().length_s();
  Key key{kernel_s,           tracking.options().period_s,
          allowed.error_mm,   allowed.motor_mm_s2,
          allowed.jerk_mm_s3, acceleration_mm_s2};
  for (std::size_t node = 1; node + 1 < path.node_count(); ++node) {
    key.feed_mm_s =
        std::min(path.segments()[node - 1].feed_mm_s, path.segments()[node].feed_mm_s);
    double& speed_mm_s = speeds.node_mm_s[node];
    if (speed_mm_s * kMinGain > key.feed_mm_s) continue;
    const double leg_s =
        std::min(LegDuration(path, node - 1, acceleration_mm_s2, speed_mm_s),
                 LegDuration(path, node, acceleration_mm_s2, speed_mm_s));
    const auto length = std::ranges::find_if(kHalfLengths, [&](double of_kernel) {
      return of_kernel <= limits.longest_half &&
             of_kernel * kernel_s <= kLegShare * leg_s;
    });
    if (length == kHalfLengths.end()) continue;
    key.half_s = *length * kernel_s;
    const CornerClass corner = ClassOf(path, node);
    key.bisector = corner.bisector;
    key.turn = corner.turn;
    const int shape = shape_of(key);
    if (shape < 0) continue;
    const double swung_mm_s = swings->shapes[static_cast<std::size_t>(shape)].speed_mm_s;
    if (swung_mm_s < kMinGain * speed_mm_s) continue;
    swings->of_node[node] = {shape, corner.path_from_class};
    speed_mm_s = swung_mm_s;
  }
  speeds.swings = std::move(swings);
}

}  // namespace intaglio::course
