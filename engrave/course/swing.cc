#include "engrave/course/swing.h"

#include <algorithm>
#include <cmath>

#include "engrave/course/path.h"
#include "engrave/course/speed_law.h"

namespace intaglio::course {

Vec2 SwingShape::At(double t_s) const {
  const double at = (t_s + half_s()) / knot_s - 1;
  const double below = std::floor(at);
  const auto knot = [this](double i) -> Vec2 {
    if (i < 0 || i >= static_cast<double>(knots_mm.size())) return Vec2::Zero();
    return knots_mm[static_cast<std::size_t>(i)];
  };
  return knot(below) + (at - below) * (knot(below + 1) - knot(below));
}

namespace {

void AddSwing(const SwingShape& shape, const NodeSwing& node, double size,
              double corner_s, double period_s, std::span<Vec2> points_mm) {
  const double half_s = shape.half_s();
  const auto end = static_cast<double>(points_mm.size());
  const double from = std::clamp(std::ceil((corner_s - half_s) / period_s), 0.0, end);
  const double to = std::clamp(std::floor((corner_s + half_s) / period_s) + 1, 0.0, end);
  for (auto i = static_cast<std::size_t>(from); i < static_cast<std::size_t>(to); ++i) {
    points_mm[i] += size * (node.path_from_shape *
                            shape.At(static_cast<double>(i) * period_s - corner_s));
  }
}

}  // namespace

void AddSwings(const Path& path, const SpeedLaw& law, double first_s, double period_s,
               std::span<Vec2> points_mm) {
  if (!law.swings) return;
  const Swings& swings = *law.swings;
  const auto& s_mm = path.node_s_mm();
  const double last_s =
      first_s + period_s * static_cast<double>(points_mm.size()) + swings.longest_half_s;
  auto phase = std::ranges::lower_bound(law.phases, first_s - swings.longest_half_s, {},
                                        &Phase::begin_s);
  if (phase == law.phases.end()) return;
  // Phases begin at nodes, to the rounding of a sum.
  auto node = std::ranges::lower_bound(s_mm, phase->s_mm - kMinSegmentMm / 2);
  for (; phase != law.phases.end() && node != s_mm.end() && phase->begin_s <= last_s;
       ++phase) {
    if (phase->s_mm < *node - kMinSegmentMm / 2) continue;
    const auto k = static_cast<std::size_t>(node - s_mm.begin());
    ++node;
    const NodeSwing& own = swings.of_node[k];
    if (own.shape < 0) continue;
    const SwingShape& shape = swings.shapes[static_cast<std::size_t>(own.shape)];
    AddSwing(shape, own, law.node_speed_mm_s[k] / shape.speed_mm_s,
             phase->begin_s - first_s, period_s, points_mm);
  }
}

}  // namespace intaglio::course
