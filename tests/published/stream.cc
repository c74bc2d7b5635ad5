#include "tests/published/stream.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engrave/core/try.h"

// The window is final segments of twice the memory, so that the begin of the window has
// died out where errors are first counted, then all that is not final. Its last node is
// at rest. Nodes that are final keep their speed and the segments their acceleration;
// when one of them gets worse by what follows, the first free node is made slower.

namespace intaglio::course {

namespace {

/// When the law is at a node.
double TimeAt(const SpeedLaw& law, double node_s_mm) {
  for (const Phase& phase : law.phases)
    if (phase.s_mm >= node_s_mm) return phase.begin_s;
  return law.duration_s;
}

}  // namespace

Result<CourseStream> CourseStream::Make(const Vec2& begin_mm, const AxisPair& axes,
                                        const PlanOptions& options,
                                        double max_feed_mm_s) {
  INTAGLIO_TRY(CheckOptions(options));
  if (!(max_feed_mm_s >= kMinFeedMmS && max_feed_mm_s <= kMaxFeedMmS)) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("max_feed_mm_s {} is outside {}..{}", max_feed_mm_s,
                            kMinFeedMmS, kMaxFeedMmS));
  }
  TrackingOptions tracking;
  tracking.period_s = options.period_s;
  if (options.compensate) {
    if (!options.kernel_s) {
      return Fail(ErrorCode::kMissing,
                  "kernel_s is missing: a compensated course that is planned while it is "
                  "read needs the length of the kernel");
    }
    tracking.kernel_s = options.kernel_s;
  } else if (options.jerk_mm_s3) {
    tracking.smooth_s = 2 * options.acceleration_mm_s2 / *options.jerk_mm_s3;
  }
  return CourseStream(begin_mm, axes, options, tracking, max_feed_mm_s);
}

CourseStream::CourseStream(const Vec2& begin_mm, const AxisPair& axes,
                           const PlanOptions& options, const TrackingOptions& tracking,
                           double max_feed_mm_s)
    : tracking_(axes, tracking),
      allowed_(AllowedBy(options)),
      acceleration_mm_s2_(options.acceleration_mm_s2),
      max_feed_mm_s_(max_feed_mm_s),
      rounds_(options.rounds),
      memory_mm_(tracking_.memory_s() * max_feed_mm_s),
      end_mm_(begin_mm) {
  // So that nodes keep the limits when they are final.
  allowed_.error_mm /= kFinalSlack;
  allowed_.motor_mm_s2 /= kFinalSlack;
  allowed_.jerk_mm_s3 /= kFinalSlack;
  // A correction reaches half of the lowest acceleration in a few rounds.
  const double braking_mm = max_feed_mm_s * max_feed_mm_s / (2 * acceleration_mm_s2_);
  look_ahead_mm_ = 2 * braking_mm + 2 * memory_mm_ + 20 * allowed_.error_mm;
  // A window is planned once for several segments: half of its work is for the
  // look-ahead.
  block_mm_ = 2 * look_ahead_mm_;
  speeds_.node_mm_s = {0};
}

double CourseStream::pending_mm() const {
  double pending_mm = 0;
  for (std::size_t i = final_count_; i < segments_.size(); ++i)
    pending_mm += segments_[i].length_mm;
  return pending_mm;
}

Status CourseStream::Append(const Piece& piece, std::vector<Phase>& out) {
  const Path path = INTAGLIO_TRY(Path::Make(end_mm_, std::span(&piece, 1)));
  if (piece.feed_mm_s > max_feed_mm_s_) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("feed_mm_s {} is above {}, the greatest of this stream",
                            piece.feed_mm_s, max_feed_mm_s_),
                fmt::format("{}", piece.feed_mm_s));
  }
  segments_.insert(segments_.end(), path.segments().begin(), path.segments().end());
  end_mm_ = piece.end_mm;
  if (pending_mm() > max_pending_mm()) Plan(look_ahead_mm_, out);
  return {};
}

void CourseStream::Finish(std::vector<Phase>& out) {
  if (final_count_ < segments_.size()) Plan(0, out);
}

Corrected CourseStream::Correct(const Path& path) const {
  // First guesses of all; what is known of nodes and segments before replaces them.
  Speeds speeds = FirstSpeeds(path, tracking_, allowed_, acceleration_mm_s2_);
  std::ranges::copy(speeds_.node_mm_s, speeds.node_mm_s.begin());
  std::ranges::copy(speeds_.segment_mm_s, speeds.segment_mm_s.begin());
  std::ranges::copy(speeds_.acceleration_mm_s2, speeds.acceleration_mm_s2.begin());
  std::size_t counted = 0;
  while (begun_ && counted < final_count_ && path.node_s_mm()[counted] < memory_mm_)
    ++counted;
  return CorrectSpeeds(path, tracking_, allowed_, std::move(speeds), rounds_,
                       {final_count_ + 1, counted, window_begin_s_});
}

void CourseStream::Emit(const Path& path, const SpeedLaw& law, std::size_t last,
                        std::vector<Phase>& out) {
  const double from_mm = path.node_s_mm()[final_count_], to_mm = path.node_s_mm()[last];
  const double begin_s = TimeAt(law, from_mm), end_s = TimeAt(law, to_mm);
  for (const Phase& phase : law.phases) {
    if (phase.begin_s < begin_s || phase.begin_s >= end_s) continue;
    out.push_back({duration_s_ + phase.begin_s - begin_s,
                   final_mm_ + phase.s_mm - from_mm, phase.v_mm_s, phase.a_mm_s2});
  }
  duration_s_ += end_s - begin_s;
  final_mm_ += to_mm - from_mm;
  if (node_speed_mm_s_.empty()) node_speed_mm_s_.push_back(0);
  for (std::size_t k = final_count_ + 1; k <= last; ++k)
    node_speed_mm_s_.push_back(law.node_speed_mm_s[k]);
}

void CourseStream::Plan(double keep_mm, std::vector<Phase>& out) {
  const Path path = Path::Of(segments_);
  const Corrected corrected = Correct(path);
  // What is final was commanded already: the way behind it has to begin at its speed.
  const double final_mm_s = speeds_.node_mm_s[final_count_];
  holds_ = holds_ && corrected.holds &&
           corrected.law.node_speed_mm_s[final_count_] >= final_mm_s * (1 - 1e-9);
  std::size_t last = segments_.size();
  while (keep_mm > 0 && last > final_count_ &&
         path.node_s_mm()[last] > path.length_mm() - keep_mm)
    --last;
  Emit(path, corrected.law, last, out);
  speeds_ = corrected.speeds;
  std::copy_n(corrected.law.node_speed_mm_s.begin(), last + 1, speeds_.node_mm_s.begin());
  final_count_ = last;
  std::size_t forgotten = 0;
  while (forgotten < final_count_ &&
         path.node_s_mm()[forgotten + 1] < path.node_s_mm()[last] - 2 * memory_mm_)
    ++forgotten;
  window_begin_s_ += TimeAt(corrected.law, path.node_s_mm()[forgotten]);
  Forget(forgotten);
}

void CourseStream::Forget(std::size_t segments) {
  const auto erase = [segments](auto& values) {
    values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(segments));
  };
  begun_ = begun_ || segments > 0;
  erase(segments_);
  erase(speeds_.node_mm_s);
  erase(speeds_.segment_mm_s);
  erase(speeds_.acceleration_mm_s2);
  final_count_ -= segments;
  // The last node was a stop only as nothing was known behind it; it is guessed anew.
  speeds_.node_mm_s.pop_back();
}

}  // namespace intaglio::course
