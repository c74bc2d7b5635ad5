#include "services/synchronizer/engraving/motion_feed.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "services/platform/bus/samples.h"

namespace intaglio::synchronizer {
namespace {
constexpr std::size_t kBatchSegments = 128;
// Points of one turn of the loop: a window of a planner without stops has more, so no
// turn plans two of them, which take up to 10 ms each at 200 Hz.
constexpr std::size_t kTurnSegments = 256;
// What a better knowledge of the controller's clock may change in a segment's duration at
// once: 10 us in a tick of 5 ms, 0.12 mm/s of 60.
constexpr double kMaxCorrectionRatio = 0.002;
}  // namespace

MotionFeed::MotionFeed(BatchWriter write, GrantLookup grant_of)
    : write_(std::move(write)), grant_of_(std::move(grant_of)) {}

void MotionFeed::Begin(const std::string& job_uid, std::uint32_t run,
                       std::uint64_t start_tick, const Vec3& start_mm,
                       const motion::PlanOptions& plan, const motion::Limits& machine,
                       const MotionClock* clock) {
  job_uid_ = job_uid;
  run_ = run;
  stream_ = bus::StreamName(job_uid, run, bus::kMotionSegmentBatch.name);
  start_tick_ = start_tick;
  next_batch_ = 0;
  planned_all_ = sent_all_ = false;
  pending_.clear();
  scheduled_ = 0;
  scheduled_subticks_ = 0;
  plan_ = plan;
  machine_ = machine;
  ticks_before_planner_ = 0;
  planner_ = PlannerFrom(start_mm);
  clock_ = clock;
  timed_subticks_ = start_controller_ns_ = 0;
  if (clock_ == nullptr) return;
  sent_controller_ns_ =
      std::round(clock_->ControllerNsAt(static_cast<double>(start_tick)));
  start_controller_ns_ = static_cast<std::uint64_t>(sent_controller_ns_);
}

// Each knot at the controller's time of its tick, as it is known now. What was known
// before was a little off: the difference is made up for bit by bit, without a jerk.
std::vector<std::uint64_t> MotionFeed::ControllerTimes() {
  std::vector<std::uint64_t> times;
  if (clock_ == nullptr) return times;
  const auto ns_after = [this](std::uint64_t subticks) {
    return clock_->ControllerNsAt(static_cast<double>(start_tick_) +
                                  static_cast<double>(subticks) /
                                      motion::kSubticksPerTick);
  };
  double before_ns = ns_after(timed_subticks_);
  for (const motion::Segment& segment : pending_) {
    timed_subticks_ += segment.duration_subticks;
    const double due_ns = ns_after(timed_subticks_);
    const double max_ns = kMaxCorrectionRatio * (due_ns - before_ns);
    const double correction_ns =
        std::clamp(before_ns - sent_controller_ns_, -max_ns, max_ns);
    sent_controller_ns_ += due_ns - before_ns + correction_ns;
    before_ns = due_ns;
    times.push_back(static_cast<std::uint64_t>(std::llround(sent_controller_ns_)));
  }
  return times;
}

bool MotionFeed::MaySend() const {
  // The bridge opens the run's credit when it sees batch 0.
  if (next_batch_ == 0) return true;
  const auto grant = grant_of_(stream_);
  return grant.open && !grant.cancelled && next_batch_ < grant.limit;
}

bool MotionFeed::dropped() const {
  return !sent_all_ && next_batch_ > 0 && grant_of_(stream_).cancelled;
}

void MotionFeed::Advance(std::uint64_t horizon_tick, const NextTarget& next,
                         PulseSchedule& schedule) {
  if (sent_all_ || !planner_) return;
  std::size_t planned = 0;
  while (!planned_all_ && planned < kTurnSegments &&
         start_tick_ + ticks_before_planner_ + planner_->ticks() < horizon_tick) {
    if (pending_.size() >= kBatchSegments && !Send(false)) return;
    const auto target = next();
    const std::size_t before = pending_.size();
    if (target) {
      planner_->Append(target->position_mm, static_cast<std::int32_t>(target->point),
                       true, pending_);
    } else {
      planner_->Finish(pending_);
      planned_all_ = true;
    }
    planned += pending_.size() - before;
    Schedule(schedule);
  }
  if (!pending_.empty()) sent_all_ = Send(planned_all_) && planned_all_;
}

std::unique_ptr<motion::Planner> MotionFeed::PlannerFrom(const Vec3& start_mm) const {
  motion::PlanOptions plan = plan_;
  plan.limits = motion::LimitsAtSpeed(plan_.limits, machine_, speed_ratio_);
  return motion::MakePlanner(plan, start_mm);
}

void MotionFeed::SetSpeed(double ratio, PulseSchedule& schedule) {
  if (ratio == speed_ratio_) return;
  speed_ratio_ = ratio;
  if (!planner_ || planned_all_) return;
  planner_->Finish(pending_);
  Schedule(schedule);
  ticks_before_planner_ = scheduled_subticks_ / motion::kSubticksPerTick;
  planner_ = PlannerFrom(pending_.back().end_position_mm);
}

void MotionFeed::Schedule(PulseSchedule& schedule) {
  for (; scheduled_ < pending_.size(); ++scheduled_) {
    const motion::Segment& segment = pending_[scheduled_];
    scheduled_subticks_ += segment.duration_subticks;
    if (segment.point < 0) continue;
    schedule.Add(start_tick_ + scheduled_subticks_ / motion::kSubticksPerTick,
                 static_cast<std::uint32_t>(segment.point));
  }
}

bool MotionFeed::Send(bool last) {
  if (!MaySend()) return false;
  std::array<std::vector<double>, 6> columns;
  std::vector<std::uint32_t> duration;
  std::vector<std::uint8_t> pulse;
  for (const motion::Segment& segment : pending_) {
    for (int axis = 0; axis < 3; ++axis) {
      columns[axis].push_back(segment.end_position_mm[axis]);
      columns[axis + 3].push_back(segment.end_velocity_mm_s[axis]);
    }
    duration.push_back(segment.duration_subticks);
    pulse.push_back(segment.pulse ? 1 : 0);
  }
  // What the bridge does not take is timed again, by what is known then.
  const auto timed_before = std::pair{timed_subticks_, sent_controller_ns_};
  const std::vector<std::uint64_t> controller_ns = ControllerTimes();
  intaglio_MotionSegmentBatch batch{};
  batch.job_uid = bus::Borrow(job_uid_);
  batch.run = run_;
  batch.sequence_number = next_batch_;
  batch.start_tick = start_tick_;
  batch.last = last;
  bus::Borrow(batch.x_mm, columns[0]);
  bus::Borrow(batch.y_mm, columns[1]);
  bus::Borrow(batch.z_mm, columns[2]);
  bus::Borrow(batch.vx_mm_s, columns[3]);
  bus::Borrow(batch.vy_mm_s, columns[4]);
  bus::Borrow(batch.vz_mm_s, columns[5]);
  bus::Borrow(batch.duration_subticks, duration);
  bus::Borrow(batch.pulse, pulse);
  bus::Borrow(batch.controller_ns, controller_ns);
  batch.start_controller_ns = start_controller_ns_;
  batch.block_x_mm = block_mm_.x();
  batch.block_y_mm = block_mm_.y();
  if (!write_(batch)) {
    std::tie(timed_subticks_, sent_controller_ns_) = timed_before;
    return false;
  }
  ++next_batch_;
  pending_.clear();
  scheduled_ = 0;
  return true;
}

Status MotionFeed::Abort(std::uint32_t run) {
  run_ = std::max(run_, run);
  sent_all_ = planned_all_ = true;
  pending_.clear();
  scheduled_ = 0;
  intaglio_MotionSegmentBatch batch{};
  batch.job_uid = bus::Borrow(job_uid_);
  batch.run = run_;
  batch.sequence_number = next_batch_++;
  batch.abort = true;
  return write_(batch);
}

}  // namespace intaglio::synchronizer
