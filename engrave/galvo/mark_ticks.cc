#include "engrave/galvo/mark_ticks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/try.h"
#include "engrave/galvo/servo_lead.h"
#include "engrave/galvo/stroke_path.h"

namespace intaglio::galvo {
namespace {

constexpr double kMaxTicks = 1e8;
// A quintic from rest to rest is 15/8 as fast in its middle as on average.
constexpr double kQuinticPeak = 15.0 / 8;
// The shortest jump, in lags: the servo follows its changes of speed.
constexpr double kMinJumpLags = 6;
// Spans of one length have as many ticks each, whatever rounding does to their ends.
constexpr double kTieSteps = 1e-6;

Status CheckTickOptions(const MarkTickOptions& o) {
  struct Range {
    const char* name;
    double value, min, max;
  };
  for (const Range& r : {Range{"rate_hz", o.rate_hz, 1e3, 1e6},
                         {"mark_mm_s", o.mark_mm_s, 1e-3, 1e6},
                         {"jump_mm_s", o.jump_mm_s, 1e-3, 1e6},
                         {"run_in_s", o.run_in_s, 0, 0.1},
                         {"lag_s", o.lag_s, 0, 0.01},
                         {"laser_on_delay_s", o.laser_on_delay_s, 0, 0.01},
                         {"laser_off_delay_s", o.laser_off_delay_s, 0, 0.01},
                         {"jump_delay_s", o.jump_delay_s, 0, 0.01},
                         {"mark_delay_s", o.mark_delay_s, 0, 0.01},
                         {"polygon_delay_s", o.polygon_delay_s, 0, 0.01}}) {
    if (r.value >= r.min && r.value <= r.max) continue;
    return Fail(
        ErrorCode::kInvalidValue,
        fmt::format("ticks: {} is {}; give {}..{}", r.name, r.value, r.min, r.max),
        fmt::format("{}", r.value));
  }
  if (o.lead_servo && !(o.lag_s > 0))
    return Fail(ErrorCode::kInvalidValue, "ticks: lead_servo needs lag_s above 0");
  return {};
}

std::size_t TicksOf(double duration_s, const MarkTickOptions& options) {
  return static_cast<std::size_t>(std::lround(duration_s * options.rate_hz));
}
std::size_t TicksFor(double way_mm, double speed_mm_s, const MarkTickOptions& options) {
  return static_cast<std::size_t>(
      std::max(1.0, std::ceil(way_mm / speed_mm_s * options.rate_hz - 1e-9)));
}
/// Of a jump as a quintic, with the tick at its end.
std::size_t SmoothTicks(double way_mm, const MarkTickOptions& options) {
  const double wanted_s =
      std::max(kQuinticPeak * way_mm / options.jump_mm_s, kMinJumpLags * options.lag_s);
  return static_cast<std::size_t>(std::ceil(wanted_s * options.rate_hz));
}

class TickMaker {
 public:
  /// Makes ticks.
  TickMaker(const MarkTickOptions& options, const Vec2& from_mm)
      : options_(options), makes_(true), jumps_(true), at_mm_(from_mm) {}
  /// Counts ticks of strokes, without the jump to the first.
  explicit TickMaker(const MarkTickOptions& options)
      : options_(options), makes_(false), jumps_(false), at_mm_(Vec2::Zero()) {}

  Status Add(const MarkStroke& stroke, std::size_t number) {
    std::vector<StrokePart> parts = PartsOf(stroke);
    if (parts.empty()) {
      return Fail(
          ErrorCode::kInvalidValue,
          fmt::format("stroke {} has fewer than two places; leave it out", number + 1));
    }
    const bool swept = options_.lead_servo || options_.run_in_s > 0;
    if (!stroke.lit.empty() && (parts.size() > 1 || stroke.closed || !swept)) {
      return Fail(
          ErrorCode::kInvalidValue,
          fmt::format("stroke {}: lit spans need an open stroke without a corner, "
                      "and run_in_s above 0 or lead_servo",
                      number + 1));
    }
    double length_mm = 0;
    std::vector<TurningPath> paths;
    paths.reserve(parts.size());
    for (StrokePart& part : parts) {
      const Vec2 first_mm = part.points_mm.front();
      paths.push_back(
          {StrokePath(std::move(part.points_mm), part.closed), first_mm, part.turn_rad});
      length_mm += paths.back().path.length_mm();
    }
    const double ticks = length_mm / options_.mark_mm_s * options_.rate_hz;
    if (!(static_cast<double>(count_) + ticks < kMaxTicks)) {
      return Fail(ErrorCode::kTooLarge,
                  fmt::format("stroke {}: more than {:g} ticks; mark faster or less",
                              number + 1, kMaxTicks));
    }
    if (options_.lead_servo) {
      for (const TurningPath& part : paths) AddWithRunIn(part.path, stroke.lit);
    } else if (options_.run_in_s > 0 && paths.size() == 1) {
      AddWithRunIn(paths.front().path, stroke.lit);
    } else {
      AddWithDelays(paths);
    }
    return {};
  }

  StrokeTicks Count() {
    RestBehind();
    return {first_mm_, count_, at_mm_};
  }

  std::vector<MarkTick> Finish() {
    RestBehind();
    std::vector<MarkTick> ticks = std::move(ticks_);
    for (const auto& [begin, end] : lit_)
      for (std::size_t k = begin; k < std::min(end, ticks.size()); ++k)
        ticks[k].laser = true;
    if (!options_.lead_servo) return ticks;
    std::vector<Vec2> places;
    for (const MarkTick& tick : ticks) places.push_back(tick.place_mm);
    LeadServo(options_.lag_s, 1 / options_.rate_hz, places);
    for (std::size_t k = 0; k < ticks.size(); ++k) ticks[k].place_mm = places[k];
    return ticks;
  }

 private:
  struct TurningPath {
    StrokePath path;
    Vec2 first_mm;
    double turn_rad;  // of the corner behind it
  };

  std::size_t Ticks(double duration_s) const { return TicksOf(duration_s, options_); }
  void RestBehind() { Rest(Ticks(options_.run_in_s) + 1); }
  /// `count` ticks, k of 0 .. count - 1 at place_of(k).
  template <typename PlaceOf>
  void Put(std::size_t count, const PlaceOf& place_of) {
    if (count == 0) return;
    count_ += count;
    if (makes_)
      for (std::size_t k = 0; k + 1 < count; ++k) ticks_.push_back({place_of(k), false});
    at_mm_ = place_of(count - 1);
    if (makes_) ticks_.push_back({at_mm_, false});
  }
  void Rest(std::size_t ticks) {
    const Vec2 at_mm = at_mm_;
    Put(ticks, [&](std::size_t) { return at_mm; });
    if (ticks > 0) speed_mm_s_ = Vec2::Zero();
  }

  /// Ends one tick before the place, at which the mark or its run-in begins.
  void JumpTo(const Vec2& to_mm, const Vec2& speed_mm_s) {
    if (!jumps_) {
      first_mm_ = at_mm_ = to_mm;
      jumps_ = true;
      return;
    }
    const double way_mm = (to_mm - at_mm_).norm();
    if (options_.lead_servo) {
      JumpSmoothly(to_mm, speed_mm_s, way_mm);
      return;
    }
    if (way_mm == 0) return;
    const Vec2 from_mm = at_mm_;
    const std::size_t n = TicksFor(way_mm, options_.jump_mm_s, options_);
    Put(n, [&](std::size_t k) -> Vec2 {
      const double share = static_cast<double>(k + 1) / static_cast<double>(n);
      return from_mm + share * (to_mm - from_mm);
    });
    Rest(Ticks(options_.jump_delay_s));
  }

  /// A quintic from the place and speed that are to those, accelerations 0.
  void JumpSmoothly(const Vec2& to_mm, const Vec2& to_mm_s, double way_mm) {
    const std::size_t n = SmoothTicks(way_mm, options_);
    const double duration_s = static_cast<double>(n) / options_.rate_hz;
    const Vec2 from_mm = at_mm_;
    const Vec2 a = duration_s * speed_mm_s_, b = duration_s * to_mm_s;
    const Vec2 way = to_mm - from_mm;
    const Vec2 c3 = 10 * way - 6 * a - 4 * b, c4 = -15 * way + 8 * a + 7 * b,
               c5 = 6 * way - 3 * a - 3 * b;
    Put(n - 1, [&](std::size_t k) -> Vec2 {
      const double t = static_cast<double>(k + 1) / static_cast<double>(n);
      return from_mm + t * (a + t * t * (c3 + t * (c4 + t * c5)));
    });
  }

  void AddWithRunIn(const StrokePath& path, const std::vector<LitSpan>& lit) {
    // Spans of a regular row fall on ticks when its speed is the nearest that there is,
    // and not the nearest below.
    const std::size_t n =
        lit.empty() ? TicksFor(path.length_mm(), options_.mark_mm_s, options_)
                    : std::max<std::size_t>(
                          1, TicksOf(path.length_mm() / options_.mark_mm_s, options_));
    const double step_mm = path.length_mm() / static_cast<double>(n);
    const std::size_t run = Ticks(options_.run_in_s);
    const double run_mm = static_cast<double>(run) * step_mm;
    const double speed_mm_s = step_mm * options_.rate_hz;
    JumpTo(path.At(-run_mm), speed_mm_s * path.DirectionAt(-run_mm));
    const std::size_t end = Light(count_ + run, n, step_mm, lit);
    Put(n + 2 * run + 1, [&](std::size_t k) {
      return path.At(static_cast<double>(k) * step_mm - run_mm);
    });
    speed_mm_s_ = speed_mm_s * path.DirectionAt(path.length_mm() + run_mm);
    // The laser goes off before the next jump begins.
    if (count_ < end) Rest(end - count_);
  }

  /// Of `n` steps, the first of which is made in the tick `first`. Behind the last tick
  /// with the laser on.
  std::size_t Light(std::size_t first, std::size_t n, double step_mm,
                    const std::vector<LitSpan>& lit) {
    const std::size_t on = Ticks(options_.laser_on_delay_s),
                      off = Ticks(options_.laser_off_delay_s);
    if (lit.empty()) {
      lit_.emplace_back(first + on, first + n + off);
      return first + n + off;
    }
    std::size_t end = 0;
    for (const LitSpan& span : lit) {
      const double length = (span.to_mm - span.from_mm) / step_mm;
      const double count =
          std::clamp(std::round(length - kTieSteps), 1.0, static_cast<double>(n));
      const double from =
          std::round((span.from_mm + span.to_mm) / 2 / step_mm - count / 2 - kTieSteps);
      const auto begin =
          static_cast<std::size_t>(std::clamp(from, 0.0, static_cast<double>(n) - count));
      end = std::max(first + begin + static_cast<std::size_t>(count) + off,
                     first + begin + on + 1);
      if (makes_) lit_.emplace_back(first + begin + on, end);
    }
    return end;
  }

  void AddWithDelays(const std::vector<TurningPath>& parts) {
    JumpTo(parts.front().first_mm, Vec2::Zero());
    const std::size_t begin = count_ + Ticks(options_.laser_on_delay_s);
    Put(1, [&](std::size_t) { return parts.front().first_mm; });
    for (const TurningPath& part : parts) {
      const StrokePath& path = part.path;
      const std::size_t n = TicksFor(path.length_mm(), options_.mark_mm_s, options_);
      const double step_mm = path.length_mm() / static_cast<double>(n);
      Put(n,
          [&](std::size_t k) { return path.At(static_cast<double>(k + 1) * step_mm); });
      Rest(Ticks(options_.polygon_delay_s * (1 - std::cos(part.turn_rad))));
    }
    const std::size_t end = count_ - 1 + Ticks(options_.laser_off_delay_s);
    lit_.emplace_back(begin, end);
    Rest(std::max(Ticks(options_.mark_delay_s), end > count_ ? end - count_ : 0));
  }

  const MarkTickOptions& options_;
  const bool makes_;  // and does not only count
  std::size_t count_ = 0;
  bool jumps_;  // else the next jump is left out
  Vec2 first_mm_ = Vec2::Zero();
  Vec2 at_mm_;
  Vec2 speed_mm_s_ = Vec2::Zero();
  std::vector<MarkTick> ticks_;  // none when only their count is asked for
  std::vector<std::pair<std::size_t, std::size_t>> lit_;  // first, one behind the last
};

}  // namespace

Result<std::vector<MarkTick>> MakeMarkTicks(std::span<const MarkStroke> strokes,
                                            const Vec2& from_mm,
                                            const MarkTickOptions& options) {
  INTAGLIO_TRY(CheckTickOptions(options));
  TickMaker maker(options, from_mm);
  for (std::size_t i = 0; i < strokes.size(); ++i) INTAGLIO_TRY(maker.Add(strokes[i], i));
  return maker.Finish();
}

Result<StrokeTicks> CountStrokeTicks(std::span<const MarkStroke> strokes,
                                     const MarkTickOptions& options) {
  INTAGLIO_TRY(CheckTickOptions(options));
  if (strokes.empty())
    return Fail(ErrorCode::kInvalidValue, "ticks: there is no stroke; give one or more");
  TickMaker maker(options);
  for (std::size_t i = 0; i < strokes.size(); ++i) INTAGLIO_TRY(maker.Add(strokes[i], i));
  return maker.Count();
}

std::size_t CountJumpTicks(double way_mm, const MarkTickOptions& options) {
  if (options.lead_servo) return SmoothTicks(way_mm, options) - 1;
  if (way_mm == 0) return 0;
  return TicksFor(way_mm, options.jump_mm_s, options) +
         TicksOf(options.jump_delay_s, options);
}

}  // namespace intaglio::galvo
