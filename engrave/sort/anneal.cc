#include "engrave/sort/anneal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/sort/planned_ticks.h"
#include "engrave/sort/smooth.h"
#include "engrave/sort/stretch.h"

namespace intaglio::sort {
namespace {

constexpr std::size_t kStretch = 8192;
constexpr std::size_t kStretchesAtOnce = 16;
constexpr double kMaxTriesPerRound = 64;
constexpr double kFewestRounds = 2;
constexpr double kMaxTries = 1e6;

// In ticks. Hotter, a good order is lost before it gets better; below the coldest
// nothing moves any more.
constexpr double kHot = 0.12;
constexpr double kCold = 0.03;

double TemperatureAt(double share) { return kHot * std::pow(kCold / kHot, share); }

/// Places [begin, end) of an order.
using Range = std::pair<std::size_t, std::size_t>;

/// The whole order in stretches whose limits differ from round to round.
std::vector<Range> CutInStretches(std::size_t size, std::mt19937_64& generator) {
  std::vector<Range> ranges;
  std::size_t begin = 0;
  std::size_t end = size <= kStretch ? size : kStretch / 4 + generator() % kStretch;
  while (begin < size) {
    end = std::min(end, size);
    ranges.emplace_back(begin, end);
    begin = end;
    end = begin + kStretch;
  }
  return ranges;
}

class Annealing {
 public:
  Annealing(const PointList& points_mm, const OrderOptions& options, Order& order)
      : points_mm_(points_mm),
        options_(options),
        cost_(options.limits, options.rate_hz),
        order_(order),
        generator_(options.anneal.seed) {}

  /// False when `progress` requested cancellation.
  bool Run(const ProgressSink& progress) {
    const double tries = options_.anneal.tries_per_point;
    const double rounds =
        tries > 0 ? std::max(kFewestRounds, std::ceil(tries / kMaxTriesPerRound)) : 0;
    for (double round = 0;; ++round) {
      const double share = options_.anneal.used_share ? options_.anneal.used_share()
                           : rounds > 0               ? round / rounds
                                                      : 1;
      if (share >= 1) return true;
      tries_per_point_ = options_.anneal.used_share ? kMaxTriesPerRound : tries / rounds;
      hot_ = TemperatureAt(share);
      cold_ = options_.anneal.used_share ? hot_ : TemperatureAt(share + 1 / rounds);
      if (!RunRound(share, 1 / std::max(rounds, 1.0), progress)) return false;
    }
  }

 private:
  bool RunRound(double share, double round_share, const ProgressSink& progress) {
    const std::vector<Range> ranges = CutInStretches(order_.size(), generator_);
    const std::uint64_t seed = generator_();
    for (std::size_t first = 0; first < ranges.size(); first += kStretchesAtOnce) {
      const double done = share + round_share * static_cast<double>(first) /
                                      static_cast<double>(ranges.size());
      const auto size = static_cast<double>(order_.size());
      if (progress && !progress(static_cast<std::uint64_t>(std::min(done, 1.0) * size),
                                order_.size())) {
        return false;
      }
      const std::size_t count = std::min(kStretchesAtOnce, ranges.size() - first);
      RunEach(options_.executor, count,
              [&](std::size_t i) { Anneal(ranges[first + i], seed + first + i); });
    }
    return true;
  }

  void Anneal(const Range& range, std::uint64_t seed) {
    PointList points_mm;
    for (std::size_t i = range.first; i < range.second; ++i) {
      points_mm.push_back(points_mm_[order_[i]]);
    }
    Stretch stretch(points_mm, options_.cone, cost_);
    const auto tries = static_cast<std::uint64_t>(tries_per_point_ *
                                                  static_cast<double>(points_mm.size()));
    stretch.Anneal(tries, hot_, cold_, seed);
    Order annealed;
    for (const std::uint32_t i : stretch.order()) {
      annealed.push_back(order_[range.first + i]);
    }
    std::copy(annealed.begin(), annealed.end(),
              order_.begin() + static_cast<std::ptrdiff_t>(range.first));
  }

  const PointList& points_mm_;
  const OrderOptions& options_;
  TickCost cost_;
  Order& order_;
  std::mt19937_64 generator_;
  double tries_per_point_ = 0;
  double hot_ = kHot;  ///< of the round, at its begin
  double cold_ = kHot;
};

}  // namespace

Status CheckAnnealOptions(const OrderOptions& options) {
  INTAGLIO_TRY(CheckSmoothOptions(options));
  const double tries = options.anneal.tries_per_point;
  if (tries >= 0 && tries <= kMaxTries) return {};
  return Fail(
      ErrorCode::kInvalidValue,
      fmt::format("anneal.tries_per_point: {} is outside 0..{}", tries, kMaxTries),
      fmt::format("{}", tries));
}

Order ImproveOrder(const PointList& points_mm, Order order, const OrderOptions& options,
                   const ProgressSink& progress) {
  const auto ticks_of = [&](const Order& of) {
    return PlannedTicks(points_mm, of, options.limits, options.rate_hz);
  };
  const std::uint64_t ticks = ticks_of(order);
  if (IsNearTheBound(ticks, order.size())) return order;
  Order annealed = order;
  if (!Annealing(points_mm, options, annealed).Run(progress)) return {};
  return ticks_of(annealed) < ticks ? annealed : order;
}

Result<Order> OrderByAnnealing(const PointList& points_mm, const OrderOptions& options,
                               const ProgressSink& progress) {
  // One bar for both: the first fifth is the greedy order.
  const std::uint64_t size = points_mm.size();
  const auto part = [&](std::uint64_t begin, std::uint64_t end) -> ProgressSink {
    if (!progress) return nullptr;
    return [=, &progress](std::uint64_t done, std::uint64_t total) {
      return progress(begin + (end - begin) * done / std::max<std::uint64_t>(total, 1),
                      size);
    };
  };
  auto order = OrderSmoothly(points_mm, options, part(0, size / 5));
  if (!order || order->empty()) return order;
  Order improved =
      ImproveOrder(points_mm, std::move(*order), options, part(size / 5, size));
  if (improved.empty()) return Fail(ErrorCode::kCancelled, "the sort was cancelled");
  return improved;
}

}  // namespace intaglio::sort
