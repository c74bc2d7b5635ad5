// What the driver of marks by a grbl sends, and what its answers mean
// (grbl_course_driver.h).

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "services/drivers/grbl/marks/grbl_course_driver.h"
#include "services/job/machine/course_tool.h"

namespace intaglio::drivers {
namespace {

constexpr char kMarkBarrier[] = "G4P0";

}  // namespace

void GrblCourseDriver::Receive(const GrblLine::Event& event) {
  const bool of_line = std::holds_alternative<GrblOk>(event) ||
                       std::holds_alternative<GrblError>(event) ||
                       std::holds_alternative<GrblHomed>(event);
  const auto* status = std::get_if<GrblStatus>(&event);
  if (status != nullptr) hand_motion_.Receive(event);
  if (of_line && hand_motion_.active()) {
    hand_motion_.Receive(event);
    if (std::holds_alternative<GrblHomed>(event)) EndFault();
    return;
  }
  if (std::holds_alternative<GrblUp>(event)) return TakeUp();
  if (std::holds_alternative<GrblLost>(event)) return TakeLost();
  if (std::holds_alternative<GrblOk>(event)) return TakeOk();
  if (status != nullptr) return TakeStatus(*status);
  if (const auto* alarm = std::get_if<GrblAlarm>(&event)) return TakeAlarm(*alarm);
  if (std::holds_alternative<GrblHeld>(event)) {
    return StopItself("the controller was on hold: check the work, then resume");
  }
  if (const auto* refused = std::get_if<GrblNotSetUp>(&event)) {
    return StopItself(WhyGrblIsNotSetUp(refused->code));
  }
  if (const auto* error = std::get_if<GrblError>(&event)) {
    StopItself("the controller refused a line: " + TextOfGrblError(error->code) +
               "; check its version, then resume");
  }
}

// At rest, empty and dark.
void GrblCourseDriver::TakeUp() {
  has_status_ = unsettled_ = recovers_ = false;
  grbl_ = {};
  hand_motion_.End();
}

void GrblCourseDriver::TakeLost() {
  has_status_ = recovers_ = false;
  hand_motion_.End();
  if (!run_) return;
  DropQueue();
  unsettled_ = !in_flight_.empty() || turns_;
  if (hand_ && stage_ == Hand::kAnnounced) {
    AddEvent(hand_->number, MarkFate::kBroken);
  } else if (hand_) {
    seen_.Receive({*run_, hand_->number, MarkFate::kUncertain});
    state_.fault = fmt::format(
        "the line to the controller was lost in mark {}, and the controller has made "
        "what it held: check the work, then resume",
        hand_->number);
  }
  stopping_ = false;
  EndRun();
}

void GrblCourseDriver::TakeAlarm(const GrblAlarm& alarm) {
  StopItself(TextOfGrblAlarm(alarm.code));
}

void GrblCourseDriver::TakeStatus(const GrblStatus& status) {
  const bool door = status.state == GrblState::kDoor;
  const bool hold = status.state == GrblState::kHold && !stopping_ && !recovers_;
  grbl_ = status;
  status_at_ = now();
  has_status_ = true;
  ++state_.number;
  TakeProgress();
  if (!state_.fault.empty()) return;
  if (door || line_.door_is_open()) {
    Fault("the safety door opened: close it, check the work, then resume");
  } else if (line_.stop_is_pressed()) {
    StopItself("the emergency stop is pressed: release it, check the work, then resume");
  } else if (hold) {
    StopItself("the controller is on hold: check the work, then resume");
  } else if (status.state == GrblState::kAlarm) {
    StopItself("the controller is locked: home it or set its zero, then resume");
  }
}

// What left the planner has been executed.
void GrblCourseDriver::TakeProgress() {
  int acknowledged = 0;
  bool all = true;
  for (const InFlight& one : in_flight_) {
    if (one.acknowledged) acknowledged += one.blocks;
    all = all && one.acknowledged;
  }
  if (all && grbl_.state == GrblState::kIdle) {
    in_flight_.clear();
  } else if (grbl_.free_blocks >= 0) {
    Executed(acknowledged - (line_.traits().planner_blocks - grbl_.free_blocks));
  }
}

void GrblCourseDriver::Executed(int blocks) {
  while (!in_flight_.empty()) {
    const InFlight& front = in_flight_.front();
    if (!front.acknowledged || front.waits || front.blocks > blocks) return;
    blocks -= front.blocks;
    in_flight_.pop_front();
  }
}

void GrblCourseDriver::TakeOk() {
  const auto first = std::ranges::find(in_flight_, false, &InFlight::acknowledged);
  if (first == in_flight_.end()) return;
  first->acknowledged = true;
  if (!first->waits) return;
  const InFlight done = *first;
  in_flight_.erase(in_flight_.begin(), first + 1);
  if (done.ends_mark) EndMark(MarkFate::kDone);
  if (done.ends_run) EndRun();
}

void GrblCourseDriver::EndMark(MarkFate fate) {
  AddEvent(hand_->number, fate);
  hand_.reset();
  stage_ = Hand::kNone;
}

void GrblCourseDriver::EndRun() {
  hand_.reset();
  stage_ = Hand::kNone;
  pending_.reset();
  program_.Drop();
  in_flight_.clear();
  run_.reset();
  turns_ = finishes_ = run_ends_ = held_ = false;
}

void GrblCourseDriver::CheckPermission() {
  const bool sends = stage_ == Hand::kSending || stage_ == Hand::kEnding || turns_;
  if (run_ && sends && !stopping_ && !may_be_on()) BeginStop();
}

double GrblCourseDriver::AheadSeconds() const {
  double ahead_s = 0;
  for (const InFlight& one : in_flight_) ahead_s += one.seconds;
  return ahead_s;
}

// A controller goes on with the lines behind one that it refuses: from another place, at
// another height, without a spindle.
bool GrblCourseDriver::Send(const CourseLine& line, InFlight kind) {
  if (!std::ranges::all_of(in_flight_, &InFlight::acknowledged)) return false;
  if (!line_.Send({line.text})) return false;
  kind.seconds = line.seconds;
  kind.blocks = line.blocks;
  in_flight_.push_back(kind);
  return true;
}

void GrblCourseDriver::Feed() {
  if (!run_ || !may_feed() || !line_.takes_lines()) return;
  if (hand_) return FeedMark();
  if (!queue_.empty()) {
    hand_ = std::move(queue_.front());
    queue_.pop_front();
    stage_ = Hand::kAnnounced;
    AddEvent(hand_->number, MarkFate::kBegun);
    program_.Begin(hand_->mark, pens_[hand_->mark.pen]);
    return;
  }
  if (!finishes_ || run_ends_) return;
  if (!turns_) return EndRun();
  run_ends_ = Send({"M5"}, {.waits = true, .ends_run = true});
}

void GrblCourseDriver::FeedMark() {
  if (stage_ == Hand::kAnnounced || stage_ == Hand::kEnding) return;
  if (spindle() && !turns_) {
    const std::vector<std::string> lines = {fmt::format("M3S{:.0f}", tool_.spindle_rpm()),
                                            fmt::format("G4P{:.2f}", SpinUpOf(tool_))};
    if (!line_.Send(lines)) return;
    for (int i = 0; i < 2; ++i) in_flight_.push_back({.waits = true});
    turns_ = true;
  }
  while (AheadSeconds() < kAhead_s) {
    if (!pending_) pending_ = program_.Next();
    if (!pending_) {
      if (Send({kMarkBarrier}, {.waits = true, .ends_mark = true}))
        stage_ = Hand::kEnding;
      return;
    }
    // M3, M4 and M5 are acknowledged when the planner is empty.
    if (!Send(*pending_, {.waits = pending_->text.front() == 'M'})) return;
    pending_.reset();
  }
}

void GrblCourseDriver::DropQueue() {
  for (const NumberedMark& mark : queue_) AddEvent(mark.number, MarkFate::kNotBegun);
  queue_.clear();
}

void GrblCourseDriver::StopItself(std::string why) {
  // What comes while it recovers is another stop: a person has to look again.
  if (!state_.safe_state || recovers_) ++own_stops_;
  if (recovers_) state_.fault.clear();
  recovers_ = false;
  Fault(std::move(why));
}

void GrblCourseDriver::Fault(std::string why) {
  if (state_.fault.empty()) state_.fault = std::move(why);
  state_.safe_state = true;
  hand_motion_.End();
  if (run_ && !stopping_) BeginStop();
}

void GrblCourseDriver::BeginStop() {
  DropQueue();
  stopping_ = true;
  stop_reset_ = false;
  stop_at_ = now();
  pending_.reset();
  program_.Drop();
  if (in_flight_.empty() && !turns_) return EndStop();
  line_.SendRealtime('!');
}

// The reset comes at rest: so the controller keeps its place.
void GrblCourseDriver::FeedStop() {
  if (!stop_reset_) {
    const bool rests = status_at_ > stop_at_ && grbl_.at_rest();
    if (!rests && now() - stop_at_ < kBraking) return;
    stop_reset_ = true;
    stop_at_ = now();
    line_.Reset();
    return;
  }
  if (!line_.resetting() && status_at_ > stop_at_) EndStop();
}

void GrblCourseDriver::EndStop() {
  if (hand_) AddEvent(hand_->number, MarkFate::kBroken);
  stopping_ = false;
  EndRun();
}

void GrblCourseDriver::EndFault() {
  state_.safe_state = false;
  state_.fault.clear();
}

// The line takes lines and resets again behind a status that is newer than the one
// before.
void GrblCourseDriver::FeedRecovery() {
  const bool homes = line_.locked() && line_.traits().homing;
  if (!line_.Recover(grbl_) && !homes) return;
  recovers_ = false;
  EndFault();
}

}  // namespace intaglio::drivers
