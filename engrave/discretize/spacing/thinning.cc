#include "engrave/discretize/spacing/thinning.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <span>
#include <tuple>
#include <vector>

#include "engrave/core/channels.h"
#include "engrave/core/check.h"
#include "engrave/discretize/spacing/thinning_front.h"

// The points are taken from the lowest up, along the rise, and one is kept unless it is
// too near to one kept before. Those lie at most one spacing below, so a column of a grid
// in x and y, seen from its newest point down, is left as soon as a point is a whole
// spacing lower. (Where heights count by 1 / height_ratio, |rise . d| is at most
// height_ratio times the scaled length of d: the reach in height is the same for every
// rise.)
//
// Why this order: it makes the result independent of the input's, and a front that grows
// upward packs evenly. On the bunny filled at half the spacing the nearest distances vary
// by 5.4 % (coefficient of variation); visiting cell by cell instead costs 8 % of the
// points and varies by 6.2 %.
//
// Most candidates are removed without sorting: the candidates are divided into sheets of
// height, and those too near to a point of a lower sheet are removed at once. Only the
// rest of a sheet is sorted, by the same method again: it is cut into finer sheets, or
// into rows of y when all are at one height, each thinned by the points kept before it.

namespace intaglio::discretize {
namespace {

constexpr std::size_t kMaxPoints = 0xffffffff;
// So many that they fit into the second-level cache, where they are sorted, and that a
// sheet takes whole runs of neighbours from the cloud.
constexpr std::size_t kPointsPerSheet = 16384, kMaxSheets = std::size_t{1} << 16;
constexpr std::size_t kPointsPerFineSheet = 8;
constexpr std::size_t kFew = 24;        // put in order as they are
constexpr std::size_t kLookAhead = 16;  // points fetched into the cache beforehand

ThinningPoint PointOf(const SpacedCloud& cloud, std::size_t i) {
  // + 0.0 turns -0.0 into 0.0: equal points are equal in their bits, too.
  return {cloud.points_mm[i].array() + 0.0, cloud.source[i], cloud.spacing_mm[i]};
}

/// Sheets of equal thickness between two values; a higher value is never in a lower one.
class Sheets {
 public:
  Sheets(double low, double high, std::size_t count)
      : low_(low), count_(count), scale_(static_cast<double>(count) / (high - low)) {
    if (std::isfinite(scale_)) return;
    count_ = 1;
    scale_ = 0;
  }
  std::size_t count() const { return count_; }
  std::size_t Of(double value) const {
    const double at = std::max(0.0, (value - low_) * scale_);
    return static_cast<std::size_t>(std::min(at, static_cast<double>(count_ - 1)));
  }

 private:
  double low_;
  std::size_t count_;
  double scale_;
};

class Thinner {
 public:
  Thinner(const SpacedCloud& candidates, const ThinningOptions& options,
          const SpacedCloud& taken)
      : candidates_(candidates),
        taken_(taken),
        rise_(options.rise),
        reach_mm_(options.min_spacing_mm * options.height_ratio),
        channels_of_source_(options.channels_of_source) {
    Examine(candidates);
    Examine(taken);
    if (candidates.size() == 0) return;
    for (const ChannelMask channel : DistinctChannels(MasksOfSources())) {
      const SourceExtents extents = ExtentsIn(channel);
      kept_fronts_.push_back(
          {channel, ThinningFront(options, bounds_, candidates.size(), extents)});
      if (taken.size() == 0) continue;
      taken_fronts_.push_back(
          {channel, ThinningFront(options, bounds_, taken.size(), extents)});
    }
  }

  SpacedCloud Run() {
    if (candidates_.size() == 0) return {};
    const double largest = static_cast<double>(kMaxSheets);
    const double wanted = std::ceil(static_cast<double>(candidates_.size()) /
                                    static_cast<double>(kPointsPerSheet));
    const auto [low, high] = std::minmax_element(
        candidates_.points_mm.begin(), candidates_.points_mm.end(),
        [this](const Vec3& a, const Vec3& b) { return Along(2, a) < Along(2, b); });
    const Sheets sheets(Along(2, *low), Along(2, *high),
                        static_cast<std::size_t>(std::min(wanted, largest)));
    SortIntoSheets(sheets);
    SortTaken();
    std::vector<ThinningPoint> points;
    for (std::size_t sheet = 0; sheet < sheets.count(); ++sheet) {
      points.clear();
      for (std::uint32_t at = begin_[sheet]; at < begin_[sheet + 1]; ++at) {
        if (at + kLookAhead < order_.size()) {
          __builtin_prefetch(&candidates_.points_mm[order_[at + kLookAhead]]);
        }
        points.push_back(PointOf(candidates_, order_[at]));
      }
      TakeUpTo(points);
      KeepFrom(Filtered(points, taken_fronts_), 2, Checked::kAtNone);
    }
    return std::move(kept_);
  }

 private:
  /// The coordinates of the order: the height along the rise is 2, y is 1, x is 0.
  double Along(int axis, const Vec3& p_mm) const {
    return axis == 2 ? rise_.dot(p_mm) : p_mm[axis];
  }
  void Sort(std::span<ThinningPoint> points) const {
    const auto key = [this](const ThinningPoint& w) {
      return std::tuple(Along(2, w.p_mm), w.p_mm.y(), w.p_mm.x(), w.source, w.spacing_mm,
                        w.p_mm.z());
    };
    std::sort(points.begin(), points.end(),
              [&](const auto& a, const auto& b) { return key(a) < key(b); });
  }

  void Examine(const SpacedCloud& cloud) {
    Require(
        cloud.source.size() == cloud.size() && cloud.spacing_mm.size() == cloud.size(),
        "a cloud of {} points has {} sources and {} spacings", cloud.size(),
        cloud.source.size(), cloud.spacing_mm.size());
    Require(cloud.size() < kMaxPoints, "a cloud of {} points is too large", cloud.size());
    SourceExtent* extent = nullptr;
    std::uint32_t source = 0;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Vec3& p = cloud.points_mm[i];
      const float spacing_mm = cloud.spacing_mm[i];
      Require(std::isfinite(p.x() + p.y() + p.z()),
              "a point to thin is not finite: {} {} {}", p.x(), p.y(), p.z());
      Require(spacing_mm >= 0 && std::isfinite(spacing_mm),
              "a point's spacing_mm must not be negative, is {}", spacing_mm);
      if (extent == nullptr || source != cloud.source[i]) {
        source = cloud.source[i];
        extent = &extents_[source];
      }
      extent->bounds.Extend(p);
      ++extent->count;
      extent->max_spacing_mm = std::max(extent->max_spacing_mm, spacing_mm);
      extent->min_spacing_mm = std::min(extent->min_spacing_mm, spacing_mm);
    }
    for (const auto& [unused, own] : extents_) {
      bounds_.Extend(own.bounds.min_mm);
      bounds_.Extend(own.bounds.max_mm);
      reach_mm_ = std::max(reach_mm_, static_cast<double>(own.max_spacing_mm));
    }
  }

  ChannelMask MaskOf(std::uint32_t source) const {
    if (channels_of_source_.empty()) return kAnyChannel;
    return channels_of_source_.at(source);
  }
  std::vector<ChannelMask> MasksOfSources() const {
    std::vector<ChannelMask> masks;
    for (const auto& [source, unused] : extents_) masks.push_back(MaskOf(source));
    return masks;
  }
  SourceExtents ExtentsIn(ChannelMask channel) const {
    SourceExtents extents = extents_;
    std::erase_if(extents, [&](const auto& extent) {
      return !ShareChannel(MaskOf(extent.first), channel);
    });
    return extents;
  }

  void SortIntoSheets(const Sheets& sheets) {
    begin_.assign(sheets.count() + 1, 0);
    std::vector<std::uint16_t> sheet_of(candidates_.size());
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      const std::size_t sheet = sheets.Of(Along(2, candidates_.points_mm[i]));
      sheet_of[i] = static_cast<std::uint16_t>(sheet);
      ++begin_[sheet + 1];
    }
    std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
    order_.resize(candidates_.size());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for (std::uint32_t i = 0; i < candidates_.size(); ++i) {
      order_[next[sheet_of[i]]++] = i;
    }
  }

  void SortTaken() {
    taken_order_.resize(taken_.size());
    std::iota(taken_order_.begin(), taken_order_.end(), 0U);
    std::sort(taken_order_.begin(), taken_order_.end(),
              [this](std::uint32_t a, std::uint32_t b) {
                return Along(2, taken_.points_mm[a]) < Along(2, taken_.points_mm[b]);
              });
  }

  /// Adds the taken points that are below these points, or near enough above them, to
  /// their fronts.
  void TakeUpTo(std::span<const ThinningPoint> points) {
    if (points.empty() || next_taken_ == taken_order_.size()) return;
    const auto highest = std::max_element(points.begin(), points.end(),
                                          [this](const auto& a, const auto& b) {
                                            return Along(2, a.p_mm) < Along(2, b.p_mm);
                                          });
    const double high_mm = Along(2, highest->p_mm) + reach_mm_ * kReachAllowance;
    for (; next_taken_ < taken_order_.size(); ++next_taken_) {
      const ThinningPoint point = PointOf(taken_, taken_order_[next_taken_]);
      if (Along(2, point.p_mm) > high_mm) return;
      AddTo(taken_fronts_, point);
    }
  }

  /// The points of one channel; one is enough when all have the same.
  struct ChannelFront {
    ChannelMask channel;
    ThinningFront front;
  };

  void AddTo(std::vector<ChannelFront>& fronts, const ThinningPoint& point) {
    const ChannelMask mask = MaskOf(point.source);
    for (auto& [channel, front] : fronts) {
      if (ShareChannel(mask, channel)) front.Add(point);
    }
  }

  /// Those of the points that are not too near to any of the fronts', in any sequence.
  std::span<ThinningPoint> Filtered(std::span<ThinningPoint> points,
                                    std::vector<ChannelFront>& fronts) const {
    if (fronts.size() == 1) return points.first(fronts[0].front.KeepFar(points));
    for (ChannelFront& of : fronts) {
      const auto concerned = std::partition(
          points.begin(), points.end(),
          [&](const auto& p) { return !ShareChannel(MaskOf(p.source), of.channel); });
      const std::size_t others = static_cast<std::size_t>(concerned - points.begin());
      points = points.first(others + of.front.KeepFar(points.subspan(others)));
    }
    return points;
  }

  /// Keeps in order those of the points that are not too near. All of them come after
  /// every kept point. Their coordinates on the axes above `axis` are equal.
  /// Looked::kAtAll: none is too near to a kept point.
  enum class Checked { kAtNone, kAtAll };
  void KeepFrom(std::span<ThinningPoint> points, int axis, Checked checked) {
    const auto in_order = [&] {
      KeepInOrder(checked == Checked::kAtAll ? points : Filtered(points, kept_fronts_));
    };
    if (points.size() <= kFew || axis < 0) return in_order();
    const auto [low, high] = std::minmax_element(
        points.begin(), points.end(), [=, this](const auto& a, const auto& b) {
          return Along(axis, a.p_mm) < Along(axis, b.p_mm);
        });
    const double low_mm = Along(axis, low->p_mm), high_mm = Along(axis, high->p_mm);
    if (low_mm == high_mm) return KeepFrom(points, axis - 1, checked);
    const Sheets sheets(low_mm, high_mm, points.size() / kPointsPerFineSheet);
    if (sheets.count() == 1) return in_order();
    std::vector<std::uint32_t> next(sheets.count() + 1, 0);
    for (const ThinningPoint& point : points) {
      ++next[sheets.Of(Along(axis, point.p_mm)) + 1];
    }
    std::partial_sum(next.begin(), next.end(), next.begin());
    const auto sorted = std::make_unique_for_overwrite<ThinningPoint[]>(points.size());
    for (const ThinningPoint& point : points) {
      sorted[next[sheets.Of(Along(axis, point.p_mm))]++] = point;
    }
    std::size_t begin = 0;
    for (std::size_t sheet = 0; sheet < sheets.count(); ++sheet) {
      const std::span part(&sorted[begin], &sorted[0] + next[sheet]);
      begin = next[sheet];
      KeepFrom(Filtered(part, kept_fronts_), axis, Checked::kAtAll);
    }
  }

  /// Usually few; none is too near to a point kept before.
  void KeepInOrder(std::span<ThinningPoint> points) {
    Sort(points);
    for (std::size_t begin = 0; begin < points.size(); begin += kFew) {
      std::span few = points.subspan(begin, std::min(kFew, points.size() - begin));
      if (begin > 0) {
        few = Filtered(few, kept_fronts_);
        Sort(few);
      }
      KeepFew(few);
    }
  }
  void KeepFew(std::span<ThinningPoint> points) {
    std::size_t kept = 0;
    for (const ThinningPoint& point : points) {
      if (IsTooNear(point, points.first(kept))) continue;
      points[kept++] = point;
      AddTo(kept_fronts_, point);
      kept_.Add(point.p_mm, point.source, point.spacing_mm);
    }
  }

  bool IsTooNear(const ThinningPoint& point,
                 std::span<const ThinningPoint> others) const {
    const ThinningFront& rules = kept_fronts_.front().front;
    return std::any_of(others.begin(), others.end(), [&](const ThinningPoint& other) {
      return rules.AreTooNear(point, other) &&
             ShareChannel(MaskOf(point.source), MaskOf(other.source));
    });
  }

  const SpacedCloud& candidates_;
  const SpacedCloud& taken_;
  Vec3 rise_;
  double reach_mm_;  // in height, of any rule
  const std::vector<ChannelMask>& channels_of_source_;
  Box3 bounds_;
  SourceExtents extents_;
  std::vector<ChannelFront> kept_fronts_, taken_fronts_;
  std::vector<std::uint32_t> begin_;  // of each sheet in order_
  std::vector<std::uint32_t> order_;
  std::vector<std::uint32_t> taken_order_;
  std::size_t next_taken_ = 0;
  SpacedCloud kept_;
};

}  // namespace

SpacedCloud Thin(const SpacedCloud& candidates, const ThinningOptions& options,
                 const SpacedCloud& taken) {
  Require(options.min_spacing_mm > 0 && std::isfinite(options.min_spacing_mm),
          "min_spacing_mm must be positive, is {}", options.min_spacing_mm);
  Require(options.height_ratio >= 1 && options.height_ratio <= 10,
          "height_ratio must be 1..10, is {}", options.height_ratio);
  return Thinner(candidates, options, taken).Run();
}

}  // namespace intaglio::discretize
