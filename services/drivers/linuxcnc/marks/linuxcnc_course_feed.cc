// What HAL reports of the rows of marks, and which rows it gets next
// (linuxcnc_course_driver.h).

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "services/drivers/interface/power_up.h"
#include "services/drivers/linuxcnc/marks/linuxcnc_course_driver.h"

namespace intaglio::drivers {
namespace {

// Rest: the axes do not move for so many reports.
constexpr int kStillReports = 12;
constexpr double kStillReport_mm = 0.0005;
// The number of the first row of a session is far above any that may still be on its way.
constexpr std::uint64_t kCourseRowGap = 1'000'000;
constexpr char kCourseNotHomed[] =
    "LinuxCNC does not know where the axes are: home them, until the axes' file sets "
    "axes-homed, then resume";

std::string WhyLatchesOpened(const HalSample& sample) {
  if (!sample.Has(kHalDoor))
    return "the safety door opened: close it, check the work, then resume";
  if (!sample.Has(kHalStopFree))
    return "the stop button is pressed: release it, check the work, then resume";
  if (!sample.Has(kHalKey)) return "the key is off: turn it on, then resume";
  if (!sample.Has(kHalHostAlive)) {
    return "no heartbeat reached LinuxCNC for 200 ms, and it ended the beam: the "
           "computer is too busy; reduce the load, check the work, then resume";
  }
  if (sample.Has(kHalLaserOk)) {
    return "the drives are not ready: check their faults and the limit switches, then "
           "resume";
  }
  return "an interlock opened for a moment: check key, door and stop button and the "
         "work, then resume";
}

std::string WhyBeamIsOff(const HalSample& sample) {
  if (!sample.Has(kHalInPlace)) {
    return "the axes were farther from their row than x-, y- or z-near.difference of the "
           "axes' file, and LinuxCNC ended the beam: check the drive in the profile, or "
           "raise the pins; check the work, then resume";
  }
  if (!sample.Has(kHalWarm) || !sample.Has(kHalShutter)) {
    return "the beam was switched off, because this computer was too busy to permit it "
           "in time: reduce the load, check the work, then resume";
  }
  return "LinuxCNC did not switch the beam on where a row asks for it: check the axes' "
         "file and the work, then resume";
}

}  // namespace

void LinuxcncCourseDriver::BeginSession() {
  const bool first = begun_sessions_ == 0;
  begun_sessions_ = session_.sessions();
  const HalSample& now = session_.newest();
  state_.power_up = std::to_string(DrawPowerUp());
  state_.newest_run = 0;
  sent_.clear();
  rows_.End();
  next_row_ = now.row + kCourseRowGap;
  ready_ = playing_ = rests_ = shutter_ = recovers_ = false;
  still_samples_ = 0;
  openings_at_ok_ = now.openings;
  was_homed_ = now.Has(kHalHomed);
  // What has been idle may be used at once; after power-up every latch is open.
  if (first) {
    recovers_ = true;
    (void)session_.ResetBoth();
    reset_number_ = session_.number();
    return;
  }
  if (state_.fault.empty()) {
    state_.fault =
        "the line to LinuxCNC's HAL was lost, and nobody has watched the machine: check "
        "it, then resume";
  }
  state_.safe_state = true;
}

void LinuxcncCourseDriver::SetDown() {
  ready_ = recovers_ = playing_ = shutter_ = rests_ = false;
  rows_.End();
  sent_.clear();
  if (!run_) return;
  DropQueue();
  if (hand_ && stage_ == Hand::kAnnounced) {
    AddEvent(hand_->number, MarkFate::kNotBegun);
  } else if (hand_) {
    seen_.Receive({*run_, hand_->number, MarkFate::kUncertain});
    state_.fault = fmt::format(
        "the line to LinuxCNC's HAL was lost in mark {}: check the work, then resume",
        hand_->number);
    state_.safe_state = true;
  }
  stopping_ = false;
  EndRun();
}

void LinuxcncCourseDriver::Receive(const HalSample& sample) {
  was_lit_ = was_lit_ || (hand_ && sample.Has(kHalLaser));
  if (sample.Has(kHalFresh)) {
    TakeRow(sample);
  } else if (playing_ && !stopping_) {
    StopItself(
        "the rows of a contour did not reach LinuxCNC in time: the computer is too busy, "
        "or its services do not run in real time; check the work, then resume");
  }
  if (!session_.up()) return;
  TakeLatches(sample);
  TakeHomed(sample);
  TakeRest(sample);
}

void LinuxcncCourseDriver::TakeRow(const HalSample& sample) {
  if (sent_.empty() || sample.row < sent_.front().number) return;
  if (sample.row > sent_.front().number)
    return session_.Lose("reports of rows are missing");
  const SentRow row = sent_.front();
  sent_.pop_front();
  if (row.motion != sample.motion || !sample.Has(kHalMotionOk)) return;
  if (row.lit && !sample.Has(kHalLaser) && !stopping_ && sample.Has(kHalLaserOk))
    return StopItself(WhyBeamIsOff(sample));
  playing_ = !row.last && !stopping_;
  if (row.last && hand_ && sample.Has(kHalLaserOk)) EndMark(MarkFate::kDone);
}

// Rest, after the axes have braked: the place that HAL holds is where rows go on.
void LinuxcncCourseDriver::TakeRest(const HalSample& sample) {
  const bool still =
      (sample.actual_mm - last_actual_mm_).cwiseAbs().maxCoeff() < kStillReport_mm;
  last_actual_mm_ = sample.actual_mm;
  if (rests_ || sample.motion != session_.motion()) return;
  still_samples_ = still ? still_samples_ + 1 : 0;
  if (still_samples_ < kStillReports) return;
  place_mm_ = sample.target_mm;
  rests_ = true;
  sent_.clear();
  ready_ = ready_ || !recovers_;
  if (stopping_) EndStop();
}

void LinuxcncCourseDriver::TakeHomed(const HalSample& sample) {
  const bool homed = sample.Has(kHalHomed);
  state_.place_lost = homed ? "" : kCourseNotHomed;
  if (was_homed_ && !homed) StopItself(kCourseNotHomed);
  was_homed_ = homed;
}

void LinuxcncCourseDriver::TakeLatches(const HalSample& sample) {
  const bool ok = sample.Has(kHalLaserOk) && sample.Has(kHalMotionOk);
  if (recovers_) {
    if (sample.command < reset_number_) return;
    recovers_ = false;
    ready_ = ready_ || rests_;
    if (ok) {
      openings_at_ok_ = sample.openings;
      return EndFault();
    }
    return Fault(WhyLatchesOpened(sample));
  }
  if (ok) {
    openings_at_ok_ = sample.openings;
  } else if (!state_.safe_state) {
    if (sample.openings != openings_at_ok_) return Fault(WhyLatchesOpened(sample));
    StopItself(WhyLatchesOpened(sample));
  }
}

void LinuxcncCourseDriver::CheckPermission() {
  if (is_permitted()) return;
  if (shutter_) {
    shutter_ = false;
    (void)session_.SetShutter(false);
  }
  if (run_ && !stopping_) BeginStop();
}

void LinuxcncCourseDriver::Feed() {
  if (!run_ || stopping_) return;
  StartPlans();
  if (hand_) return;
  if (!queue_.empty()) return TakeFirst();
  if (finishes_) EndRun();
}

void LinuxcncCourseDriver::StartPlans() {
  const std::size_t count = std::min(queue_.size(), kPlannedMarks);
  for (std::size_t i = 0; i < count; ++i) {
    Queued& one = queue_[i];
    if (one.plan) continue;
    one.plan = std::make_unique<Plan>(
        [mark = one.mark.mark, pen = pens_[one.mark.mark.pen], machine = machine_,
         period_s = period_s()](const ProgressSink& progress) {
          return PlanContour(mark, pen, machine, period_s, progress);
        },
        [] {});
  }
}

void LinuxcncCourseDriver::TakeFirst() {
  Queued& first = queue_.front();
  if (!first.plan->ready()) return;
  auto planned = first.plan->Take();
  if (!planned) {
    first.plan.reset();  // its thread has ended
    return Fault(fmt::format("mark {}: {}", first.mark.number, planned.error().message));
  }
  plan_ = std::make_shared<ContourPlan>(std::move(*planned));
  hand_ = std::move(first.mark);
  queue_.pop_front();
  stage_ = Hand::kAnnounced;
  was_lit_ = false;
  AddEvent(hand_->number, MarkFate::kBegun);
}

void LinuxcncCourseDriver::SendRows() {
  const auto lead = static_cast<std::size_t>(kLead_s / period_s());
  std::string text;
  while (rows_.active() && sent_.size() < lead) {
    const MarkRows::Row row = rows_.Next(period_s());
    place_mm_ = row.place_mm;
    const SentRow sent{next_row_++, session_.motion(), row.lit, row.last};
    AppendText(HalRow{hand_->number + 1, sent.number, session_.arm(), sent.motion,
                      row.lit, row.lit, row.place_mm},
               text);
    sent_.push_back(sent);
  }
  if (!text.empty()) (void)session_.WriteRows(text);
}

void LinuxcncCourseDriver::EndMark(MarkFate fate) {
  AddEvent(hand_->number, fate);
  hand_.reset();
  plan_.reset();
  stage_ = Hand::kNone;
}

void LinuxcncCourseDriver::EndRun() {
  hand_.reset();
  plan_.reset();
  stage_ = Hand::kNone;
  rows_.End();
  run_.reset();
  finishes_ = stopping_ = playing_ = false;
}

void LinuxcncCourseDriver::DropQueue() {
  for (Queued& one : queue_) {
    AddEvent(one.mark.number, MarkFate::kNotBegun);
    if (!one.plan) continue;
    one.plan->Cancel();
    abandoned_.push_back(std::move(one.plan));
  }
  queue_.clear();
}

void LinuxcncCourseDriver::StopItself(std::string why) {
  if (!state_.safe_state) ++own_stops_;
  Fault(std::move(why));
}

void LinuxcncCourseDriver::Fault(std::string why) {
  if (state_.fault.empty()) state_.fault = std::move(why);
  state_.safe_state = true;
  if (run_ && !stopping_) BeginStop();
}

void LinuxcncCourseDriver::EndFault() {
  state_.safe_state = false;
  state_.fault.clear();
}

// HAL brakes, from where the axes are; rows that wait there are not followed, and switch
// no beam.
void LinuxcncCourseDriver::BeginStop() {
  DropQueue();
  stopping_ = true;
  rows_.End();
  playing_ = rests_ = false;
  still_samples_ = 0;
  (void)session_.NextArm();
  (void)session_.NextMotion();
}

void LinuxcncCourseDriver::EndStop() {
  if (hand_) AddEvent(hand_->number, was_lit_ ? MarkFate::kBroken : MarkFate::kNotBegun);
  EndRun();
}

}  // namespace intaglio::drivers
