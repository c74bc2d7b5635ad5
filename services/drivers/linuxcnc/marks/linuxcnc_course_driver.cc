#include "services/drivers/linuxcnc/marks/linuxcnc_course_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "services/drivers/interface/mark_edges.h"
#include "services/drivers/interface/power_up.h"
#include "services/drivers/linuxcnc/marks/course_profile.h"

namespace intaglio::drivers {
namespace {

Status RefuseMarks(std::string why) { return Fail(ErrorCode::kRefused, std::move(why)); }

Vec3 LimitOfAxes(const MachineSpec& machine, double (AxisLimits::*limit)() const) {
  return {(machine.x().*limit)(), (machine.y().*limit)(), (machine.z().*limit)()};
}

}  // namespace

LinuxcncCourseDriver::LinuxcncCourseDriver(const MachineSpec& machine, HalOpener open,
                                           link::SteadyClock clock)
    : machine_(machine),
      clock_(clock),
      session_(
          std::move(open), machine.mark_line().device(),
          link::ExpectedDevice{machine.mark_line().serial_number(), "LinuxCNC machine",
                               machine.name(), machine.mark_line().device(), "mark_line"},
          std::move(clock), HalLaser::kBeam),
      origin_mm_(machine.block_origin_mm().x(), machine.block_origin_mm().y()),
      rows_(LimitOfAxes(machine, &AxisLimits::max_speed_mm_s),
            LimitOfAxes(machine, &AxisLimits::max_acceleration_mm_s2)) {
  Report();
}

void LinuxcncCourseDriver::Poll() {
  std::erase_if(abandoned_, [](const auto& plan) { return plan->ready(); });
  const std::vector<HalSample>& samples = session_.Poll();
  if (session_.up() && session_.sessions() != begun_sessions_) BeginSession();
  for (const HalSample& sample : samples) {
    if (!session_.up()) break;
    Receive(sample);
  }
  if (session_.up() && !samples.empty()) ++state_.number;
  if (session_.up()) {
    CheckPermission();
    Feed();
    SendRows();
  }
  if (!session_.up()) SetDown();
  Report();
}

std::vector<MarkEvent> LinuxcncCourseDriver::TakeEvents() {
  if (stage_ == Hand::kAnnounced) {
    stage_ = Hand::kSending;
    rows_.Begin(plan_, pens_[hand_->mark.pen].pass_count, place_mm_, origin_mm_);
  }
  return std::exchange(events_, {});
}

Status LinuxcncCourseDriver::Permit(bool permitted) {
  if (!permitted) {
    permit_at_.reset();
    shutter_ = false;
    const Status closed = session_.SetShutter(false);
    return run_ ? Stop() : closed;
  }
  permit_at_ = clock_();
  if (recovers_) return {};
  if (!shutter_) INTAGLIO_TRY(session_.SetShutter(true));
  shutter_ = true;
  return session_.MakePermission();
}

Status LinuxcncCourseDriver::Begin(std::uint32_t run, std::span<const mark::Pen> pens) {
  if (!state_.link_up) return RefuseMarks("the line to LinuxCNC's HAL is down");
  if (!state_.settled || run_) return RefuseMarks("a run is not at its end");
  if (!state_.fault.empty()) return RefuseMarks(state_.fault);
  if (!state_.place_lost.empty()) return RefuseMarks(state_.place_lost);
  if (!state_.key_on || !state_.door_closed || !state_.stop_released || recovers_)
    return RefuseMarks("the machine is not ready: check key, door and stop button");
  if (run <= state_.newest_run)
    return RefuseMarks(fmt::format("run {} is not above {}", run, state_.newest_run));
  for (const mark::Pen& pen : pens) INTAGLIO_TRY(CheckBeamPen(pen, machine_));
  state_.newest_run = run;
  run_ = run;
  pens_.assign(pens.begin(), pens.end());
  finishes_ = false;
  Report();
  return {};
}

std::size_t LinuxcncCourseDriver::Room() const {
  if (!run_ || finishes_ || stopping_) return 0;
  return kQueuedMarks - queue_.size();
}

Status LinuxcncCourseDriver::Append(const NumberedMark& mark) {
  if (Room() == 0) return RefuseMarks("there is no room for a mark");
  INTAGLIO_TRY(mark::CheckMarks({pens_, {mark.mark}}));
  INTAGLIO_TRY(CheckBeamMark(mark, pens_[mark.mark.pen], machine_));
  queue_.push_back({mark, nullptr});
  return {};
}

Status LinuxcncCourseDriver::Finish() {
  if (!run_) return RefuseMarks("there is no run");
  finishes_ = true;
  return {};
}

Status LinuxcncCourseDriver::Pause() {
  if (!run_) return {};
  DropQueue();
  finishes_ = true;
  return {};
}

Status LinuxcncCourseDriver::Stop() {
  if (run_ && !stopping_) BeginStop();
  return {};
}

Status LinuxcncCourseDriver::Reset() {
  if (!state_.link_up) return RefuseMarks("the line to LinuxCNC's HAL is down");
  if (!state_.door_closed) return RefuseMarks("the door is open: close it");
  if (!state_.stop_released) return RefuseMarks("the stop button is pressed: release it");
  if (!state_.key_on) return RefuseMarks("the key is off: turn it on");
  if (run_ && !stopping_) return RefuseMarks("a run is under way: stop it before");
  recovers_ = true;
  shutter_ = false;
  const Status reset = session_.ResetBoth();
  reset_number_ = session_.number();
  return reset;
}

Status LinuxcncCourseDriver::RequestPast(std::uint32_t run, std::uint32_t first,
                                         std::uint32_t count) {
  if (!state_.link_up) return RefuseMarks("the line to LinuxCNC's HAL is down");
  return seen_.Answer(run, first, count, events_);
}

void LinuxcncCourseDriver::AddEvent(std::uint32_t mark, MarkFate fate) {
  events_.push_back({*run_, mark, fate});
  seen_.Receive(events_.back());
}

void LinuxcncCourseDriver::Report() {
  state_.link_up = session_.up() && ready_;
  state_.message = session_.message();
  state_.refusal = session_.refusal();
  state_.taken_over = session_.fenced();
  state_.session = session_.sessions();
  if (state_.link_up) {
    const HalSample& now = session_.newest();
    state_.key_on = now.Has(kHalKey);
    state_.door_closed = now.Has(kHalDoor);
    state_.stop_released = now.Has(kHalStopFree);
    state_.shutter_open = now.Has(kHalShutter) && now.Has(kHalWarm);
    state_.openings = now.openings + own_stops_;
    state_.position_mm =
        now.actual_mm - Vec3(origin_mm_.x(), origin_mm_.y(), now.actual_mm.z());
  } else {
    state_.key_on = state_.door_closed = state_.stop_released = false;
    state_.shutter_open = false;
  }
  state_.settled = state_.at_rest = !run_ && rests_;
}

std::unique_ptr<MarkDriver> MakeLinuxcncCourseDriver(const MachineSpec& machine,
                                                     link::StreamOpener,
                                                     link::SteadyClock clock) {
  return std::make_unique<LinuxcncCourseDriver>(machine, &OpenHalLine, std::move(clock));
}

}  // namespace intaglio::drivers
