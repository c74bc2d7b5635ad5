#include "engrave/sort/way/jump_way.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <deque>

#include "engrave/sort/near/near_points.h"

namespace intaglio::sort {
namespace {

constexpr std::size_t kNearCount = 8;
// Places that one change moves at most: so a change takes no longer in a larger layer.
constexpr std::ptrdiff_t kMaxMoved = 30'000;
constexpr std::ptrdiff_t kMaxPiece = 3;
constexpr double kMinGainMm = 1e-9;

NearPoints NearOf(std::span<const Vec2> places_mm) {
  std::vector<Scaled> scaled;
  scaled.reserve(places_mm.size());
  Vec2 low = places_mm.front(), high = low;
  for (const Vec2& at : places_mm) {
    scaled.push_back({static_cast<float>(at.x()), static_cast<float>(at.y()), 0});
    low = low.cwiseMin(at);
    high = high.cwiseMax(at);
  }
  const Vec2 size_mm = (high - low).cwiseMax(1e-3);
  const double typical_mm =
      std::sqrt(size_mm.prod() / static_cast<double>(places_mm.size()));
  return {scaled, kNearCount, static_cast<float>(std::max(1e-4, typical_mm))};
}

class Way {
 public:
  Way(std::span<const Vec2> places_mm, const Vec2& from_mm,
      std::vector<std::uint32_t>& way, const GroupChange& change)
      : places_mm_(places_mm),
        from_mm_(from_mm),
        change_(change),
        way_(way),
        count_(static_cast<std::ptrdiff_t>(way.size())),
        place_(way.size()),
        is_queued_(way.size(), true),
        near_(NearOf(places_mm)) {
    for (std::ptrdiff_t i = 0; i < count_; ++i) place_[At(i)] = i;
    queue_.assign(way.begin(), way.end());
  }

  void Shorten() {
    while (!queue_.empty()) {
      const std::uint32_t point = queue_.front();
      queue_.pop_front();
      is_queued_[point] = false;
      while (Improve(point)) {
      }
    }
  }

 private:
  std::uint32_t At(std::ptrdiff_t i) const { return way_[static_cast<std::size_t>(i)]; }
  /// The length of the step between the places i and i + 1; behind the end there is none.
  double Step(std::ptrdiff_t i) const { return Distance(i, i + 1); }
  double Distance(std::ptrdiff_t i, std::ptrdiff_t j) const {
    if (i >= count_ || j >= count_) return 0;
    const Vec2& a = i < 0 ? from_mm_ : places_mm_[At(i)];
    const Vec2& b = j < 0 ? from_mm_ : places_mm_[At(j)];
    const bool changes = i >= 0 && j >= 0 && !change_.groups.empty() &&
                         change_.groups[At(i)] != change_.groups[At(j)];
    return (a - b).norm() + (changes ? change_.change_mm : 0);
  }

  bool Improve(std::uint32_t point) {
    return std::ranges::any_of(near_.Of(point), [&](std::uint32_t near) {
      return TurnBehind(place_[point], place_[near]) ||
             TurnBefore(place_[point], place_[near]) ||
             MovePiece(place_[point], place_[near]);
    });
  }

  // i and j become neighbours, and so do those behind them.
  bool TurnBehind(std::ptrdiff_t i, std::ptrdiff_t j) {
    if (i > j) std::swap(i, j);
    const double gain = Step(i) + Step(j) - Distance(i, j) - Distance(i + 1, j + 1);
    return Turn(i + 1, j, gain);
  }

  // The same of those before them.
  bool TurnBefore(std::ptrdiff_t i, std::ptrdiff_t j) {
    if (i > j) std::swap(i, j);
    const double gain =
        Step(i - 1) + Step(j - 1) - Distance(i, j) - Distance(i - 1, j - 1);
    return Turn(i, j - 1, gain);
  }

  bool Turn(std::ptrdiff_t first, std::ptrdiff_t last, double gain) {
    if (gain <= kMinGainMm || first >= last || last - first > kMaxMoved) return false;
    QueueAround(first);
    QueueAround(last);
    std::reverse(way_.begin() + first, way_.begin() + last + 1);
    Renumber(first, last);
    return true;
  }

  // A piece that begins or ends at i goes beside j, as it is or turned round.
  bool MovePiece(std::ptrdiff_t i, std::ptrdiff_t j) {
    for (std::ptrdiff_t size = 1; size <= kMaxPiece; ++size) {
      if (MoveTo(i, i + size - 1, j) || MoveTo(i - size + 1, i, j)) return true;
    }
    return false;
  }

  bool MoveTo(std::ptrdiff_t first, std::ptrdiff_t last, std::ptrdiff_t j) {
    if (first < 0 || last >= count_ || (j >= first && j <= last)) return false;
    const double taken = Step(first - 1) + Step(last) - Distance(first - 1, last + 1);
    // Behind `before`: beside j on either side.
    for (const std::ptrdiff_t before : {j, j - 1}) {
      if (before >= first - 1 && before <= last) continue;
      const double given = Step(before);
      for (const bool turned : {false, true}) {
        const std::ptrdiff_t head = turned ? last : first, tail = turned ? first : last;
        const double gain =
            taken + given - Distance(before, head) - Distance(tail, before + 1);
        if (gain > kMinGainMm && Move(first, last, before, turned)) return true;
      }
    }
    return false;
  }

  bool Move(std::ptrdiff_t first, std::ptrdiff_t last, std::ptrdiff_t before,
            bool turned) {
    const std::ptrdiff_t low = std::min(first, before + 1), high = std::max(last, before);
    if (high - low > kMaxMoved) return false;
    QueueAround(first);
    QueueAround(last);
    QueueAround(before);
    const auto begin = way_.begin();
    if (turned) std::reverse(begin + first, begin + last + 1);
    if (before < first)
      std::rotate(begin + before + 1, begin + first, begin + last + 1);
    else
      std::rotate(begin + first, begin + last + 1, begin + before + 1);
    Renumber(low, high);
    return true;
  }

  void Renumber(std::ptrdiff_t first, std::ptrdiff_t last) {
    for (std::ptrdiff_t i = first; i <= last; ++i) place_[At(i)] = i;
  }

  void QueueAround(std::ptrdiff_t i) {
    for (std::ptrdiff_t k = std::max<std::ptrdiff_t>(0, i - 1);
         k <= std::min(count_ - 1, i + 1); ++k) {
      if (is_queued_[At(k)]) continue;
      is_queued_[At(k)] = true;
      queue_.push_back(At(k));
    }
  }

  std::span<const Vec2> places_mm_;
  Vec2 from_mm_;
  GroupChange change_;
  std::vector<std::uint32_t>& way_;
  std::ptrdiff_t count_;
  std::vector<std::ptrdiff_t> place_;  // of each point on the way
  std::vector<bool> is_queued_;
  std::deque<std::uint32_t> queue_;  // around which something may be gained
  NearPoints near_;
};

}  // namespace

void ShortenWay(std::span<const Vec2> places_mm, const Vec2& from_mm,
                std::vector<std::uint32_t>& way, const GroupChange& change) {
  if (way.size() > 1) Way(places_mm, from_mm, way, change).Shorten();
}

}  // namespace intaglio::sort
