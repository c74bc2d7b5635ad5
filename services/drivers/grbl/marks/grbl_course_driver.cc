#include "services/drivers/grbl/marks/grbl_course_driver.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "engrave/core/try.h"
#include "services/drivers/interface/power_up.h"
#include "services/job/machine/course_tool.h"

namespace intaglio::drivers {
namespace {

link::ExpectedDevice ExpectedAtMarkLine(const MachineSpec& machine) {
  const SerialLine& line = machine.mark_line();
  return {line.serial_number(), "controller", machine.name(), line.device(), "mark_line"};
}

CourseToolOptions OptionsOf(const CourseTool& tool) {
  CourseToolOptions options;
  options.tool =
      tool.kind() == COURSE_TOOL_SPINDLE ? GrblTool::kSpindle : GrblTool::kLaser;
  options.safe_height_mm = SafeHeightOf(tool);
  options.lines_only = tool.lines_only();
  return options;
}

Status RefuseCourse(std::string why) { return Fail(ErrorCode::kRefused, std::move(why)); }

/// What a tool of this kind cannot be asked for.
Status CheckPenOf(GrblTool tool, const mark::Pen& pen) {
  if (tool == GrblTool::kLaser && pen.depth_mm > 0) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("pen {:?}: a depth of {:g} mm is of a spindle, and "
                            "course_tool.kind is a laser; give a power",
                            pen.name, pen.depth_mm));
  }
  if (tool == GrblTool::kSpindle && pen.power_ratio > 0) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("pen {:?}: a power of {:g} is of a laser, and "
                            "course_tool.kind is a spindle; give a depth",
                            pen.name, pen.power_ratio));
  }
  if (pen.frequency_hz > 0) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("pen {:?}: a controller of the grbl family has no pulses of "
                            "{:g} Hz; leave the frequency out",
                            pen.name, pen.frequency_hz));
  }
  return {};
}

}  // namespace

GrblCourseDriver::GrblCourseDriver(const MachineSpec& machine, link::StreamOpener open,
                                   link::SteadyClock clock)
    : clock_(clock),
      tool_(machine.course_tool()),
      options_(OptionsOf(tool_)),
      line_(std::move(open), std::move(clock), ExpectedAtMarkLine(machine),
            options_.tool),
      program_(options_),
      hand_motion_(
          line_, clock_, [this] { return Reset(); },
          [this](std::string why) { StopItself(std::move(why)); }) {}

void GrblCourseDriver::Poll() {
  std::vector<GrblLine::Event> events;
  line_.Poll(events);
  for (const GrblLine::Event& event : events) Receive(event);
  CheckPermission();
  if (stopping_)
    FeedStop();
  else if (recovers_)
    FeedRecovery();
  else if (hand_motion_.active())
    hand_motion_.Feed();
  else
    Feed();
  Report();
  hand_motion_.TakeState(state_, grbl_, run_.has_value());
  state_.settled = state_.settled && !hand_motion_.active();
  state_.at_rest = state_.at_rest && !hand_motion_.active();
}

std::vector<MarkEvent> GrblCourseDriver::TakeEvents() {
  if (stage_ == Hand::kAnnounced) stage_ = Hand::kSending;
  return std::exchange(events_, {});
}

Status GrblCourseDriver::Permit(bool permitted) {
  if (permitted) {
    permit_at_ = now();
    held_ = false;
    return {};
  }
  permit_at_.reset();
  return run_ ? Stop() : Status();
}

bool GrblCourseDriver::is_permitted_for(std::chrono::milliseconds lease) const {
  return permit_at_ && now() - *permit_at_ <= lease;
}

Status GrblCourseDriver::Hold() {
  if (!spindle()) return MarkDriver::Hold();
  if (!run_ || stopping_) return RefuseCourse("there is no run to hold");
  held_ = true;
  return {};
}

Status GrblCourseDriver::Begin(std::uint32_t run, std::span<const mark::Pen> pens) {
  if (!state_.link_up) return RefuseCourse("the line to the controller is down");
  if (!state_.settled || run_) return RefuseCourse("a run is not at its end");
  if (!state_.fault.empty()) return RefuseCourse(state_.fault);
  if (!state_.place_lost.empty()) return RefuseCourse(state_.place_lost);
  if (!line_.takes_lines() || grbl_.state != GrblState::kIdle || hand_motion_.active())
    return RefuseCourse("the controller is not idle: check door, hold and zero");
  if (run <= state_.newest_run)
    return RefuseCourse(fmt::format("run {} is not above {}", run, state_.newest_run));
  for (const mark::Pen& pen : pens) INTAGLIO_TRY(CheckPenOf(options_.tool, pen));
  if (spindle() && tool_.spindle_rpm() > line_.traits().max_power) {
    return Fail(ErrorCode::kInvalidValue,
                fmt::format("course_tool.spindle_rpm: {:g} is more than $30={:g} of the "
                            "controller; reduce it, or set $30 to the spindle's most",
                            tool_.spindle_rpm(), line_.traits().max_power));
  }
  state_.newest_run = run;
  run_ = run;
  pens_.assign(pens.begin(), pens.end());
  finishes_ = run_ends_ = false;
  program_.SetController(line_.traits());
  program_.RestAt(*grbl_.work_mm);
  Report();
  return {};
}

std::size_t GrblCourseDriver::Room() const {
  if (!run_ || finishes_ || stopping_) return 0;
  return kQueuedMarks - queue_.size();
}

Status GrblCourseDriver::Append(const NumberedMark& mark) {
  if (Room() == 0) return RefuseCourse("there is no room for a mark");
  INTAGLIO_TRY(mark::CheckMarks({pens_, {mark.mark}}));
  if (mark::IsRow(mark.mark)) {
    return Fail(
        ErrorCode::kUnsupported,
        fmt::format("mark {}: is a row of dots, and a controller of the grbl family "
                    "does not switch the beam on its way; use contours",
                    mark.number));
  }
  if (!spindle() && EdgesOfMark(mark.mark).empty()) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("mark {}: is a place without a way, in which a laser of the "
                            "grbl family is dark; make it a circle",
                            mark.number));
  }
  queue_.push_back(mark);
  return {};
}

Status GrblCourseDriver::Finish() {
  if (!run_) return RefuseCourse("there is no run");
  finishes_ = true;
  return {};
}

Status GrblCourseDriver::Pause() {
  if (!run_) return {};
  DropQueue();
  finishes_ = true;
  return {};
}

Status GrblCourseDriver::Stop() {
  if (run_ && !stopping_) BeginStop();
  return {};
}

Status GrblCourseDriver::Reset() {
  if (!state_.link_up) return RefuseCourse("the line to the controller is down");
  if (line_.door_is_open()) return RefuseCourse("the door is open: close it");
  if (line_.stop_is_pressed())
    return RefuseCourse("the emergency stop is pressed: release it");
  if (run_ && !stopping_) return RefuseCourse("a run is under way: stop it before");
  recovers_ = true;
  return {};
}

Status GrblCourseDriver::RequestPast(std::uint32_t run, std::uint32_t first,
                                     std::uint32_t count) {
  if (!state_.link_up) return RefuseCourse("the line to the controller is down");
  return seen_.Answer(run, first, count, events_);
}

void GrblCourseDriver::AddEvent(std::uint32_t mark, MarkFate fate) {
  events_.push_back({*run_, mark, fate});
  seen_.Receive(events_.back());
}

void GrblCourseDriver::Report() {
  state_.link_up = line_.up() && has_status_;
  state_.message = line_.message();
  state_.refusal = line_.refusal();
  state_.session = line_.sessions();
  state_.key_on = state_.door_closed = state_.link_up && !line_.door_is_open();
  state_.stop_released = state_.link_up && !line_.chain_is_open();
  state_.openings = line_.chain_openings() + own_stops_;
  if (power_ups_ != line_.power_ups()) {
    power_ups_ = line_.power_ups();
    state_.power_up = fmt::format("grbl-{:08x}", DrawPowerUp());
  }
  const bool lost = line_.place_is_lost();
  if (lost && state_.place_lost.empty() && !line_.traits().homing) ++state_.axes_number;
  state_.place_lost = lost ? WhyPlaceIsLost() : "";
  state_.work_offset_mm = line_.work_offset_mm();
  state_.can_hold = spindle();
  // There is no shutter: the permission is what lets beam and spindle on.
  state_.shutter_open =
      state_.link_up && may_be_on() && !stopping_ && state_.fault.empty();
  state_.at_rest = !run_ && in_flight_.empty() && grbl_.at_rest();
  const bool ready = line_.takes_lines() || !state_.fault.empty();
  state_.settled = state_.link_up && ready && !run_ && !stopping_ && !unsettled_;
  if (grbl_.work_mm) state_.position_mm = *grbl_.work_mm;
  if (state_.link_up) UpdateReach();
}

// Where the controller rests when the line comes back, unless it was switched off: on the
// way of what was sent.
void GrblCourseDriver::UpdateReach() {
  if (hand_motion_.active()) return line_.SetReach(hand_motion_.reach());
  Box3 reach{state_.position_mm, state_.position_mm};
  if (hand_) reach.Extend(program_.reach());
  line_.SetReach(reach);
}

std::string GrblCourseDriver::WhyPlaceIsLost() const {
  const char* const remedy =
      line_.traits().homing
          ? "home it (`intaglio teach home`)"
          : "drive the tool to the work zero and set it in x, y and z (`intaglio teach "
            "zero`)";
  return WhyGrblPlaceIsLost(remedy);
}

std::unique_ptr<MarkDriver> MakeGrblCourseDriver(const MachineSpec& machine,
                                                 link::StreamOpener open,
                                                 link::SteadyClock clock) {
  return std::make_unique<GrblCourseDriver>(machine, std::move(open), std::move(clock));
}

std::vector<Error> CheckGrblCourseProfile(const MachineSpec& machine) {
  std::vector<Error> errors;
  const CourseTool& tool = machine.course_tool();
  const auto add = [&](ErrorCode code, std::string sentence) {
    errors.push_back({code, std::move(sentence), ""});
  };
  if (tool.kind() != COURSE_TOOL_LASER && tool.kind() != COURSE_TOOL_SPINDLE) {
    add(ErrorCode::kMissing,
        fmt::format("course_tool.kind: {} is none; give COURSE_TOOL_LASER or "
                    "COURSE_TOOL_SPINDLE",
                    static_cast<int>(tool.kind())));
  }
  const bool is_spindle = tool.kind() == COURSE_TOOL_SPINDLE;
  if (is_spindle && !tool.has_spindle_rpm()) {
    add(ErrorCode::kMissing,
        "course_tool.spindle_rpm: is missing; give the speed of the tool at work");
  }
  if (!is_spindle && (tool.has_spindle_rpm() || tool.has_spin_up_s())) {
    add(ErrorCode::kInvalidValue,
        fmt::format("course_tool.spindle_rpm: {:g} and spin_up_s are of a spindle; "
                    "remove them, or give COURSE_TOOL_SPINDLE",
                    tool.spindle_rpm()));
  }
  return errors;
}

}  // namespace intaglio::drivers
