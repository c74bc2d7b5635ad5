#include "services/synchronizer/motion_feed.h"

#include <array>

#include "services/bus/samples.h"

namespace intaglio::synchronizer {
namespace {
constexpr std::size_t kBatchSegments = 128;
}  // namespace

MotionFeed::MotionFeed(BatchWriter write, GrantLookup grant_of)
    : write_(std::move(write)), grant_of_(std::move(grant_of)) {}

void MotionFeed::Begin(const std::string& job_uid, std::uint32_t run,
                       std::uint64_t start_tick, const Vec3& start_mm,
                       const motion::PlanOptions& plan) {
  job_uid_ = job_uid;
  run_ = run;
  stream_ = bus::StreamName(job_uid, run, bus::kMotionSegmentBatch.name);
  start_tick_ = start_tick;
  next_batch_ = 0;
  planned_all_ = sent_all_ = false;
  pending_.clear();
  scheduled_ = 0;
  scheduled_subticks_ = 0;
  planner_ = motion::MakePlanner(plan, start_mm);
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
  while (!planned_all_ && start_tick_ + planner_->ticks() < horizon_tick) {
    if (pending_.size() >= kBatchSegments && !Send(false)) return;
    const auto target = next();
    if (target) {
      planner_->Append(target->position_mm, static_cast<std::int32_t>(target->point),
                       true, pending_);
    } else {
      planner_->Finish(pending_);
      planned_all_ = true;
    }
    Schedule(schedule);
  }
  if (!pending_.empty()) sent_all_ = Send(planned_all_) && planned_all_;
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
  if (!write_(batch)) return false;
  ++next_batch_;
  pending_.clear();
  scheduled_ = 0;
  return true;
}

Status MotionFeed::Abort() {
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
