#include "tests/services/synchronizer/fake_stage.h"

#include <algorithm>
#include <utility>

#include "services/platform/bus/samples.h"

namespace intaglio::synchronizer {

using bus::View;
using namespace std::chrono_literals;

Status FakeStage::Receive(const intaglio_MotionSegmentBatch& batch,
                          std::chrono::nanoseconds now) {
  Batch taken{
      now + latency,
      bus::StreamName(std::string(View(batch.job_uid)), batch.run, "MotionSegmentBatch"),
      batch.run,
      batch.sequence_number,
      batch.start_tick,
      batch.abort,
      {}};
  const auto x = View(batch.x_mm), y = View(batch.y_mm), z = View(batch.z_mm);
  const auto duration = View(batch.duration_subticks);
  const auto pulse = View(batch.pulse);
  for (std::size_t i = 0; i < duration.size(); ++i) {
    taken.segments.push_back({Vec3(x[i], y[i], z[i]), duration[i], pulse[i] != 0, false});
  }
  if (batch.last) taken.segments.back().program_end = true;
  arriving_.push_back(std::move(taken));
  return {};
}

bus::CreditBook::Grant FakeStage::GrantOf(const std::string& stream) const {
  return stream == stream_ ? grant_ : bus::CreditBook::Grant{};
}

void FakeStage::Accept(Batch batch, std::uint64_t tick) {
  if (batch.abort) {
    if (batch.run < run_) return;
    run_ = highest_run_ = batch.run;
    taken_.clear();
    grant_.cancelled = true;
    BreakOff();
    return;
  }
  if (batch.run > run_) {
    run_ = highest_run_ = batch.run;
    stream_ = batch.stream;
    grant_ = {true, false, {}, 0, kWindowBatches};
    expected_ = 0;
    taken_.clear();
    if (fault_ == intaglio_MOTION_PLACE_LOST) {
      begun_run_ = run_;  // refused, with its number
      return;
    }
    fault_ = intaglio_MOTION_OK;
    if (batch.start_tick <= tick) {
      fault_ = intaglio_MOTION_LATE;
      message_ = "the run came too late";
    } else {
      begun_run_ = run_;
      start_tick_ = batch.start_tick;
      queue_.clear();
      queued_subticks_ = passed_subticks_ = 0;
      ending_ = false;
      running_ = true;
    }
  }
  if (batch.run != run_ || begun_run_ != run_ || batch.number != expected_) return;
  ++expected_;
  taken_.push_back(std::move(batch));
}

void FakeStage::BreakOff() {
  if (running_) ticks_to_rest_ = braking_ticks;
  EndRun();
}

void FakeStage::EndRun() {
  if (running_) rest_at_ = now_ + 30ms;
  running_ = in_position_ = false;
  queue_.clear();
}

void FakeStage::Poll(std::chrono::nanoseconds now, std::uint64_t tick) {
  now_ = now;
  while (!deaf && !arriving_.empty() && arriving_.front().due <= now) {
    Batch batch = std::move(arriving_.front());
    arriving_.pop_front();
    Accept(std::move(batch), tick);
  }
  while (running_ && !taken_.empty() && queue_.size() < kQueueSegments) {
    for (const Segment& segment : taken_.front().segments) {
      queue_.push_back(segment);
      queued_subticks_ += segment.duration_subticks;
      ending_ = ending_ || segment.program_end;
    }
    grant_.consumed = taken_.front().number + 1;
    grant_.limit = grant_.consumed + kWindowBatches;
    taken_.pop_front();
  }
  if (silent || now < next_view_) return;
  next_view_ = now + 10ms;
  view_ = {true,
           tick,
           at_mm_,
           begun_run_,
           highest_run_,
           queued_through_tick(),
           !running_ && ticks_to_rest_ == 0 && now >= rest_at_,
           fault_,
           message_};
}

std::uint64_t FakeStage::queued_through_tick() const {
  return start_tick_ + queued_subticks_ / kSubticks;
}

bool FakeStage::MayPassTick(std::uint64_t next_tick) const {
  return !running_ || ending_ || next_tick <= queued_through_tick();
}

void FakeStage::AdvanceTick(std::uint64_t tick) {
  in_position_ = false;
  if (!running_ && ticks_to_rest_ > 0) --ticks_to_rest_;
  if (!running_ || tick <= start_tick_) return;
  const std::uint64_t passed = (tick - start_tick_) * kSubticks;
  while (!queue_.empty() &&
         passed_subticks_ + queue_.front().duration_subticks <= passed) {
    const Segment segment = queue_.front();
    queue_.pop_front();
    passed_subticks_ += segment.duration_subticks;
    at_mm_ = segment.end_mm;
    in_position_ = segment.pulse && passed_subticks_ == passed;
    if (segment.program_end) {
      const bool keep = in_position_;
      EndRun();
      in_position_ = keep;
      return;
    }
  }
  if (queue_.empty() && passed_subticks_ < passed) {
    Fail(intaglio_MOTION_STARVED, "the queue of segments ran empty");
  }
}

void FakeStage::Fail(intaglio_MotionFault fault, const std::string& message) {
  fault_ = fault;
  message_ = message;
  BreakOff();
}

}  // namespace intaglio::synchronizer
