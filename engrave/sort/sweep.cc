#include "engrave/sort/sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "engrave/core/shared_progress.h"
#include "engrave/core/try.h"
#include "engrave/motion/planner.h"
#include "engrave/sort/cone_order.h"
#include "engrave/sort/near/tick_cost.h"
#include "engrave/sort/slabs.h"
#include "engrave/sort/stretch.h"
#include "engrave/sort/sweep_begin.h"

namespace intaglio::sort {
namespace {

constexpr double kMinSweepRateHz = 1, kMaxSweepRateHz = 50000;
constexpr double kMaxSweepTries = 1e6, kMaxSweepToleranceMm = 100;
constexpr std::size_t kPointsPerSweepReport = 1 << 12;

/// Points of the neighbouring pieces that a stretch has at its ends and leaves in place.
constexpr std::size_t kNeighbours = 2;
/// In ticks, by trial: what a sweep begins with is worse than what stretches usually
/// begin with (anneal.cc).
constexpr double kSweepHot = 0.25, kSweepCold = 0.03;
/// The pitch of a round, in tolerances, by trial. With 2 nothing could change places any
/// more.
constexpr double kPitch = 1.97;
/// By trial: a change of rounds often leaves the tube, and then costs a quarter.
constexpr double kTriesInTube = 3;
/// Rounds leave less freedom than the points of a slab have, so they have to be better by
/// more than a sample errs.
constexpr double kWorthRounds = 0.98;
/// The ways to begin are compared on samples of so many points each, at so many heights:
/// a slab of a dense model has a thousand, and the way to the next one counts.
constexpr std::size_t kSample = 4096, kMaxSamples = 4, kPointsPerSample = 8192;

/// Places [begin, end) of the order.
struct Piece {
  std::size_t begin = 0, end = 0;

  std::size_t size() const { return end - begin; }
};

/// What the way through some points costs.
struct Sample {
  double ticks = 0;
  std::size_t point_count = 0;
};

/// Ticks of a point.
double MeanCost(std::span<const Sample> samples) {
  Sample sum;
  for (const Sample& sample : samples) {
    sum.ticks += sample.ticks;
    sum.point_count += sample.point_count;
  }
  return sum.ticks / static_cast<double>(sum.point_count);
}

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

/// One way to begin, and how it is improved.
class Sweeping {
 public:
  /// `heights_mm`: of each point, as the axis counts them; outlives this.
  Sweeping(const PointList& points_mm, const std::vector<double>& heights_mm,
           const OrderOptions& options, SweptOrder begun)
      : points_mm_(points_mm),
        heights_mm_(heights_mm),
        options_(options),
        cost_(WithFreeHeight(options.limits), options.rate_hz, Fit::kNeighbours),
        order_(KeepToCone(points_mm, begun.order, options.cone)),
        axis_mm_(std::move(begun.axis_mm)) {
    std::size_t begin = 0;
    for (const std::size_t end : begun.ends) {
      pieces_.push_back({begin, end});
      begin = end;
    }
  }

  /// Improves all of it.
  Order Improve(SharedProgress& progress) && {
    // Only its own points move, so every other piece can be annealed at the same time.
    for (std::size_t phase = 0; phase < 2; ++phase) {
      RunEach(options_.executor, (pieces_.size() + 1 - phase) / 2, [&](std::size_t i) {
        const std::size_t number = 2 * i + phase;
        if (!progress.cancelled()) Anneal(number);
        Report(pieces_[number].size(), progress);
      });
    }
    return std::move(order_);
  }

  /// How many samples a way to begin is compared by.
  static std::size_t SampleCount(std::size_t point_count) {
    return std::clamp<std::size_t>(point_count / kPointsPerSample, 1, kMaxSamples);
  }

  /// The ticks of one sample as they are planned, the slow axis included, once the pieces
  /// around its place are improved.
  Sample CostOfSample(std::size_t sample) const {
    const std::size_t count = order_.size();
    const std::size_t place = count * (2 * sample + 1) / (2 * SampleCount(count));
    auto piece = std::ranges::upper_bound(pieces_, place, {}, &Piece::end);
    Order made;
    while (piece != pieces_.end() && made.size() < kSample) {
      const std::size_t begin = piece->size() <= kSample        ? piece->begin
                                : place + kSample <= piece->end ? place
                                                                : piece->end - kSample;
      const Piece part{begin, std::min(begin + kSample, piece->end)};
      Annealed(part, part, 0, [&](const Stretch& stretch) {
        for (const std::uint32_t i : stretch.order())
          made.push_back(order_[part.begin + i]);
      });
      ++piece;
    }
    return {PlannedCost(made), made.size()};
  }

 private:
  /// Ticks of the motion through these points.
  double PlannedCost(const Order& made) const {
    motion::PlanOptions plan;
    plan.limits = options_.limits;
    plan.rate_hz = options_.rate_hz;
    plan.continuous = true;
    plan.sweep_mm = options_.sweep.tolerance_mm;
    const auto at = [&](std::uint32_t i) {
      return Vec3(points_mm_[i].x(), points_mm_[i].y(), heights_mm_[i]);
    };
    const auto planner = motion::MakePlanner(plan, at(made.front()));
    std::vector<motion::Segment> segments;
    for (const std::uint32_t i : made) {
      planner->Append(at(i), -1, false, segments);
      segments.clear();
    }
    planner->Finish(segments);
    return static_cast<double>(planner->ticks());
  }

  void Anneal(std::size_t number) {
    const Piece& piece = pieces_[number];
    Piece with = piece;
    if (number > 0) with.begin -= std::min(kNeighbours, pieces_[number - 1].size());
    if (number + 1 < pieces_.size()) {
      with.end += std::min(kNeighbours, pieces_[number + 1].size());
    }
    Annealed(piece, with, number, [&](const Stretch& stretch) {
      const auto begin = order_.begin() + static_cast<std::ptrdiff_t>(with.begin);
      const Order present(begin, begin + static_cast<std::ptrdiff_t>(with.size()));
      std::ranges::transform(stretch.order(), begin,
                             [&](std::uint32_t i) { return present[i]; });
    });
  }

  /// Anneals the places of `piece` among those `with` its neighbours.
  template <typename Take>
  void Annealed(const Piece& piece, const Piece& with, std::uint64_t seed,
                Take&& take) const {
    PointList stretch_mm;
    std::vector<double> heights_mm;
    for (std::size_t place = with.begin; place < with.end; ++place) {
      stretch_mm.push_back(points_mm_[order_[place]]);
      heights_mm.push_back(heights_mm_[order_[place]]);
    }
    HeightTube tube;
    if (!axis_mm_.empty()) {
      tube = {heights_mm, std::span(axis_mm_).subspan(with.begin, with.size()),
              options_.sweep.tolerance_mm};
    }
    Stretch stretch(stretch_mm, options_.cone, cost_, tube);
    const double tries = options_.sweep.tries_per_point *
                         static_cast<double>(piece.size()) *
                         (axis_mm_.empty() ? 1 : kTriesInTube);
    stretch.Anneal(static_cast<std::uint64_t>(tries), kSweepHot, kSweepCold, seed);
    take(stretch);
  }

  /// A slab may have few points, and a report takes its time.
  void Report(std::size_t points, SharedProgress& progress) {
    const std::size_t before = done_.fetch_add(points);
    const std::size_t reports =
        (before + points) / kPointsPerSweepReport - before / kPointsPerSweepReport;
    if (reports > 0) progress.GoesOn(reports * kPointsPerSweepReport);
  }

  const PointList& points_mm_;
  const std::vector<double>& heights_mm_;
  const OrderOptions& options_;
  TickCost cost_;
  Order order_;
  std::vector<double> axis_mm_;
  std::vector<Piece> pieces_;
  std::atomic<std::size_t> done_ = 0;
};

/// Empty when `progress` requested cancellation.
Order MakeSweep(const PointList& points_mm, const OrderOptions& options,
                const ProgressSink& progress) {
  SharedProgress shared(progress, points_mm.size());
  if (!shared.GoesOn(0)) return {};
  PointList lifted_mm = points_mm;
  std::vector<double> heights_mm;
  heights_mm.reserve(points_mm.size());
  for (Vec3& point : lifted_mm) {
    heights_mm.push_back(point.z() = HeightOf(point, options.cone));
  }
  Sweeping slabs(points_mm, heights_mm, options,
                 BeginInSlabs(lifted_mm, options.sweep.slab_mm));
  if (!shared.GoesOn(0)) return {};
  if (options.sweep.tolerance_mm == 0) {
    Order order = std::move(slabs).Improve(shared);
    return shared.cancelled() ? Order() : order;
  }
  Sweeping rounds(points_mm, heights_mm, options,
                  BeginInRounds(lifted_mm, kPitch * options.sweep.tolerance_mm));
  // Rounds first, which take longer: the workers end together.
  const std::size_t count = Sweeping::SampleCount(points_mm.size());
  std::vector<Sample> samples(2 * count);
  RunEach(options.executor, 2 * count, [&](std::size_t i) {
    samples[i] = (i < count ? rounds : slabs).CostOfSample(i % count);
  });
  const double in_rounds = MeanCost(std::span(samples).first(count));
  const double in_slabs = MeanCost(std::span(samples).last(count));
  Order order =
      std::move(in_rounds < kWorthRounds * in_slabs ? rounds : slabs).Improve(shared);
  return shared.cancelled() ? Order() : order;
}

}  // namespace

Status CheckSweepOptions(const OrderOptions& options) {
  INTAGLIO_TRY(CheckThickness("sweep.slab_mm", options.sweep.slab_mm));
  if (!(options.rate_hz >= kMinSweepRateHz && options.rate_hz <= kMaxSweepRateHz)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("rate_hz: {} is outside {}..{}", options.rate_hz,
                            kMinSweepRateHz, kMaxSweepRateHz),
                fmt::format("{}", options.rate_hz));
  }
  const double tolerance_mm = options.sweep.tolerance_mm;
  if (!(tolerance_mm >= 0 && tolerance_mm <= kMaxSweepToleranceMm)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("sweep.tolerance_mm: {} is outside 0..{}", tolerance_mm,
                            kMaxSweepToleranceMm),
                fmt::format("{}", tolerance_mm));
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
  Order order = MakeSweep(points_mm, options, progress);
  if (order.empty()) return Fail(ErrorCode::kCancelled, "the sort was cancelled");
  return order;
}

}  // namespace intaglio::sort
