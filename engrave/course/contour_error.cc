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

  /// The first segment of the window of a place; call with ascending places.
  void MoveTo(double commanded_s_mm) {
    const auto& s = path_.node_s_mm();
    from_mm_ = commanded_s_mm - window_.back_mm;
    to_mm_ = commanded_s_mm + window_.ahead_mm;
    while (first_ + 1 < path_.segment_count() && s[first_ + 1] < from_mm_) ++first_;
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

void MeasureOneSided(const Path& path, std::span<const Vec2> actual_mm,
                     std::span<const double> commanded_s_mm, const SearchWindow& window,
                     ContourError& error, std::span<NearestPlace> places) {
  constexpr int kBetween = 16;
  Searcher searcher(path, window);
  std::size_t previous = 0;
  for (std::size_t i = 0; i < actual_mm.size(); ++i) {
    searcher.MoveTo(commanded_s_mm[i]);
    const Place place = searcher.Nearest(actual_mm[i]);
    double worst_mm = place.distance_mm;
    // The greatest distance may be a cusp between samples, equally far from both legs.
    for (int j = 1; i > 0 && place.segment != previous && j < kBetween; ++j) {
      const Vec2 between =
          actual_mm[i - 1] + (actual_mm[i] - actual_mm[i - 1]) * j / kBetween;
      worst_mm = std::max(worst_mm, searcher.Nearest(between).distance_mm);
    }
    previous = place.segment;
    const std::size_t k = place.segment;
    const bool first_half =
        place.s_mm - path.node_s_mm()[k] < path.node_s_mm()[k + 1] - place.s_mm;
    const std::size_t near = first_half ? k : k + 1;
    error.one_sided_mm[near] = std::max(error.one_sided_mm[near], worst_mm);
    error.one_sided_mm[k] = std::max(error.one_sided_mm[k], worst_mm);
    error.worst_one_sided_mm = std::max(error.worst_one_sided_mm, worst_mm);
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

void MeasureNodes(const Path& path, std::span<const Vec2> actual_mm,
                  std::span<const double> commanded_s_mm, const SearchWindow& window,
                  ContourError& error) {
  std::size_t first = 0;
  for (std::size_t node = 0; node < path.node_count(); ++node) {
    const double s_mm = path.node_s_mm()[node];
    const Vec2& node_mm = path.node_mm(node);
    while (first + 1 < actual_mm.size() && commanded_s_mm[first] < s_mm - window.ahead_mm)
      ++first;
    std::size_t nearest = first;
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = first;
         i < actual_mm.size() &&
         (i == first || commanded_s_mm[i] <= s_mm + window.back_mm);
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
    error.node_miss_mm[node] = miss_mm;
    error.worst_node_miss_mm = std::max(error.worst_node_miss_mm, miss_mm);
  }
}

}  // namespace

ContourError MeasureContour(const Path& path, std::span<const Vec2> actual_mm,
                            std::span<const double> commanded_s_mm,
                            const SearchWindow& window, std::span<NearestPlace> places) {
  Require(actual_mm.size() == commanded_s_mm.size() && actual_mm.size() >= 2,
          "{} actual points, {} commanded", actual_mm.size(), commanded_s_mm.size());
  ContourError error;
  error.one_sided_mm.assign(path.node_count(), 0);
  error.node_miss_mm.assign(path.node_count(), 0);
  MeasureOneSided(path, actual_mm, commanded_s_mm, window, error, places);
  MeasureNodes(path, actual_mm, commanded_s_mm, window, error);
  return error;
}

}  // namespace intaglio::course
