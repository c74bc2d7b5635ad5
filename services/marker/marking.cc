#include "services/marker/marking.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace intaglio::marker {

using cell::ChainLinks;
using cell::GrantInputs;
using cell::Missing;
using cell::PointState;
using namespace std::chrono_literals;

namespace {

constexpr const char* kFinishesMark =
    "THE MACHINE IS STILL AT WORK until the mark in hand is made to its end: keep away; "
    "its stop button ends it at once";

constexpr auto kStopPeriod = 500ms;
constexpr double kRestingWeb_mm_s = 0.05;

double LongestMarkS(const mark::MarkSet& set) {
  double longest_s = 0;
  for (const mark::Mark& mark : set.marks) {
    const mark::Pen& pen = set.pens[mark.pen];
    longest_s =
        std::max(longest_s, mark::LengthOf(mark) * pen.pass_count / pen.speed_mm_s);
  }
  return longest_s;
}

}  // namespace

Marking::Marking(MarkingJob job, drivers::MarkDriver& driver,
                 cell::JournalWriter& journal, cell::PermissionChain& chain)
    : WorkStates(chain, consent_),
      job_(std::move(job)),
      driver_(driver),
      record_(job_.marks.marks.size(), journal),
      run_(job_.marks, job_.eye, driver, record_),
      consent_({job_.asks_when_uncertain, job_.earlier.uncertain_unanswered,
                job_.earlier.consent_grant},
               record_, chain),
      longest_mark_s_(LongestMarkS(job_.marks)) {
  if (job_.earlier.points.empty()) return;
  taken_up_ = true;
  phase_ = Phase::kHalting;
  message_ = "the job continues: requesting from the controller what became of its marks";
  run_.TakeUp(record_.TakeUp(job_.earlier));
  consent_.TakeUp();
}

ChainLinks LinksOf(const drivers::MarkDeviceState& state, const GrantInputs& inputs) {
  ChainLinks links;
  links.permission_fresh = inputs.permission_fresh;
  links.permission_granted = inputs.permission_granted;
  links.grant = inputs.grant;
  links.stop_not_pressed = !inputs.stop_pressed;
  links.laser_line_up = state.link_up;
  links.key_on = state.key_on;
  links.door_closed = state.door_closed;
  links.stop_released = state.stop_released;
  links.no_safe_state = !state.safe_state;
  links.lamp_sync_counted = links.lamp_warm = true;
  links.motion_fresh = state.link_up;
  links.motion_without_fault = state.fault.empty();
  links.shutters_open = state.shutter_open;
  links.door_locked = true;  // such machines report no lock
  links.counters = {PowerUpNumber(state.power_up), state.openings};
  return links;
}

Marking::Activity Marking::activity() const {
  switch (phase_) {
    case Phase::kWaiting:
      return Activity::kIdle;
    case Phase::kOpening:
    case Phase::kRunning:
    case Phase::kPausing:
      return Activity::kRuns;
    case Phase::kHalting:
      return Activity::kSettles;
    case Phase::kDone:
      break;
  }
  return Activity::kDone;
}

const std::string& WhyNoArmCounts(const drivers::MarkDeviceState& state) {
  return state.refusal.empty() ? state.place_lost : state.refusal;
}

void Marking::Turn(const GrantInputs& inputs) {
  TakeEvents(inputs.now);
  const Missing unseen = TurnChain(LinksOf(driver_.state(), inputs), inputs.now);
  if (unseen != Missing::kNothing) Halt(unseen, TextFor(unseen), true, inputs.now);
  const std::string& why = WhyNoArmCounts(driver_.state());
  RefuseArms(why.empty() ? inputs.zero_refusal : why);
  ReceiveConsent(inputs);
  AskOverUncertain(inputs);
  switch (phase_) {
    case Phase::kWaiting:
      Wait(inputs);
      break;
    case Phase::kOpening:
      Open(inputs);
      break;
    case Phase::kRunning:
      Run(inputs);
      break;
    case Phase::kPausing:
      Pause(inputs);
      break;
    case Phase::kHalting:
      Settle(inputs);
      break;
    case Phase::kDone:
      break;
  }
  SendPermit(inputs.now);
  WatchProgress(inputs.now);
  record_.FlushAppended();
}

void Marking::TakeEvents(std::chrono::nanoseconds now) {
  for (const drivers::MarkEvent& event : driver_.TakeEvents()) {
    moved_at_ = now;
    if (run_.Receive(event)) consent_.NoteUncertain();
  }
}

std::string Marking::Question() const {
  const auto [first, last] = consent_.UncertainRange();
  const Vec2 at_mm = job_.marks.marks[first].places.front().at_mm;
  return fmt::format(
      "marks that are begun, or of which nobody knows: {}, at places {}..{} of the order "
      "(from 0), the first begins at {:.3f}, {:.3f} mm; check the piece; `intaglio "
      "resume "
      "JOB` leaves them as they are, `intaglio resume JOB --fire-uncertain` makes them "
      "again from their beginning",
      record_.ledger().count(PointState::kUncertain), first, last, at_mm.x(), at_mm.y());
}

void Marking::SendPermit(std::chrono::nanoseconds now) {
  const bool may =
      phase_ == Phase::kOpening || phase_ == Phase::kRunning || phase_ == Phase::kPausing;
  if (held_) return;
  if (may == permitted_ && (!may || now < permit_at_)) return;
  if (!driver_.state().link_up || !driver_.Permit(may)) return;
  permitted_ = may;
  permit_at_ = now + kPermitPeriod;
}

void Marking::WatchProgress(std::chrono::nanoseconds now) {
  if (phase_ != Phase::kRunning) {
    moved_at_ = now;
    alarm_.clear();
    return;
  }
  const std::chrono::duration<double> limit = kStallTime + 2s * longest_mark_s_;
  alarm_ = now - moved_at_ < limit
               ? ""
               : fmt::format(
                     "no mark was begun or ended for {:.0f} s: check whether the "
                     "machine moves, and the web, if there is one",
                     std::chrono::duration<double>(now - moved_at_).count());
}

// Behind the last mark, too, it is a person who decides on a mark that an opened door, a
// hold or a fault has broken.
bool Marking::AwaitsPerson() const {
  return faulted() && !lost_a_line() &&
         record_.ledger().count(PointState::kUncertain) > 0;
}

void Marking::Wait(const GrantInputs& inputs) {
  const auto nothing_is_left = [&] {
    return !consent_.KeepsJobOpen(inputs) && !record_.ledger().NextOpen(0) &&
           !AwaitsPerson();
  };
  if (stopping_ || nothing_is_left()) {
    if (stopping_ || record_.is_durable()) phase_ = Phase::kDone;
    if (record_.disk_failed()) message_ = record_.disk_error();
    return;
  }
  const drivers::MarkDeviceState& state = driver_.state();
  const bool latched = state.safe_state || !state.stop_released || !state.fault.empty();
  if (state.link_up && latched && chain_.may_reset(LinksOf(driver_.state(), inputs)) &&
      inputs.now >= stop_again_at_) {
    stop_again_at_ = inputs.now + 100ms;
    (void)driver_.Reset();
  }
  if (!MayMark(inputs)) return;
  if (!state.settled || !state.at_rest) {
    message_ = "the machine comes to rest";
    return;
  }
  if (WebIsTooFast()) return;
  bool reopened_any = false;
  const bool all_open =
      record_.LeaveOutBefore(inputs.first_point) &&
      consent_.Reopen(inputs, reopened_any) && run_.LeaveOutBegunRepeats() &&
      record_.KeepSession(PowerUpNumber(state.power_up), chain_.counters().openings);
  if (record_.disk_failed()) message_ = record_.disk_error();
  if (!all_open || !record_.is_durable() || !record_.ledger().NextOpen(0)) return;
  // What paused the job is over.
  message_.clear();
  phase_ = Phase::kOpening;
  opening_since_ = inputs.now;
}

bool Marking::MayMark(const GrantInputs& inputs) {
  const Missing missing = WhatIsMissing(inputs, true);
  if (missing == Missing::kNothing) return true;
  if (!faulted()) message_ = TextFor(missing);
  return false;
}

// By its encoder, before anything is made: later it is the driver that ends the run.
bool Marking::WebIsTooFast() {
  const double web_mm_s = driver_.state().web_mm_s;
  if (job_.max_web_mm_s <= 0 || web_mm_s <= job_.max_web_mm_s) return false;
  message_ = fmt::format(
      "the web runs at {:.1f} mm/s, and all marks are made up to {:.1f} mm/s: reduce the "
      "speed of its drive",
      web_mm_s, job_.max_web_mm_s);
  return true;
}

// Without it a job under a web that nobody has started looks like one at work.
std::string_view Marking::WhatRunWaitsFor() const {
  const drivers::MarkDeviceState& state = driver_.state();
  const bool rests = job_.max_web_mm_s > 0 && state.web_mm_s < kRestingWeb_mm_s;
  if (rests && state.print_text.empty()) return "the web rests: start its drive";
  return state.print_text;
}

Missing Marking::WhatIsMissing(const GrantInputs& inputs, bool with_permission) const {
  ChainLinks links = LinksOf(driver_.state(), inputs);
  if (!with_permission) links.permission_granted = true;
  const bool with_shutter = phase_ == Phase::kRunning || phase_ == Phase::kPausing;
  return chain_.WhatIsMissing(links, with_shutter);
}

std::string Marking::TextFor(Missing missing) const {
  const drivers::MarkDeviceState& state = driver_.state();
  switch (missing) {
    case Missing::kMotionFault:
    case Missing::kOpenedUnseen:
      return state.fault.empty() ? TextOf(missing) : state.fault;
    case Missing::kLaserLine:
      return "the line to the controller is down: " +
             (state.message.empty() ? "check the cable and the controller, then resume"
                                    : state.message);
    case Missing::kSafeState:
      return state.fault.empty() ? "the controller ended the beam by itself: check the "
                                   "machine, then resume to reset it"
                                 : state.fault;
    case Missing::kShutter:
      return "the beam was switched off, because this computer was too busy to permit it "
             "in time, or the shutter closed: reduce the load, check the shutter's "
             "drive, then resume";
    default:
      return TextOf(missing);
  }
}

void Marking::Open(const GrantInputs& inputs) {
  if (stopping_) return Halt(Missing::kNothing, message_, false, inputs.now);
  const Missing missing = WhatIsMissing(inputs, true);
  if (missing != Missing::kNothing) {
    return Halt(missing, TextFor(missing), missing != Missing::kPermission, inputs.now);
  }
  if (!driver_.state().shutter_open) {
    if (inputs.now - opening_since_ < kShutterTime) return;
    return Halt(Missing::kShutter, TextOf(Missing::kShutter), true, inputs.now);
  }
  if (const auto begun = run_.Begin(); !begun) {
    return Halt(Missing::kMotionFault, begun.error().message, true, inputs.now);
  }
  consent_.BeginRun();
  message_.clear();
  phase_ = Phase::kRunning;
  pause_sent_ = false;
}

bool Marking::HoldsForLatePermission(const GrantInputs& inputs) {
  const bool held = std::exchange(held_, false);
  const drivers::MarkDeviceState& state = driver_.state();
  if (!state.can_hold || !IsOnlyLate(LinksOf(state, inputs), true)) return false;
  held_ = held || driver_.Hold().has_value();
  if (held_) message_ = kLatePermission;
  return held_;
}

void Marking::Run(const GrantInputs& inputs) {
  if (stopping_) return Halt(Missing::kNothing, message_, false, inputs.now);
  if (driver_.state().session != run_.session()) {
    return Halt(Missing::kLaserLine, TextFor(Missing::kLaserLine), true, inputs.now);
  }
  if (HoldsForLatePermission(inputs)) return;
  const bool withdrawn = inputs.permission_fresh && !inputs.permission_granted;
  const Missing missing = WhatIsMissing(inputs, !withdrawn);
  if (missing == Missing::kPermission && !inputs.permission_fresh)
    return Halt(missing, kLatePermission, false, inputs.now);
  if (missing != Missing::kNothing) {
    return Halt(missing, TextFor(missing), missing != Missing::kPermission, inputs.now);
  }
  if (withdrawn) {
    message_ = kFinishesMark;
    run_.End();
    phase_ = Phase::kPausing;
    return Pause(inputs);
  }
  if (record_.disk_failed()) {
    message_ = record_.disk_error();
  } else if (const std::string_view wait = WhatRunWaitsFor(); message_ != wait) {
    message_ = wait;
  }
  if (const auto sent = run_.Turn(); !sent) {
    return Halt(Missing::kMotionFault, sent.error().message, true, inputs.now);
  }
  if (!run_.is_over() || !driver_.state().at_rest) return;
  phase_ = Phase::kWaiting;
}

// The mark in hand is ended; the beam ends at once when anything but the permission is
// missing.
void Marking::Pause(const GrantInputs& inputs) {
  if (stopping_) return Halt(Missing::kNothing, message_, false, inputs.now);
  if (driver_.state().session != run_.session()) {
    return Halt(Missing::kLaserLine, TextFor(Missing::kLaserLine), true, inputs.now);
  }
  if (HoldsForLatePermission(inputs)) return;
  if (!inputs.permission_fresh)
    return Halt(Missing::kPermission, kLatePermission, false, inputs.now);
  const Missing missing = WhatIsMissing(inputs, false);
  if (missing != Missing::kNothing)
    return Halt(missing, TextFor(missing), true, inputs.now);
  if (!pause_sent_) pause_sent_ = driver_.Pause().has_value();
  const drivers::MarkDeviceState& state = driver_.state();
  if (!pause_sent_ || !state.at_rest || !state.settled) return;
  message_ = TextOf(Missing::kPermission);
  phase_ = Phase::kHalting;
}

void Marking::Halt(Missing missing, const std::string& text, bool fault,
                   std::chrono::nanoseconds now) {
  (void)driver_.Stop();
  stop_again_at_ = now + kStopPeriod;
  held_ = false;
  run_.End();
  Explain(missing, text, cell::IsLostLine(missing, false), fault);
  phase_ = Phase::kHalting;
}

void Marking::Settle(const GrantInputs& inputs) {
  if (stopping_ && stopping_since_.count() < 0) stopping_since_ = inputs.now;
  const bool late = stopping_ && inputs.now - stopping_since_ > kStopTime;
  const drivers::MarkDeviceState& state = driver_.state();
  if (late || (stopping_ && run_.all_settled() && (state.settled || !state.link_up))) {
    phase_ = Phase::kDone;
    return;
  }
  if (!state.link_up) return;
  if (!state.settled) {
    if (inputs.now < stop_again_at_) return;
    stop_again_at_ = inputs.now + kStopPeriod;
    (void)driver_.Stop();
    return;
  }
  if (!run_.all_settled()) {
    if (run_.Settle(inputs.now) > 0) consent_.NoteUncertain();
    return;
  }
  if (inputs.grant.number == 0 && taken_up_ && run_.count() == 0) return;
  phase_ = Phase::kWaiting;
}

}  // namespace intaglio::marker
