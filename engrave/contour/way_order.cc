#include "engrave/contour/way_order.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace intaglio::contour {
namespace {

constexpr std::size_t kNeighbours = 10;
constexpr std::size_t kMaxSegment = 3;
constexpr double kGain_mm = 1e-9;
// Tries copy the path: their number is limited on large boards.
constexpr double kMaxCopied = 6e7;
constexpr std::uint64_t kTriesAReport = 256;

/// For each place the nearest others, nearest first. The start is the last place.
std::vector<std::vector<std::uint32_t>> NearLists(std::span<const Vec2> places) {
  const std::size_t count = places.size();
  std::vector<std::uint32_t> by_x(count);
  std::iota(by_x.begin(), by_x.end(), 0U);
  std::sort(by_x.begin(), by_x.end(), [&](std::uint32_t a, std::uint32_t b) {
    return places[a].x() != places[b].x() ? places[a].x() < places[b].x() : a < b;
  });
  std::vector<std::vector<std::uint32_t>> lists(count);
  using Entry = std::pair<double, std::uint32_t>;
  std::vector<Entry> heap;  // the farthest first
  for (std::size_t k = 0; k < count; ++k) {
    const Vec2& place = places[by_x[k]];
    heap.clear();
    const auto visit = [&](std::size_t other) {
      const double dx = places[by_x[other]].x() - place.x();
      if (heap.size() == kNeighbours && dx * dx >= heap.front().first) return false;
      heap.push_back({(places[by_x[other]] - place).squaredNorm(), by_x[other]});
      std::push_heap(heap.begin(), heap.end());
      if (heap.size() <= kNeighbours) return true;
      std::pop_heap(heap.begin(), heap.end());
      heap.pop_back();
      return true;
    };
    for (std::size_t o = k; o-- > 0;) {
      if (!visit(o)) break;
    }
    for (std::size_t o = k + 1; o < count; ++o) {
      if (!visit(o)) break;
    }
    std::sort_heap(heap.begin(), heap.end());
    for (const Entry& entry : heap) lists[by_x[k]].push_back(entry.second);
  }
  return lists;
}

/// A path from the start, which is its place 0 and stays there.
class Path {
 public:
  Path(std::span<const Vec2> places, const Vec2& start,
       std::span<const std::uint32_t> order)
      : places_(places.begin(), places.end()) {
    places_.push_back(start);
    near_ = NearLists(places_);
    visits_.push_back(static_cast<std::uint32_t>(places.size()));
    visits_.insert(visits_.end(), order.begin(), order.end());
    positions_.resize(visits_.size());
    for (std::size_t p = 0; p < visits_.size(); ++p) Put(p, visits_[p]);
    queued_.assign(visits_.size(), 0);
  }

  void ImproveAll() {
    for (const std::uint32_t place : visits_) Queue(place);
    ImproveQueued();
  }

  /// Exchanges edges near each other at random; undone when the path gets longer.
  void TryKick(std::mt19937& random) {
    const std::size_t count = visits_.size();
    if (count < 8) return;
    const std::size_t span = std::min<std::size_t>(50, count - 2);
    const std::size_t begin = 1 + random() % (count - span);
    std::size_t cuts[3];
    for (std::size_t& cut : cuts) cut = begin + random() % span;
    std::sort(std::begin(cuts), std::end(cuts));
    if (cuts[0] == cuts[1] || cuts[1] == cuts[2]) return;
    const std::vector<std::uint32_t> before = visits_;
    const std::size_t middle = cuts[0] + cuts[2] - cuts[1];
    gain_ = WayBefore(cuts[0]) + WayBefore(cuts[1]) + WayBefore(cuts[2]);
    std::rotate(visits_.begin() + cuts[0], visits_.begin() + cuts[1],
                visits_.begin() + cuts[2]);
    gain_ -= WayBefore(cuts[0]) + WayBefore(middle) + WayBefore(cuts[2]);
    for (std::size_t p = cuts[0]; p < cuts[2]; ++p) Put(p, visits_[p]);
    for (const std::size_t p : {cuts[0] - 1, cuts[0], middle - 1, middle, cuts[2] - 1})
      Queue(visits_[p]);
    if (cuts[2] < count) Queue(visits_[cuts[2]]);
    ImproveQueued();
    if (gain_ >= 0) return;
    visits_ = before;
    for (std::size_t p = 0; p < count; ++p) Put(p, visits_[p]);
  }

  VisitOrder Order() const { return {visits_.begin() + 1, visits_.end()}; }

 private:
  void Put(std::size_t position, std::uint32_t place) {
    visits_[position] = place;
    positions_[place] = position;
  }
  void Queue(std::uint32_t place) {
    if (queued_[place]) return;
    queued_[place] = 1;
    queue_.push_back(place);
  }
  double Between(std::uint32_t a, std::uint32_t b) const {
    return (places_[a] - places_[b]).norm();
  }
  /// The way from position p - 1 to p; behind the end there is none.
  double WayBefore(std::size_t p) const {
    return p < visits_.size() ? Between(visits_[p - 1], visits_[p]) : 0;
  }
  void ImproveQueued() {
    for (std::size_t k = 0; k < queue_.size(); ++k) {
      const std::uint32_t place = queue_[k];
      queued_[place] = 0;
      while (TryReversals(place) || TryMoves(place)) {
      }
    }
    queue_.clear();
  }

  /// Positions from .. to, both included, the other way round.
  void Reverse(std::size_t from, std::size_t to) {
    for (const std::size_t p : {from - 1, from, to, to + 1}) {
      if (p < visits_.size()) Queue(visits_[p]);
    }
    std::reverse(visits_.begin() + from, visits_.begin() + to + 1);
    for (std::size_t p = from; p <= to; ++p) positions_[visits_[p]] = p;
  }

  bool ReverseIfShorter(std::size_t from, std::size_t to) {
    if (from == 0 || from >= to) return false;
    const double before = WayBefore(from) + WayBefore(to + 1);
    const double after =
        Between(visits_[from - 1], visits_[to]) +
        (to + 1 < visits_.size() ? Between(visits_[from], visits_[to + 1]) : 0);
    if (before - after < kGain_mm) return false;
    gain_ += before - after;
    Reverse(from, to);
    return true;
  }

  /// Joins the place and one of its neighbours by reversing what lies between.
  bool TryReversals(std::uint32_t place) {
    for (const std::uint32_t near : near_[place]) {
      const std::size_t i = positions_[place];
      const std::size_t j = positions_[near];
      const std::size_t low = std::min(i, j);
      const std::size_t high = std::max(i, j);
      if (high - low < 2) continue;
      if (ReverseIfShorter(low + 1, high) || ReverseIfShorter(low, high - 1)) return true;
    }
    // The end is free: what follows the place may run backwards.
    return ReverseIfShorter(positions_[place] + 1, visits_.size() - 1);
  }

  /// Moves the place, with up to two that follow or precede it, to one of its neighbours.
  bool TryMoves(std::uint32_t place) {
    for (std::size_t length = 1; length <= kMaxSegment; ++length) {
      for (const bool ends_here : {false, true}) {
        const std::size_t at = positions_[place];
        const std::size_t from = ends_here ? at + 1 - std::min(length, at + 1) : at;
        if (from == 0 || from + length > visits_.size()) continue;
        for (const std::uint32_t near : near_[place]) {
          if (MoveIfShorter(from, length, positions_[near], ends_here)) return true;
        }
      }
    }
    return false;
  }

  /// The segment with the place at its beginning or end, beside position `to`.
  bool MoveIfShorter(std::size_t from, std::size_t length, std::size_t to,
                     bool place_at_end) {
    const std::size_t last = from + length - 1;
    if (to >= from && to <= last) return false;
    const double removed =
        WayBefore(from) + WayBefore(last + 1) -
        (last + 1 < visits_.size() ? Between(visits_[from - 1], visits_[last + 1]) : 0);
    const std::uint32_t place = visits_[place_at_end ? last : from];
    const std::uint32_t other = visits_[place_at_end ? from : last];
    // Behind `to` the place comes first, before it last.
    for (const bool behind : {true, false}) {
      if (!behind && to == 0) continue;
      const std::size_t gap = behind ? to + 1 : to;  // between gap - 1 and gap
      if (gap >= from && gap <= last + 1) continue;
      double added = Between(visits_[to], place);
      const std::size_t far = behind ? to + 1 : to - 1;
      if (far < visits_.size()) added += Between(visits_[far], other) - WayBefore(gap);
      if (removed - added < kGain_mm) continue;
      gain_ += removed - added;
      Move(from, length, gap, behind == place_at_end);
      return true;
    }
    return false;
  }

  void Move(std::size_t from, std::size_t length, std::size_t gap, bool reversed) {
    const std::size_t last = from + length - 1;
    for (const std::size_t p : {from - 1, from, last, last + 1, gap - 1, gap}) {
      if (p < visits_.size()) Queue(visits_[p]);
    }
    const auto begin = visits_.begin();
    if (reversed) std::reverse(begin + from, begin + last + 1);
    if (gap > last)
      std::rotate(begin + from, begin + last + 1, begin + gap);
    else
      std::rotate(begin + gap, begin + from, begin + last + 1);
    const std::size_t end = std::max(gap, last + 1);
    for (std::size_t p = std::min(gap, from); p < end; ++p) positions_[visits_[p]] = p;
  }

  std::vector<Vec2> places_;  ///< the start is the last
  std::vector<std::vector<std::uint32_t>> near_;
  std::vector<std::uint32_t> visits_;
  std::vector<std::size_t> positions_;
  std::vector<char> queued_;
  std::vector<std::uint32_t> queue_;
  double gain_ = 0;
};

}  // namespace

std::uint32_t NearestPlace(std::span<const Vec2> places_mm, const Vec2& at_mm) {
  double nearest2 = std::numeric_limits<double>::infinity();
  for (const Vec2& place : places_mm)
    nearest2 = std::min(nearest2, (place - at_mm).squaredNorm());
  const double reach = std::sqrt(nearest2) + kEqualDistance_mm;
  std::size_t best = places_mm.size();
  double best_dy = 0;
  for (std::size_t k = 0; k < places_mm.size(); ++k) {
    const Vec2 way = places_mm[k] - at_mm;
    if (way.squaredNorm() > reach * reach) continue;
    const double dy = std::abs(way.y());
    if (best < places_mm.size() && dy >= best_dy - kEqualDistance_mm) continue;
    best = k;
    best_dy = dy;
  }
  return static_cast<std::uint32_t>(best);
}

VisitOrder NearestOrder(std::span<const Vec2> places_mm, const Vec2& start_mm) {
  VisitOrder order;
  VisitOrder left(places_mm.size());
  std::iota(left.begin(), left.end(), 0U);
  std::vector<Vec2> places(places_mm.begin(), places_mm.end());
  Vec2 at = start_mm;
  while (!left.empty()) {
    const std::uint32_t nearest = NearestPlace(places, at);
    at = places[nearest];
    order.push_back(left[nearest]);
    left.erase(left.begin() + nearest);
    places.erase(places.begin() + nearest);
  }
  return order;
}

void ImproveOrder(std::span<const Vec2> places_mm, const Vec2& start_mm,
                  VisitOrder& order, const ImproveOptions& options) {
  if (order.size() < 2) return;
  Path path(places_mm, start_mm, order);
  path.ImproveAll();
  std::mt19937 random(options.seed);
  const double count = static_cast<double>(order.size());
  const double tries = std::min(options.tries_per_place * count, kMaxCopied / count);
  const auto try_count = static_cast<std::uint64_t>(std::ceil(tries));
  for (std::uint64_t k = 0; k < try_count; ++k) {
    if (options.progress && k % kTriesAReport == 0 && !options.progress(k, try_count))
      break;
    path.TryKick(random);
  }
  order = path.Order();
}

double IdleWay_mm(std::span<const Vec2> places_mm, const Vec2& start_mm,
                  std::span<const std::uint32_t> order) {
  double way = 0;
  Vec2 at = start_mm;
  for (const std::uint32_t k : order) {
    way += (places_mm[k] - at).norm();
    at = places_mm[k];
  }
  return way;
}

}  // namespace intaglio::contour
