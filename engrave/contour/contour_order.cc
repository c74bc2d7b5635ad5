#include "engrave/contour/contour_order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "engrave/core/check.h"

namespace intaglio::contour {
namespace {

constexpr int kMinEntries = 24;
constexpr int kMaxRounds = 8;
constexpr int kMaxSweeps = 20;
constexpr double kShorter_mm = 1e-6;
constexpr std::size_t kVisitsAReport = 64;

Vec2 EntryOf(std::span<const Contour> contours, const ContourVisit& visit) {
  return PointAt(contours[visit.contour].edges[visit.edge], visit.way_mm);
}

struct Entry {
  ContourVisit visit;
  Vec2 place_mm;
};

std::vector<Entry> EntriesOf(std::span<const Contour> contours, std::uint32_t number) {
  std::vector<Entry> entries;
  const Contour& contour = contours[number];
  const double step_mm = contour.length_mm / kMinEntries;
  for (std::uint32_t e = 0; e < contour.edges.size(); ++e) {
    const Edge& edge = contour.edges[e];
    const int parts = std::max(1, static_cast<int>(std::ceil(edge.length_mm / step_mm)));
    for (int k = 0; k < parts; ++k) {
      const double way_mm = edge.length_mm * k / parts;
      entries.push_back({{number, e, way_mm}, PointAt(edge, way_mm)});
    }
  }
  return entries;
}

/// Entries of all contours, and the choice of one for each.
class EntryChoice {
 public:
  EntryChoice(std::span<const Contour> contours, const Vec2& start,
              const ContourVisits& visits)
      : start_(start), chosen_(contours.size()), places_(contours.size()) {
    for (std::uint32_t k = 0; k < contours.size(); ++k)
      entries_.push_back(EntriesOf(contours, k));
    for (const ContourVisit& visit : visits) {
      order_.push_back(visit.contour);
      chosen_[visit.contour] = visit;
      places_[visit.contour] = EntryOf(contours, visit);
    }
  }

  double Way() const { return IdleWay_mm(places_, start_, order_); }

  void ImproveOrder(const ImproveOptions& options) {
    ImproveOptions of_round = options;
    of_round.progress = {};  // a round is the step
    contour::ImproveOrder(places_, start_, order_, of_round);
  }

  /// The best entry of each contour between those before and behind it, until none is
  /// better.
  void ImproveEntries() {
    for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
      bool better = false;
      for (std::size_t k = 0; k < order_.size(); ++k) better |= ImproveEntry(k);
      if (!better) return;
    }
  }

  ContourVisits Visits() const {
    ContourVisits visits;
    for (const std::uint32_t contour : order_) visits.push_back(chosen_[contour]);
    return visits;
  }

 private:
  bool ImproveEntry(std::size_t position) {
    const std::uint32_t contour = order_[position];
    const Vec2 before = position == 0 ? start_ : places_[order_[position - 1]];
    const bool last = position + 1 == order_.size();
    const Vec2 behind = last ? before : places_[order_[position + 1]];
    const auto way = [&](const Vec2& place) {
      return (place - before).norm() + (last ? 0 : (behind - place).norm());
    };
    double shortest = way(places_[contour]) - kShorter_mm;
    bool better = false;
    for (const Entry& entry : entries_[contour]) {
      const double length = way(entry.place_mm);
      if (length >= shortest) continue;
      shortest = length;
      chosen_[contour] = entry.visit;
      places_[contour] = entry.place_mm;
      better = true;
    }
    return better;
  }

  Vec2 start_;
  std::vector<std::vector<Entry>> entries_;  ///< of each contour
  std::vector<ContourVisit> chosen_;
  std::vector<Vec2> places_;
  VisitOrder order_;
};

}  // namespace

ContourVisits NearestContours(std::span<const Contour> contours, const Vec2& start_mm,
                              const ProgressSink& progress) {
  std::vector<ContourVisit> corners;
  std::vector<Vec2> places;
  for (std::uint32_t c = 0; c < contours.size(); ++c) {
    Require(!contours[c].edges.empty(), "contour {} has no edges", c);
    for (std::uint32_t e = 0; e < contours[c].edges.size(); ++e) {
      corners.push_back({c, e, 0});
      places.push_back(contours[c].edges[e].begin_mm);
    }
  }
  ContourVisits visits;
  Vec2 at = start_mm;
  bool is_wanted = true;
  while (visits.size() < contours.size()) {
    if (progress && visits.size() % kVisitsAReport == 0)
      is_wanted = is_wanted && progress(visits.size(), contours.size());
    const std::uint32_t nearest = is_wanted ? NearestPlace(places, at) : 0;
    visits.push_back(corners[nearest]);
    at = places[nearest];
    // What is made leaves the list; the order of the rest stays.
    std::size_t kept = 0;
    for (std::size_t k = 0; k < corners.size(); ++k) {
      if (corners[k].contour == visits.back().contour) continue;
      corners[kept] = corners[k];
      places[kept++] = places[k];
    }
    corners.resize(kept);
    places.resize(kept);
  }
  return visits;
}

void ImproveContours(std::span<const Contour> contours, const Vec2& start_mm,
                     ContourVisits& visits, const ImproveOptions& options) {
  EntryChoice choice(contours, start_mm, visits);
  double way = choice.Way();
  for (int round = 0; round < kMaxRounds; ++round) {
    const auto done = static_cast<std::uint64_t>(round);
    if (options.progress && !options.progress(done, kMaxRounds)) break;
    choice.ImproveEntries();
    choice.ImproveOrder(options);
    choice.ImproveEntries();
    const double shorter = choice.Way();
    if (way - shorter < kShorter_mm) break;
    way = shorter;
  }
  visits = choice.Visits();
}

double IdleWay_mm(std::span<const Contour> contours, const Vec2& start_mm,
                  std::span<const ContourVisit> visits) {
  double way = 0;
  Vec2 at = start_mm;
  for (const ContourVisit& visit : visits) {
    const Vec2 entry = EntryOf(contours, visit);
    way += (entry - at).norm();
    at = entry;
  }
  return way;
}

Edges EdgesFrom(const Edges& closed, const ContourVisit& visit) {
  Edges edges;
  const Edge& first = closed.at(visit.edge);
  const bool divided = visit.way_mm > 0 && visit.way_mm < first.length_mm;
  const Vec2 entry = PointAt(first, visit.way_mm);
  if (divided)
    edges.push_back(PartOf(first, visit.way_mm, first.length_mm, entry, first.end_mm));
  else
    edges.push_back(first);
  for (std::size_t k = 1; k < closed.size(); ++k)
    edges.push_back(closed[(visit.edge + k) % closed.size()]);
  if (divided) edges.push_back(PartOf(first, 0, visit.way_mm, first.begin_mm, entry));
  return edges;
}

}  // namespace intaglio::contour
