#include "services/cli/contour/planned_feeds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "engrave/core/try.h"
#include "services/job/plan/course_motion.h"

namespace intaglio::cli {
namespace {

/// A part of a move beside a corner: as long as the tool needs so much time for.
constexpr double kBesideCornerS = 0.005;
/// No part is shorter: steps of a few micrometres, and four decimals in a program.
constexpr double kMinPartMm = 0.01;
/// How often the speeds of a contour are corrected, by how much at most each time, and
/// the share of the tolerance that is aimed for.
constexpr int kMaxRounds = 20;
constexpr double kMaxSlower = 0.8, kMaxFaster = 1.2, kAimedShare = 0.97;
/// How many accelerations are tried, each smaller than the one before.
constexpr int kMaxAccelerations = 10;
constexpr double kLessAcceleration = 0.7;
/// Above, the first acceleration within the tolerance is taken, not the fastest.
constexpr std::size_t kFewMoves = 5000;

/// From one way along a path to another, at this speed at most.
struct FeedPart {
  double from_mm = 0, to_mm = 0;
  double feed_mm_s = 0;
};

/// The parts of a planned path, each from where the one before ends.
class FeedParts {
 public:
  /// nodes_mm_s: the limit of each node.
  FeedParts(const course::Path& path, const std::vector<double>& nodes_mm_s)
      : path_(path), nodes_mm_s_(nodes_mm_s) {
    for (std::size_t k = 0; k < path.segment_count(); ++k) AddSegment(k);
  }

  const std::vector<FeedPart>& all() const { return parts_; }

 private:
  double LimitAt(std::size_t node, double feed_mm_s) const {
    return std::clamp(nodes_mm_s_[node], course::kMinFeedMmS, feed_mm_s);
  }

  void AddSegment(std::size_t k) {
    const double feed_mm_s = path_.segments()[k].feed_mm_s;
    const double begin_mm = path_.node_s_mm()[k], end_mm = path_.node_s_mm()[k + 1];
    const double first = LimitAt(k, feed_mm_s), last = LimitAt(k + 1, feed_mm_s);
    const double length_mm = end_mm - begin_mm;
    double before_mm = PartBeside(first, feed_mm_s);
    double behind_mm = PartBeside(last, feed_mm_s);
    if (before_mm + behind_mm + kMinPartMm > length_mm) {
      if (length_mm < 2 * kMinPartMm) {
        Add({begin_mm, end_mm, std::min(first, last)});
        return;
      }
      before_mm = behind_mm = length_mm / 2;
    }
    Add({begin_mm, begin_mm + before_mm, first});
    Add({begin_mm + before_mm, end_mm - behind_mm, feed_mm_s});
    Add({end_mm - behind_mm, end_mm, last});
  }

  static double PartBeside(double limit_mm_s, double feed_mm_s) {
    if (limit_mm_s >= feed_mm_s) return 0;
    return std::max(kMinPartMm, limit_mm_s * kBesideCornerS);
  }

  void Add(const FeedPart& part) {
    if (part.to_mm > part.from_mm) parts_.push_back(part);
  }

  const course::Path& path_;
  const std::vector<double>& nodes_mm_s_;
  std::vector<FeedPart> parts_;
};

/// The parts of edges, where neighbours of one edge with one feed are one.
class DividedPath {
 public:
  DividedPath(const contour::Edges& whole, const std::vector<FeedPart>& parts) {
    double edge_begin_mm = 0;
    std::size_t k = 0;
    for (std::size_t i = 0; i < whole.size(); ++i) {
      if (whole[i].length_mm < course::kMinSegmentMm) continue;
      const double edge_end_mm = edge_begin_mm + whole[i].length_mm;
      // Parts end where edges do, to the rounding of a sum.
      const double almost_mm = edge_end_mm - course::kMinSegmentMm / 2;
      while (k < parts.size() && parts[k].from_mm < almost_mm) {
        FeedPart part = parts[k++];
        while (k < parts.size() && parts[k].from_mm < almost_mm &&
               parts[k].feed_mm_s == part.feed_mm_s)
          part.to_mm = parts[k++].to_mm;
        Add(whole[i], i, part.from_mm - edge_begin_mm, part.to_mm - edge_begin_mm,
            part.feed_mm_s);
      }
      edge_begin_mm = edge_end_mm;
    }
  }

  /// As long as each other.
  contour::Edges edges;
  std::vector<double> feeds_mm_s;
  std::vector<std::size_t> move_of;  ///< the edge that it was

 private:
  void Add(const contour::Edge& edge, std::size_t move, double from_mm, double to_mm,
           double feed_mm_s) {
    const bool begins = from_mm < course::kMinSegmentMm;
    const bool ends = to_mm > edge.length_mm - course::kMinSegmentMm;
    const Vec2 begin_mm = begins ? edge.begin_mm : edges.back().end_mm;
    const Vec2 end_mm = ends ? edge.end_mm : contour::PointAt(edge, to_mm);
    edges.push_back(contour::PartOf(edge, begins ? 0 : from_mm,
                                    ends ? edge.length_mm : to_mm, begin_mm, end_mm));
    feeds_mm_s.push_back(feed_mm_s);
    move_of.push_back(move);
  }
};

post::ToolPath PathWithFeeds(const post::ToolPath& path, const DividedPath& divided) {
  post::ToolPath with_feeds{path.name, path.begin_mm, {}};
  for (std::size_t i = 0; i < divided.edges.size(); ++i) {
    for (post::WorkMove move : post::PathOf({divided.edges[i]}, path.name).moves) {
      post::KeepTabAndSpeed(path.moves[divided.move_of[i]], move);
      move.speed_mm_s = divided.feeds_mm_s[i];
      with_feeds.moves.push_back(move);
    }
  }
  return with_feeds;
}

/// What the axes make of a program: each node is passed at the smaller feed beside it.
course::CoursePlan MadeOf(const course::Path& program, const course::AxisPair& axes,
                          const course::PlanOptions& options) {
  const std::vector<course::Segment>& segments = program.segments();
  std::vector<double> nodes_mm_s;
  for (std::size_t k = 0; k + 1 < segments.size(); ++k) {
    nodes_mm_s.push_back(std::min(segments[k].feed_mm_s, segments[k + 1].feed_mm_s));
  }
  return course::EvaluateLaw(
      program, axes, course::PlanSpeeds(program, nodes_mm_s, options.acceleration_mm_s2),
      options);
}

/// That of the controller, with which it passes the nodes of a path as planned: grbl's
/// v^2 = a d s / (1 - s), where s is the sine of half the angle between both legs.
double JunctionDeviationFor(const course::Path& path,
                            const std::vector<double>& nodes_mm_s,
                            double acceleration_mm_s2) {
  double deviation_mm = 0;
  for (std::size_t node = 1; node + 1 < path.node_count(); ++node) {
    const double sine = std::cos(path.TurnAt(node) / 2);
    if (sine <= 0) continue;
    const double square = nodes_mm_s[node] * nodes_mm_s[node];
    deviation_mm =
        std::max(deviation_mm, square * (1 - sine) / (acceleration_mm_s2 * sine));
  }
  return deviation_mm;
}

/// For each node of a planned path the greatest error of the nodes of the program that
/// are nearest to it, mm.
std::vector<double> ErrorsAt(const course::Path& planned, const course::CoursePlan& made,
                             const course::Path& program) {
  const std::vector<double>& all_mm = planned.node_s_mm();
  std::vector<double> errors_mm(all_mm.size());
  for (std::size_t k = 0; k < made.nodes.size(); ++k) {
    const double at_mm = program.node_s_mm()[k];
    const auto next = std::ranges::lower_bound(all_mm, at_mm);
    auto node = static_cast<std::size_t>(next - all_mm.begin());
    if (next == all_mm.end() || (node > 0 && at_mm - all_mm[node - 1] < *next - at_mm))
      --node;
    errors_mm[node] = std::max(
        {errors_mm[node], made.nodes[k].one_sided_mm, made.nodes[k].node_miss_mm});
  }
  return errors_mm;
}

/// One contour as it is planned: the fastest program within the tolerance so far.
struct FastestProgram {
  post::ToolPath path;
  double work_s = 0;
  double worst_mm = 0, junction_deviation_mm = 0;
};

/// Raises and lowers the speed of each node until the error near it is the tolerance.
/// Nullopt: it is not within the tolerance with this acceleration.
Result<std::optional<FastestProgram>> PlanPath(const post::ToolPath& path,
                                               double speed_mm_s,
                                               const course::AxisPair& axes,
                                               const course::PlanOptions& options) {
  const contour::Edges edges = post::EdgesOf(path);
  const auto planned = INTAGLIO_TRY(CoursePathAlong(edges, speed_mm_s));
  const auto plan = INTAGLIO_TRY(course::PlanCourse(planned, axes, options));
  // The ends are passed at rest; how fast the way there is, is a limit, too.
  std::vector<double> nodes_mm_s = plan.law.node_speed_mm_s;
  nodes_mm_s.front() = nodes_mm_s.back() = speed_mm_s;
  std::optional<FastestProgram> fastest;
  for (int round = 0; round < kMaxRounds; ++round) {
    const DividedPath divided(edges, FeedParts(planned, nodes_mm_s).all());
    const auto program = INTAGLIO_TRY(CoursePathAlong(
        divided.edges, [&](std::size_t i) { return divided.feeds_mm_s[i]; }));
    const auto made = MadeOf(program, axes, options);
    if (made.worst_mm() <= options.tolerance_mm &&
        (!fastest || made.law.duration_s < fastest->work_s)) {
      fastest = {PathWithFeeds(path, divided), made.law.duration_s, made.worst_mm(),
                 JunctionDeviationFor(planned, nodes_mm_s, options.acceleration_mm_s2)};
    }
    const std::vector<double> errors_mm = ErrorsAt(planned, made, program);
    for (std::size_t node = 0; node < nodes_mm_s.size(); ++node) {
      const double ratio = kAimedShare * options.tolerance_mm / errors_mm[node];
      nodes_mm_s[node] = std::clamp(
          nodes_mm_s[node] * std::clamp(std::sqrt(ratio), kMaxSlower, kMaxFaster),
          course::kMinFeedMmS, speed_mm_s);
    }
  }
  return fastest;
}

/// False: it is not within the tolerance with this acceleration.
Result<bool> AddPath(const post::ToolPath& path, double speed_mm_s,
                     const course::AxisPair& axes, const course::PlanOptions& options,
                     PlannedFeeds& feeds) {
  if (contour::LengthOf(post::EdgesOf(path)) < course::kMinSegmentMm) {
    feeds.paths.push_back(path);
    return true;
  }
  auto fastest = INTAGLIO_TRY(PlanPath(path, speed_mm_s, axes, options));
  if (!fastest) return false;
  feeds.paths.push_back(std::move(fastest->path));
  feeds.worst_mm = std::max(feeds.worst_mm, fastest->worst_mm);
  feeds.work_s += fastest->work_s;
  feeds.junction_deviation_mm =
      std::max(feeds.junction_deviation_mm, fastest->junction_deviation_mm);
  return true;
}

/// All paths with one acceleration; the first that is not within the tolerance then.
Result<const post::ToolPath*> AddPaths(const std::vector<post::ToolPath>& paths,
                                       double speed_mm_s, const course::AxisPair& axes,
                                       const course::PlanOptions& options,
                                       PlannedFeeds& feeds) {
  feeds = {};
  feeds.acceleration_mm_s2 = options.acceleration_mm_s2;
  for (const post::ToolPath& path : paths) {
    if (!INTAGLIO_TRY(AddPath(path, speed_mm_s, axes, options, feeds))) return &path;
  }
  return nullptr;
}

}  // namespace

Result<PlannedFeeds> PlanFeeds(const std::vector<post::ToolPath>& paths,
                               double speed_mm_s, const MachineSpec& machine) {
  const course::AxisPair axes = INTAGLIO_TRY(CourseAxesOf(machine));
  course::PlanOptions options = CourseLimitsOf(machine);
  options.jerk_mm_s3.reset();  // no controller of this family has a limit
  const double feed_mm_s = std::min(speed_mm_s, CourseFeedOf(machine));
  std::size_t moves = 0;
  for (const post::ToolPath& path : paths) moves += path.moves.size();
  std::optional<PlannedFeeds> fastest;
  const post::ToolPath* outside = nullptr;
  for (int tried = 0; tried < kMaxAccelerations; ++tried) {
    PlannedFeeds feeds;
    outside = INTAGLIO_TRY(AddPaths(paths, feed_mm_s, axes, options, feeds));
    if (outside == nullptr && (!fastest || feeds.work_s < fastest->work_s))
      fastest = std::move(feeds);
    if (fastest && moves > kFewMoves) break;
    options.acceleration_mm_s2 *= kLessAcceleration;
  }
  if (fastest) return *std::move(fastest);
  return Fail(
      ErrorCode::kUnsupported,
      fmt::format("{}: a controller with feeds alone does not keep {:g} um there; "
                  "reduce the speed, or use a greater position_tolerance_um",
                  outside->name, 1e3 * options.tolerance_mm),
      outside->name);
}

}  // namespace intaglio::cli
