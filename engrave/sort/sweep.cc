#include "engrave/sort/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <numeric>
#include <utility>
#include <vector>

#include "engrave/core/shared_progress.h"
#include "engrave/core/try.h"
#include "engrave/sort/beam/lowest_point.h"
#include "engrave/sort/beam/remaining_points.h"
#include "engrave/sort/cone_order.h"
#include "engrave/sort/slabs.h"
#include "engrave/sort/stretch.h"
#include "engrave/sort/tick_cost.h"

namespace intaglio::sort {
namespace {

constexpr double kMinSweepRateHz = 1, kMaxSweepRateHz = 20000;
constexpr double kMaxSweepTries = 1e6;
constexpr std::size_t kPointsPerSweepReport = 1 << 12;

/// Longer pieces of a slab are annealed by themselves, for the sake of the cache.
constexpr std::size_t kLongestSlabPiece = 8192;
/// Points of the neighbouring pieces that a stretch has at its ends and leaves in place.
constexpr std::size_t kNeighbours = 2;
/// In ticks, by trial: the order of nearest points is worse than one that stretches
/// usually begin with (anneal.cc).
constexpr double kSweepHot = 0.25, kSweepCold = 0.03;

/// Places [begin, end) of the order.
struct Piece {
  std::size_t begin = 0, end = 0;

  std::size_t size() const { return end - begin; }
};

/// The third axis costs nothing: it is under way anyway.
motion::Limits WithFreeHeight(motion::Limits limits) {
  constexpr double kFree = 1e9;
  limits.max_speed_mm_s.z() = limits.max_acceleration_mm_s2.z() = kFree;
  return limits;
}

/// How high the lens is for a place, in depths of the glass: that of an upright beam to
/// the place itself. The depth that a height of a leaning beam reaches is greater,
///   d = n h c (1 + q / 2),  q = t^2 (1 - 1/n^2),  c = sqrt(1 + q)  (beam_lean.h),
/// and from its slope in the glass, s = t / (n c), follows t^2 = n^2 s^2 / (1 - s^2 (n^2
/// - 1)).
double HeightOf(const Vec3& place_mm, const BeamCone& cone) {
  if (!cone.lean) return place_mm.z();
  const BeamLean& lean = *cone.lean;
  const double depth_mm = lean.top_mm - place_mm.z();
  if (depth_mm <= 0) return place_mm.z();
  const double n2 = lean.refractive_index * lean.refractive_index;
  const double s2 =
      lean.UpwardAt(place_mm).squaredNorm() / (lean.depth_ratio * lean.depth_ratio);
  const double q = s2 * (n2 - 1) / (1 - s2 * (n2 - 1));
  return lean.top_mm - depth_mm / (std::sqrt(1 + q) * (1 + 0.5 * q));
}

/// Continues from `at_mm` to the nearest point of the slab, again and again.
void AppendNearest(const PointList& points_mm, std::span<const std::uint32_t> slab,
                   const BeamCone& cone, Vec2& at_mm, Order& order) {
  PointList slab_mm;
  slab_mm.reserve(slab.size());
  for (const std::uint32_t point : slab) slab_mm.push_back(points_mm[point]);
  Order members(slab.size());
  std::iota(members.begin(), members.end(), 0U);
  RemainingPoints remaining(slab_mm, members, 0);
  for (std::uint32_t& member : members) {
    const auto taken = remaining.TakeNearest(at_mm.x(), at_mm.y());
    member = taken.index;
    at_mm = {taken.x_mm, taken.y_mm};
  }
  for (const std::uint32_t member : KeepToCone(slab_mm, members, cone)) {
    order.push_back(slab[member]);
  }
  at_mm = points_mm[order.back()].head<2>();
}

class Sweep {
 public:
  Sweep(const PointList& points_mm, const OrderOptions& options)
      : points_mm_(points_mm),
        options_(options),
        cost_(WithFreeHeight(options.limits), options.rate_hz) {}

  /// Empty when `progress` requested cancellation.
  Order Make(const ProgressSink& progress) {
    // The search and the changes together are the progress of one order.
    const std::size_t count = points_mm_.size();
    const ProgressSink of_half =
        progress
            ? [&](std::uint64_t done, std::uint64_t) { return progress(done / 2, count); }
            : ProgressSink();
    SharedProgress shared(of_half, 2 * count);
    if (!shared.GoesOn(0) || !TakeNearest(shared)) return {};
    for (std::size_t phase = 0; phase < 2; ++phase) {
      RunEach(options_.executor, (pieces_.size() + 1 - phase) / 2, [&](std::size_t i) {
        const std::size_t piece = 2 * i + phase;
        if (!shared.cancelled()) Anneal(piece);
        Report(pieces_[piece].size(), shared);
      });
    }
    return shared.cancelled() ? Order() : std::move(order_);
  }

 private:
  bool TakeNearest(SharedProgress& progress) {
    PointList by_height = points_mm_;
    for (Vec3& point : by_height) point.z() = HeightOf(point, options_.cone);
    const std::vector<std::uint64_t> numbers =
        SlabNumbers(by_height, 2, options_.sweep.slab_mm);
    Order by_slab(points_mm_.size());
    std::iota(by_slab.begin(), by_slab.end(), 0U);
    std::sort(by_slab.begin(), by_slab.end(), [&](std::uint32_t a, std::uint32_t b) {
      return std::pair(numbers[a], a) < std::pair(numbers[b], b);
    });
    order_.reserve(points_mm_.size());
    Vec2 at_mm = points_mm_[LowestPoint(points_mm_)].head<2>();
    for (std::size_t begin = 0; begin < by_slab.size();) {
      std::size_t end = begin + 1;
      while (end < by_slab.size() && numbers[by_slab[end]] == numbers[by_slab[begin]]) {
        ++end;
      }
      AppendNearest(points_mm_, std::span(by_slab).subspan(begin, end - begin),
                    options_.cone, at_mm, order_);
      for (std::size_t piece = begin; piece < end; piece += kLongestSlabPiece) {
        pieces_.push_back({piece, std::min(piece + kLongestSlabPiece, end)});
      }
      if (!Report(end - begin, progress)) return false;
      begin = end;
    }
    // Lower heights of the lens first is right for leaning cones of any usual lens; for
    // others points are made earlier.
    if (options_.cone.lean) order_ = KeepToCone(points_mm_, order_, options_.cone);
    return true;
  }

  /// A slab may have few points, and a report takes its time.
  bool Report(std::size_t points, SharedProgress& progress) {
    const std::size_t before = done_.fetch_add(points);
    const std::size_t reports =
        (before + points) / kPointsPerSweepReport - before / kPointsPerSweepReport;
    return reports == 0 ? !progress.cancelled()
                        : progress.GoesOn(reports * kPointsPerSweepReport);
  }

  /// Only its own points move, so every other piece can be annealed at the same time.
  void Anneal(std::size_t number) {
    const Piece& piece = pieces_[number];
    const std::size_t before =
        number == 0 ? 0 : std::min(kNeighbours, pieces_[number - 1].size());
    const std::size_t behind = number + 1 == pieces_.size()
                                   ? 0
                                   : std::min(kNeighbours, pieces_[number + 1].size());
    const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(piece.begin - before);
    const Order present(begin,
                        order_.begin() + static_cast<std::ptrdiff_t>(piece.end + behind));
    PointList stretch_mm;
    stretch_mm.reserve(present.size());
    for (const std::uint32_t point : present) stretch_mm.push_back(points_mm_[point]);
    Stretch stretch(stretch_mm, options_.cone, cost_);
    stretch.Anneal(static_cast<std::uint64_t>(options_.sweep.tries_per_point *
                                              static_cast<double>(piece.size())),
                   kSweepHot, kSweepCold, number);
    std::ranges::transform(stretch.order(), begin,
                           [&](std::uint32_t i) { return present[i]; });
  }

  const PointList& points_mm_;
  const OrderOptions& options_;
  TickCost cost_;
  Order order_;
  std::vector<Piece> pieces_;
  std::atomic<std::size_t> done_ = 0;  ///< in both steps
};

}  // namespace

Status CheckSweepOptions(const OrderOptions& options) {
  INTAGLIO_TRY(CheckThickness("sweep.slab_mm", options.sweep.slab_mm));
  if (!(options.rate_hz >= kMinSweepRateHz && options.rate_hz <= kMaxSweepRateHz)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("rate_hz: {} is outside {}..{}", options.rate_hz,
                            kMinSweepRateHz, kMaxSweepRateHz),
                fmt::format("{}", options.rate_hz));
  }
  const double tries = options.sweep.tries_per_point;
  if (tries >= 0 && tries <= kMaxSweepTries) return {};
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("sweep.tries_per_point: {} is outside 0..{}", tries, kMaxSweepTries),
      fmt::format("{}", tries));
}

Result<Order> OrderBySweep(const PointList& points_mm, const OrderOptions& options,
                           const ProgressSink& progress) {
  if (points_mm.empty()) return Order{};
  Order order = Sweep(points_mm, options).Make(progress);
  if (order.empty()) return Fail(ErrorCode::kCancelled, "the sort was cancelled");
  return order;
}

}  // namespace intaglio::sort
