#include "engrave/course/correction.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engrave/course/kernel_figures.h"
#include "engrave/course/source_law.h"

// An error is nearly proportional to the speed of its node, so dividing the speed by the
// ratio of the error to the allowed one converges in a few rounds; neighbours that act on
// each other, and legs on which acceleration adds to the error, take more. Where even
// slow nodes miss, and in the further rounds, the acceleration of the leg is lowered.

namespace intaglio::course {
namespace {

/// A rounding error beyond the limit is none.
constexpr double kKept = 1.0001;
/// What a round aims at.
constexpr double kLoadAim = 0.985;
constexpr double kMaxFall = 0.7, kMaxRise = 1.25;
constexpr double kMinSpeedMmS = 0.05;
/// The last rounds only lower speeds, and solve the axes' equations.
constexpr int kLastRounds = 5;
/// Further rounds when no law has kept the limits yet.
constexpr int kFurtherRounds = 14;
constexpr double kLessAcceleration = 0.85, kSomeAcceleration = 0.94;
constexpr double kSlowRatio = 0.35;

double MinFeed(const Path& path, std::size_t node) {
  return std::min(path.segments()[node - 1].feed_mm_s, path.segments()[node].feed_mm_s);
}

double GreatestOf(const std::vector<double>& values) {
  return values.empty() ? 0 : *std::max_element(values.begin(), values.end());
}

void ChangeSpeeds(const Path& path, const SpeedLaw& law,
                  const std::vector<double>& load_ratio, std::size_t first_free,
                  double max_rise, Speeds& speeds) {
  // A node that cannot change any more is relieved by the first one that can.
  const double before = *std::max_element(
      load_ratio.begin(), load_ratio.begin() + static_cast<std::ptrdiff_t>(first_free));
  for (std::size_t node = first_free; node + 1 < path.node_count(); ++node) {
    double load = std::max(load_ratio[node], 1e-9);
    if (node == first_free && before > 1) load = std::max(load, before);
    double factor = std::clamp(kLoadAim / load, kMaxFall, max_rise);
    if (load <= 1) factor = std::max(factor, 1.0);
    double& v = speeds.node_mm_s[node];
    // A limit that is not reached has no effect: fall from what is passed.
    if (factor < 1) v = std::min(v, law.node_speed_mm_s[node] * 1.02 + 0.5);
    v = std::clamp(v * factor, kMinSpeedMmS, MinFeed(path, node));
  }
}

void LowerAccelerations(const Path& path, const SpeedLaw& law,
                        const std::vector<double>& load_ratio, std::size_t first_free,
                        const Speeds& first, bool all_bad, Speeds& speeds) {
  // At the ends a node has no speed that could be lowered.
  const auto is_slow = [&](std::size_t node) {
    if (node == 0 || node + 1 == path.node_count()) return true;
    return law.node_speed_mm_s[node] < kSlowRatio * first.node_mm_s[node];
  };
  for (std::size_t i = first_free - 1; i < path.segment_count(); ++i) {
    bool is_bad = false, is_bad_when_slow = false;
    for (const std::size_t node : {i, i + 1}) {
      if (load_ratio[node] <= kKept) continue;
      is_bad = true;
      is_bad_when_slow = is_bad_when_slow || is_slow(node);
    }
    if (is_bad && all_bad) speeds.acceleration_mm_s2[i] *= kSomeAcceleration;
    if (is_bad_when_slow) speeds.acceleration_mm_s2[i] *= kLessAcceleration;
  }
}

/// A round that changes no speed by more than this changes nothing that is measured.
constexpr double kSameRatio = 1e-4;

bool AreSame(const SpeedLaw& before, const SpeedLaw& now) {
  const auto near = [](double p, double q) {
    return std::abs(p - q) <= kSameRatio * std::max(p, q);
  };
  return near(before.duration_s, now.duration_s) &&
         std::ranges::equal(before.node_speed_mm_s, now.node_speed_mm_s, near);
}

double CornerGuess(const Tracking& tracking, double turn_rad, const Vec2& change,
                   const Allowed& allowed) {
  const auto& axes = tracking.axes();
  const auto& p = axes[0].parameters();
  const auto& q = axes[1].parameters();
  const bool elastic = std::isfinite(p.natural_rad_s) && std::isfinite(q.natural_rad_s);
  const double lag_s = std::max(axes[0].lag_s(), axes[1].lag_s());
  const double error_s =
      elastic ? SourceCornerError(turn_rad, std::min(p.damping_ratio, q.damping_ratio),
                                  p.natural_rad_s, q.natural_rad_s)
              : lag_s * std::sin(turn_rad / 2) / 2;
  double v = allowed.error_mm / std::max(error_s, 1e-12);
  for (int i = 0; i < 2 && allowed.motor_mm_s2 > 0; ++i) {
    const double t_s = 1 / axes[static_cast<std::size_t>(i)].parameters().bandwidth_rad_s;
    if (t_s <= 0) continue;
    v = std::min(v, allowed.motor_mm_s2 * t_s / std::max(std::abs(change[i]), 1e-12));
  }
  return v;
}

double RoundedGuess(const KernelFigures& figures, double turn_rad, const Vec2& change,
                    const Allowed& allowed) {
  double v =
      allowed.error_mm / std::max(2 * std::sin(turn_rad / 2) * figures.rounding_s, 1e-12);
  for (int i = 0; i < 2; ++i) {
    const double step = std::max(std::abs(change[i]), 1e-12);
    if (allowed.motor_mm_s2 > 0) {
      v = std::min(v, allowed.motor_mm_s2 /
                          (step * figures.motor_per_speed[static_cast<std::size_t>(i)]));
    }
    if (allowed.jerk_mm_s3 > 0)
      v = std::min(v, allowed.jerk_mm_s3 / (step * figures.jerk_per_speed));
  }
  return v;
}

/// Straight on, the axes' different lags v |lag_1 - lag_2| shift the course sideways.
double StraightLimit(const Tracking& tracking, const Segment& segment, double error_mm) {
  if (tracking.compensated() || !segment.straight()) return kMaxFeedMmS;
  const Vec2 d = segment.DirectionAt(0);
  const double lag_s = std::abs(tracking.axes()[0].lag_s() - tracking.axes()[1].lag_s());
  const double sideways_s = lag_s * std::abs(d.x() * d.y());
  constexpr double kShare = 0.9;
  return sideways_s > 0 ? std::min(kMaxFeedMmS, kShare * error_mm / sideways_s)
                        : kMaxFeedMmS;
}

/// What one part of a course adds to an evaluation.
struct PartFigures {
  PartError error;
  std::vector<double> load_ratio;  ///< of motor and jerk, for the nodes of `error`
  double motor_mm_s2 = 0, jerk_mm_s3 = 0;
};

/// Puts the greatest of the samples' values to the node nearest to each.
void LoadNodes(const Path& path, const std::vector<double>& commanded_s_mm,
               const std::vector<double>& values, double allowed, PartFigures& found) {
  const auto& s = path.node_s_mm();
  std::size_t k = found.error.first_node;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double at = commanded_s_mm[i];
    while (k + 2 < s.size() && at >= s[k + 1]) ++k;
    const std::size_t near = at - s[k] < s[k + 1] - at ? k : k + 1;
    double& load_ratio = found.load_ratio[near - found.error.first_node];
    load_ratio = std::max(load_ratio, values[i] / allowed);
  }
}

PartFigures FiguresOfPart(const Path& path, const SpeedLaw& law, const Tracking& tracking,
                          const Allowed& allowed, Exactness exactness,
                          const Instants& instants, Part part, double feed_mm_s) {
  const bool with_motor =
      allowed.motor_mm_s2 > 0 || allowed.jerk_mm_s3 > 0 || exactness == Exactness::kAxes;
  // Without a limit the jerk is for the report alone, which is that of the axes.
  const bool with_jerk = allowed.jerk_mm_s3 > 0 || exactness == Exactness::kAxes;
  if (part.begin > 0) --part.begin;  // the one that it shares with the part before
  const Tracked tracked = tracking.FollowPart(path, law, tracking.axes(), exactness,
                                              with_motor, with_jerk, instants, part);
  PartFigures found;
  found.error = MeasurePart(path, tracked.actual_mm, tracked.commanded_s_mm,
                            tracking.WindowFor(feed_mm_s, allowed.error_mm));
  found.load_ratio.assign(found.error.node_miss_mm.size(), 0);
  if (allowed.motor_mm_s2 > 0)
    LoadNodes(path, tracked.commanded_s_mm, tracked.motor_mm_s2, allowed.motor_mm_s2,
              found);
  if (allowed.jerk_mm_s3 > 0)
    LoadNodes(path, tracked.commanded_s_mm, tracked.jerk_mm_s3, allowed.jerk_mm_s3,
              found);
  found.motor_mm_s2 = GreatestOf(tracked.motor_mm_s2);
  found.jerk_mm_s3 = GreatestOf(tracked.jerk_mm_s3);
  return found;
}

}  // namespace

Evaluation Evaluate(const Path& path, const SpeedLaw& law, const Tracking& tracking,
                    const Allowed& allowed, Exactness exactness,
                    const Executor& executor) {
  const Instants instants = tracking.InstantsOf(law, tracking.axes(), exactness);
  const std::vector<Part> parts = PartsOf(instants);
  std::vector<PartFigures> figures(parts.size());
  const double feed_mm_s = path.greatest_feed_mm_s();
  RunEach(executor, parts.size(), [&](std::size_t i) {
    figures[i] = FiguresOfPart(path, law, tracking, allowed, exactness, instants,
                               parts[i], feed_mm_s);
  });
  Evaluation found;
  found.load_ratio.assign(path.node_count(), 0);
  for (const double v : law.node_speed_mm_s)
    found.nodes.push_back({v, 0, std::numeric_limits<double>::infinity()});
  for (const PartFigures& part : figures) {
    for (std::size_t i = 0; i < part.load_ratio.size(); ++i) {
      const std::size_t node = part.error.first_node + i;
      NodeFigures& sum = found.nodes[node];
      sum.one_sided_mm = std::max(sum.one_sided_mm, part.error.one_sided_mm[i]);
      sum.node_miss_mm = std::min(sum.node_miss_mm, part.error.node_miss_mm[i]);
      found.load_ratio[node] = std::max(found.load_ratio[node], part.load_ratio[i]);
    }
    found.motor_mm_s2 = std::max(found.motor_mm_s2, part.motor_mm_s2);
    found.jerk_mm_s3 = std::max(found.jerk_mm_s3, part.jerk_mm_s3);
  }
  for (std::size_t k = 0; k < path.node_count(); ++k) {
    const double error_mm =
        std::max(found.nodes[k].one_sided_mm, found.nodes[k].node_miss_mm);
    found.load_ratio[k] = std::max(found.load_ratio[k], error_mm / allowed.error_mm);
  }
  found.worst_load_ratio = GreatestOf(found.load_ratio);
  return found;
}

Corrected CorrectSpeeds(const Path& path, const Tracking& tracking,
                        const Allowed& allowed, Speeds speeds, int rounds,
                        const Window& window, const Executor& executor) {
  const Speeds first = speeds;
  Corrected best, last;
  bool settling = false;
  for (int round = 0; round < rounds + kFurtherRounds; ++round) {
    SpeedLaw law = PlanSpeeds(
        path, {speeds.node_mm_s, speeds.segment_mm_s, speeds.acceleration_mm_s2});
    law.begin_s = window.begin_s;
    law.swings = speeds.swings;
    AlignBlocks(path, tracking.options().period_s, law);
    const bool same = AreSame(last.law, law);
    if (same && settling && best.holds) break;
    // What has converged is settled at once.
    if (same && !settling) round = std::max(round, rounds - kLastRounds);
    settling = round >= rounds - kLastRounds;
    last.law = std::move(law);
    last.evaluation = Evaluate(path, last.law, tracking, allowed,
                               settling ? Exactness::kAxes : Exactness::kModel, executor);
    last.speeds = speeds;
    auto& load_ratio = last.evaluation.load_ratio;
    std::fill_n(load_ratio.begin(), window.first_counted, 0.0);
    for (std::size_t k = window.first_counted; k < window.first_free; ++k)
      load_ratio[k] /= kFinalSlack;
    last.evaluation.worst_load_ratio = GreatestOf(load_ratio);
    last.holds = last.evaluation.worst_load_ratio <= kKept;
    const bool counts = settling || !tracking.compensated();
    if (last.holds && counts &&
        (!best.holds || last.law.duration_s < best.law.duration_s))
      best = last;
    if (best.holds && round >= rounds) break;
    ChangeSpeeds(path, last.law, load_ratio, window.first_free, settling ? 1.0 : kMaxRise,
                 speeds);
    LowerAccelerations(path, last.law, load_ratio, window.first_free, first,
                       round >= rounds, speeds);
  }
  return best.holds ? best : last;
}

Speeds FirstSpeeds(const Path& path, const Tracking& tracking, const Allowed& allowed,
                   double acceleration_mm_s2) {
  Speeds speeds;
  speeds.acceleration_mm_s2.assign(path.segment_count(), acceleration_mm_s2);
  for (const Segment& segment : path.segments())
    speeds.segment_mm_s.push_back(StraightLimit(tracking, segment, allowed.error_mm));
  speeds.node_mm_s.assign(path.node_count(), 0);
  const KernelFigures figures = tracking.compensated()
                                    ? FiguresOf(tracking.kernel(), tracking.axes())
                                    : KernelFigures{};
  for (std::size_t node = 1; node + 1 < path.node_count(); ++node) {
    const Vec2 change = path.DirectionBehind(node) - path.DirectionBefore(node);
    const double turn_rad = std::abs(path.TurnAt(node));
    const double guess = tracking.compensated()
                             ? RoundedGuess(figures, turn_rad, change, allowed)
                             : CornerGuess(tracking, turn_rad, change, allowed);
    speeds.node_mm_s[node] = std::min(guess, MinFeed(path, node));
  }
  return speeds;
}

}  // namespace intaglio::course
