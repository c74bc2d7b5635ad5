#include "engrave/course/contour_error.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engrave/core/check.h"

namespace intaglio::course {
namespace {

/// Far above what the distances are rounded by.
constexpr double kRoundingMm = 1e-6;

struct Place {
  double distance_mm = std::numeric_limits<double>::infinity();
  double s_mm = 0;
  std::size_t segment = 0;
};

class Searcher {
 public:
  Searcher(const Path& path, const SearchWindow& window) : path_(path), window_(window) {}

  /// The first segment of the window of a place.
  void MoveTo(double commanded_s_mm) {
    const auto& s = path_.node_s_mm();
    from_mm_ = commanded_s_mm - window_.back_mm;
    to_mm_ = commanded_s_mm + window_.ahead_mm;
    if (first_ + 1 < path_.segment_count() && s[first_ + 1] < from_mm_) ++first_;
    const bool here = (first_ == 0 || s[first_] < from_mm_) &&
                      (first_ + 1 == path_.segment_count() || s[first_ + 1] >= from_mm_);
    if (here) return;
    const auto end = std::lower_bound(s.begin() + 1, s.end() - 1, from_mm_);
    first_ = static_cast<std::size_t>(end - s.begin()) - 1;
  }

  Place Nearest(const Vec2& point_mm) const {
    const auto& s = path_.node_s_mm();
    Place best;
    for (std::size_t i = first_;
         i < path_.segment_count() && (i == first_ || s[i] <= to_mm_); ++i) {
      const Segment& segment = path_.segments()[i];
      // No place of a segment is farther from its begin than its length.
      const double reach_mm = best.distance_mm + segment.length_mm + kRoundingMm;
      if ((point_mm - segment.begin_mm).squaredNorm() > reach_mm * reach_mm) continue;
      const Foot foot = NearestOn(segment, point_mm);
      if (foot.distance_mm < best.distance_mm) {
        best = {foot.distance_mm, s[i] + foot.at_mm, i};
      }
    }
    return best;
  }

 private:
  const Path& path_;
  SearchWindow window_;
  double from_mm_ = 0, to_mm_ = 0;
  std::size_t first_ = 0;
};

/// The places of a course at instants, and its greatest distance since the one before.
class CourseMeter {
 public:
  CourseMeter(const Path& path, std::span<const Vec2> actual_mm,
              std::span<const double> commanded_s_mm, const SearchWindow& window)
      : searcher_(path, window), actual_mm_(actual_mm), commanded_s_mm_(commanded_s_mm) {}

  Place PlaceAt(std::size_t i) {
    searcher_.MoveTo(commanded_s_mm_[i]);
    return searcher_.Nearest(actual_mm_[i]);
  }
  /// `place` is PlaceAt(i), called just before; `previous` the segment of instant i - 1.
  double WorstUpTo(std::size_t i, const Place& place, std::size_t previous) const {
    constexpr int kBetween = 16;
    double worst_mm = place.distance_mm;
    // The greatest distance may be a cusp between samples, equally far from both legs.
    for (int j = 1; i > 0 && place.segment != previous && j < kBetween; ++j) {
      const Vec2 between =
          actual_mm_[i - 1] + (actual_mm_[i] - actual_mm_[i - 1]) * j / kBetween;
      worst_mm = std::max(worst_mm, searcher_.Nearest(between).distance_mm);
    }
    return worst_mm;
  }

 private:
  Searcher searcher_;
  std::span<const Vec2> actual_mm_;
  std::span<const double> commanded_s_mm_;
};

void MeasureOneSided(const Path& path, std::span<const Vec2> actual_mm,
                     std::span<const double> commanded_s_mm, const SearchWindow& window,
                     PartError& error, std::span<NearestPlace> places) {
  CourseMeter meter(path, actual_mm, commanded_s_mm, window);
  std::size_t previous = 0;
  const auto take = [&error](std::size_t node, double worst_mm) {
    double& known_mm = error.one_sided_mm[node - error.first_node];
    known_mm = std::max(known_mm, worst_mm);
  };
  for (std::size_t i = 0; i < actual_mm.size(); ++i) {
    const Place place = meter.PlaceAt(i);
    const double worst_mm = meter.WorstUpTo(i, place, previous);
    const std::size_t k = previous = place.segment;
    const bool first_half =
        place.s_mm - path.node_s_mm()[k] < path.node_s_mm()[k + 1] - place.s_mm;
    take(first_half ? k : k + 1, worst_mm);
    take(k, worst_mm);
    if (!places.empty()) places[i] = {worst_mm, place.s_mm};
  }
}

double ToChord(const Vec2& point, const Vec2& from, const Vec2& to) {
  const Vec2 chord = to - from;
  const double size = chord.squaredNorm();
  const double share =
      size > 0 ? std::clamp(chord.dot(point - from) / size, 0.0, 1.0) : 0;
  return (point - from - share * chord).norm();
}

struct NodeMiss {
  std::size_t instant = 0;  ///< of the nearest sample
  double miss_mm = 0;
};

NodeMiss MissOf(const Path& path, std::size_t node, std::span<const Vec2> actual_mm,
                std::span<const double> commanded_s_mm, const SearchWindow& window) {
  const double s_mm = path.node_s_mm()[node];
  const Vec2& node_mm = path.node_mm(node);
  const auto begin = std::lower_bound(commanded_s_mm.begin(), commanded_s_mm.end() - 1,
                                      s_mm - window.ahead_mm);
  const auto first = static_cast<std::size_t>(begin - commanded_s_mm.begin());
  std::size_t nearest = first;
  double best = std::numeric_limits<double>::infinity();
  for (std::size_t i = first;
       i < actual_mm.size() && (i == first || commanded_s_mm[i] <= s_mm + window.back_mm);
       ++i) {
    const double size = (actual_mm[i] - node_mm).squaredNorm();
    if (size >= best) continue;
    best = size;
    nearest = i;
  }
  double miss_mm = std::sqrt(best);
  if (nearest > 0)
    miss_mm =
        std::min(miss_mm, ToChord(node_mm, actual_mm[nearest - 1], actual_mm[nearest]));
  if (nearest + 1 < actual_mm.size())
    miss_mm =
        std::min(miss_mm, ToChord(node_mm, actual_mm[nearest], actual_mm[nearest + 1]));
  return {nearest, miss_mm};
}

void MeasureNodes(const Path& path, std::span<const Vec2> actual_mm,
                  std::span<const double> commanded_s_mm, const SearchWindow& window,
                  PartError& error) {
  for (std::size_t i = 0; i < error.node_miss_mm.size(); ++i) {
    error.node_miss_mm[i] =
        MissOf(path, error.first_node + i, actual_mm, commanded_s_mm, window).miss_mm;
  }
}

void CheckSizes(std::span<const Vec2> actual_mm, std::span<const double> commanded_s_mm) {
  Require(actual_mm.size() == commanded_s_mm.size() && actual_mm.size() >= 2,
          "{} actual points, {} commanded", actual_mm.size(), commanded_s_mm.size());
}

/// The nodes from `first` to `last`.
PartError EmptyError(std::size_t first, std::size_t last) {
  const std::vector<double> zeros(last - first + 1, 0);
  return {first, zeros, zeros};
}

/// The nodes that a course may be near to.
PartError EmptyErrorOf(const Path& path, std::span<const double> commanded_s_mm,
                       const SearchWindow& window) {
  const auto& s = path.node_s_mm();
  const double from_mm = commanded_s_mm.front() - window.back_mm;
  const double to_mm = commanded_s_mm.back() + window.ahead_mm;
  const auto begin = std::lower_bound(s.begin() + 1, s.end() - 1, from_mm) - 1;
  const auto end = std::upper_bound(begin + 1, s.end() - 1, to_mm);
  return EmptyError(static_cast<std::size_t>(begin - s.begin()),
                    static_cast<std::size_t>(end - s.begin()));
}

double WorstNode(const std::vector<double>& values) {
  return *std::ranges::max_element(values);
}

}  // namespace

ContourError MeasureContour(const Path& path, std::span<const Vec2> actual_mm,
                            std::span<const double> commanded_s_mm,
                            const SearchWindow& window, std::span<NearestPlace> places) {
  CheckSizes(actual_mm, commanded_s_mm);
  PartError whole = EmptyError(0, path.node_count() - 1);
  MeasureOneSided(path, actual_mm, commanded_s_mm, window, whole, places);
  MeasureNodes(path, actual_mm, commanded_s_mm, window, whole);
  ContourError error;
  error.worst_one_sided_mm = WorstNode(whole.one_sided_mm);
  error.worst_node_miss_mm = WorstNode(whole.node_miss_mm);
  error.one_sided_mm = std::move(whole.one_sided_mm);
  error.node_miss_mm = std::move(whole.node_miss_mm);
  return error;
}

PartError MeasurePart(const Path& path, std::span<const Vec2> actual_mm,
                      std::span<const double> commanded_s_mm,
                      const SearchWindow& window) {
  CheckSizes(actual_mm, commanded_s_mm);
  PartError error = EmptyErrorOf(path, commanded_s_mm, window);
  MeasureOneSided(path, actual_mm, commanded_s_mm, window, error, {});
  MeasureNodes(path, actual_mm, commanded_s_mm, window, error);
  return error;
}

NeighbourError::NeighbourError(const Path& path, std::span<const Vec2> actual_mm,
                               std::span<const double> commanded_s_mm,
                               const SearchWindow& window)
    : path_(path),
      actual_mm_(actual_mm),
      commanded_s_mm_(commanded_s_mm),
      window_(window) {
  CheckSizes(actual_mm, commanded_s_mm);
  CourseMeter meter(path, actual_mm, commanded_s_mm, window);
  for (std::size_t i = 0; i < actual_mm.size(); ++i)
    distance_mm_.push_back(meter.PlaceAt(i).distance_mm);
  const PartError nodes = EmptyErrorOf(path, commanded_s_mm, window);
  for (std::size_t i = 0; i < nodes.node_miss_mm.size(); ++i) {
    const std::size_t node = nodes.first_node + i;
    const NodeMiss found = MissOf(path, node, actual_mm, commanded_s_mm, window);
    nodes_.push_back({node, found.instant, found.miss_mm});
  }
}

// No point between two instants of the measured course is farther from the path than half
// the sum of their distances and of the way between them, and none of the other course
// farther than that and the greater distance of the two courses.
double NeighbourError::WorstOf(std::span<const Vec2> other_mm, std::size_t first,
                               std::size_t last) const {
  const auto off_mm = [&](std::size_t i) { return (other_mm[i] - actual_mm_[i]).norm(); };
  CourseMeter meter(path_, other_mm, commanded_s_mm_, window_);
  double worst_mm = 0, before_mm = off_mm(0);
  for (std::size_t i = 0; i < other_mm.size(); ++i) {
    const double now_mm = off_mm(i);
    const std::size_t from = i > 0 ? i - 1 : 0;
    const double bound_mm = (distance_mm_[from] + distance_mm_[i] +
                             (actual_mm_[i] - actual_mm_[from]).norm()) /
                                2 +
                            std::max(before_mm, now_mm);
    before_mm = now_mm;
    if (bound_mm <= worst_mm) continue;
    const std::size_t previous = meter.PlaceAt(from).segment;
    const Place place = meter.PlaceAt(i);
    worst_mm = std::max(worst_mm, meter.WorstUpTo(i, place, previous));
  }
  for (const NodePlace& node : nodes_) {
    if (node.instant < first || node.instant >= last) continue;
    double off_beside_mm = off_mm(node.instant);
    if (node.instant > 0)
      off_beside_mm = std::max(off_beside_mm, off_mm(node.instant - 1));
    if (node.instant + 1 < other_mm.size())
      off_beside_mm = std::max(off_beside_mm, off_mm(node.instant + 1));
    if (node.distance_mm + off_beside_mm <= worst_mm) continue;
    worst_mm = std::max(
        worst_mm, MissOf(path_, node.node, other_mm, commanded_s_mm_, window_).miss_mm);
  }
  return worst_mm;
}

}  // namespace intaglio::course
