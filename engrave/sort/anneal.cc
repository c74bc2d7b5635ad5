#include "engrave/sort/anneal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "engrave/core/check.h"
#include "engrave/core/try.h"
#include "engrave/sort/boustrophedon.h"
#include "engrave/sort/planned_ticks.h"
#include "engrave/sort/smooth.h"
#include "engrave/sort/stretch.h"
#include "engrave/sort/stretch_search.h"

namespace intaglio::sort {
namespace {

constexpr std::size_t kStretch = 8192;
constexpr std::size_t kStretchesAtOnce = 16;
/// Maximum tries of a round, and the fewest rounds; the first pass of a search takes up
/// to 100 tries a point.
constexpr double kMaxTriesPerRound = 64, kMaxTriesPerSearch = 128;
constexpr double kFewestRounds = 2, kFewestSearches = 1;
constexpr double kMaxTries = 1e6, kMaxPieces = 1e6;

/// Stages by worth: tries of the first, and by how much each has more.
constexpr double kFirstTries = 10, kMoreTries = 3.2;
/// What a stage saves of what the one before it saved; 0.5 to 0.7 of measured clouds.
constexpr double kNextGain = 0.55;
/// What a try takes on two cores, of annealing and of a search: constants, so that the
/// order is the same on each computer.
constexpr double kTrySeconds = 0.5e-6, kSearchTrySeconds = 0.8e-6;
constexpr double kLongestStageS = 600;

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

/// How stretches are improved.
enum class By { kAnnealing, kSearch };

class Annealing {
 public:
  Annealing(const PointList& points_mm, const OrderOptions& options, Fit fit, By by,
            Order& order)
      : points_mm_(points_mm),
        options_(options),
        cost_(options.limits, options.rate_hz, fit),
        by_(by),
        order_(order),
        generator_(options.anneal.seed) {}

  /// False when `progress` requested cancellation.
  bool Run(const ProgressSink& progress) {
    const double tries = options_.anneal.tries_per_point.value_or(0);
    const bool searches = by_ == By::kSearch;
    const double fewest = searches ? kFewestSearches : kFewestRounds;
    const double max_tries = searches ? kMaxTriesPerSearch : kMaxTriesPerRound;
    const double rounds = tries > 0 ? std::max(fewest, std::ceil(tries / max_tries)) : 0;
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
    if (by_ == By::kSearch) {
      StretchSearch(stretch).Run(tries, seed);
    } else {
      stretch.Anneal(tries, hot_, cold_, seed);
    }
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
  By by_;
  Order& order_;
  std::mt19937_64 generator_;
  double tries_per_point_ = 0;
  double hot_ = kHot;  ///< of the round, at its begin
  double cold_ = kHot;
};

Status CheckRange(const char* name, double value, double min, double max) {
  if (value >= min && value <= max) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("anneal.{}: {} is outside {}..{}", name, value, min, max),
              fmt::format("{}", value));
}

/// The fit that leaves fewer ticks of a stretch in the middle of the order. That the axes
/// can make the way is not enough where the motion keeps more than their limits: then
/// steps fit their neighbours, with a reserve.
Fit BetterFit(const PointList& points_mm, const Order& order,
              const OrderOptions& options) {
  if (options.keeps_more) return Fit::kNeighbours;
  const std::size_t size = std::min(order.size(), kStretch);
  const auto begin =
      order.begin() + static_cast<std::ptrdiff_t>((order.size() - size) / 2);
  const Order middle(begin, begin + static_cast<std::ptrdiff_t>(size));
  OrderOptions of_trial = options;
  of_trial.anneal = {};
  of_trial.anneal.tries_per_point = kFirstTries;
  const auto ticks = [&](Fit fit) {
    Order annealed = middle;
    Annealing(points_mm, of_trial, fit, By::kAnnealing, annealed).Run(nullptr);
    return PlannedTicks(points_mm, annealed, options.limits, options.rate_hz);
  };
  return ticks(Fit::kNeighbours) < ticks(Fit::kWay) ? Fit::kNeighbours : Fit::kWay;
}

/// An order while it is annealed, with its ticks.
class Improvement {
 public:
  Improvement(const PointList& points_mm, Order order, const OrderOptions& options)
      : points_mm_(points_mm), order_(std::move(order)), options_(options) {
    ticks_ = TicksOf(order_);
    if (!IsNearBest()) fit_ = BetterFit(points_mm_, order_, options_);
  }

  Order& order() { return order_; }
  std::uint64_t ticks() const { return ticks_; }
  bool FitsWay() const { return fit_ == Fit::kWay; }
  /// From now on the way has to fit. False: it had to, or need not.
  bool BeginToFitWay() {
    if (fit_ == Fit::kWay || options_.keeps_more) return false;
    fit_ = Fit::kWay;
    return true;
  }
  bool IsNearBest() const { return IsNearTheBound(ticks_, order_.size()); }

  /// Keeps what is annealed where that is better. False when `progress` requested
  /// cancellation.
  bool Anneal(const AnnealOptions& how, By by, const ProgressSink& progress) {
    OrderOptions options = options_;
    options.anneal = how;
    Order annealed = order_;
    if (!Annealing(points_mm_, options, fit_, by, annealed).Run(progress)) return false;
    const std::uint64_t ticks = TicksOf(annealed);
    if (ticks >= ticks_) return true;
    order_ = std::move(annealed);
    ticks_ = ticks;
    return true;
  }

 private:
  std::uint64_t TicksOf(const Order& order) const {
    return PlannedTicks(points_mm_, order, options_.limits, options_.rate_hz);
  }

  const PointList& points_mm_;
  Order order_;
  const OrderOptions& options_;
  std::uint64_t ticks_ = 0;
  Fit fit_ = Fit::kWay;
};

/// A share of a bar whose end is not known: each stage goes half of the way that is left.
ProgressSink StageOf(const ProgressSink& progress, int stage) {
  if (!progress) return nullptr;
  return [&progress, stage](std::uint64_t done, std::uint64_t total) {
    const auto size = static_cast<double>(total);
    const double share = static_cast<double>(done) / std::max(size, 1.0);
    return progress(
        static_cast<std::uint64_t>(size * (1 - std::pow(2, -(stage + share)))), total);
  };
}

/// Goes on in stages, each with more tries than the one before, while the next one
/// promises to save more than it takes; then once more so that the way fits, if it did
/// not have to. The first stage anneals, and so does each in which the way need not fit
/// or for which a search takes too long; the others search, which by trial gains more of
/// an order that is good. False when `progress` requested cancellation.
bool AnnealByWorth(const OrderOptions& options, const ProgressSink& progress,
                   Improvement& order) {
  AnnealOptions how = options.anneal;
  double tries = kFirstTries;
  By by = By::kAnnealing;
  for (int stage = 0;; ++stage) {
    const std::uint64_t before = order.ticks();
    how.tries_per_point = tries;
    how.seed = options.anneal.seed + static_cast<std::uint64_t>(stage);
    if (!order.Anneal(how, by, StageOf(progress, stage))) return false;
    const auto gain = static_cast<double>(before - order.ticks());
    const double saved_s = options.anneal.pieces * kNextGain * gain / options.rate_hz;
    if (order.IsNearBest()) return true;
    const double next_tries =
        kMoreTries * tries * static_cast<double>(order.order().size());
    const auto is_worth_it = [&](double try_s) {
      const double taken_s = next_tries * try_s;
      return saved_s > taken_s && taken_s <= kLongestStageS;
    };
    const bool searches = order.FitsWay() && is_worth_it(kSearchTrySeconds);
    if (searches || is_worth_it(kTrySeconds)) {
      tries *= kMoreTries;
      by = searches ? By::kSearch : By::kAnnealing;
    } else if (order.BeginToFitWay()) {
      by = By::kSearch;
    } else {
      return true;
    }
  }
}

}  // namespace

Status CheckAnnealOptions(const OrderOptions& options) {
  INTAGLIO_TRY(CheckSmoothOptions(options));
  if (options.anneal.start == AnnealStart::kRows)
    INTAGLIO_TRY(CheckBoustrophedonOptions(options));
  INTAGLIO_TRY(CheckRange("tries_per_point", options.anneal.tries_per_point.value_or(0),
                          0, kMaxTries));
  return CheckRange("pieces", options.anneal.pieces, 1, kMaxPieces);
}

Order ImproveOrder(const PointList& points_mm, Order order, const OrderOptions& options,
                   const ProgressSink& progress) {
  Improvement improved(points_mm, std::move(order), options);
  if (improved.IsNearBest()) return std::move(improved.order());
  const AnnealOptions& how = options.anneal;
  const bool goes_on = how.tries_per_point || how.used_share
                           ? improved.Anneal(how, By::kAnnealing, progress)
                           : AnnealByWorth(options, progress, improved);
  if (!goes_on) return {};
  return std::move(improved.order());
}

Result<Order> OrderByAnnealing(const PointList& points_mm, const OrderOptions& options,
                               const ProgressSink& progress) {
  // One bar for both: the first fifth is the order to begin with.
  const std::uint64_t size = points_mm.size();
  const auto part = [&](std::uint64_t begin, std::uint64_t end) -> ProgressSink {
    if (!progress) return nullptr;
    return [=, &progress](std::uint64_t done, std::uint64_t total) {
      return progress(begin + (end - begin) * done / std::max<std::uint64_t>(total, 1),
                      size);
    };
  };
  const auto begin =
      options.anneal.start == AnnealStart::kRows ? OrderByBoustrophedon : OrderSmoothly;
  auto order = begin(points_mm, options, part(0, size / 5));
  if (!order || order->empty()) return order;
  Order improved =
      ImproveOrder(points_mm, std::move(*order), options, part(size / 5, size));
  if (improved.empty()) return Fail(ErrorCode::kCancelled, "the sort was cancelled");
  return improved;
}

}  // namespace intaglio::sort
