#include "services/cell/work_states.h"

namespace intaglio::cell {

const char WorkStates::kLatePermission[] =
    "the permission of the job service is late: this computer is too busy, or its job "
    "service is gone; the job continues when it comes";

const char WorkStates::kLateState[] =
    "the state of the laser or of the stage is late: this computer is too busy; the job "
    "continues when it comes";

WorkStates::WorkStates(PermissionChain& chain, Consent& consent)
    : chain_(chain), consent_(consent) {
  // Armed before there was a path, and spent before it came.
  if (chain_.has_spent()) message_ = TextOf(chain_.spent_by());
}

void WorkStates::Stop(const std::string& why, bool lamp_stays) {
  stopping_ = true;
  message_ = why;
  NoteStop(lamp_stays);
}

Missing WorkStates::TurnChain(ChainLinks links, std::chrono::nanoseconds now) {
  // A new arm counts when it can be acted on: a Reset is sent between runs.
  if (activity() == Activity::kSettles) links.permission_fresh = false;
  const Missing spent_by = chain_.Turn(links, now);
  if (spent_by == Missing::kNothing || stopping_) return Missing::kNothing;
  if (activity() == Activity::kRuns)
    return IsUnseen(spent_by) ? spent_by : Missing::kNothing;
  starts_again_ = lost_a_line_ = false;
  message_ = TextFor(spent_by);
  if (consent_.was_asked()) message_ += "; " + Question();
  return Missing::kNothing;
}

void WorkStates::RefuseArms(const std::string& why) {
  if (stopping_ || why.empty()) return;
  chain_.Latch(false);
  starts_again_ = lost_a_line_ = false;
  if (faulted()) message_ = why + ", then resume";
}

void WorkStates::ReceiveConsent(const GrantInputs& inputs) {
  if (!stopping_) consent_.TakeConsent(inputs, activity() == Activity::kSettles);
}

bool WorkStates::IsOnlyLate(ChainLinks links, bool with_shutters) const {
  if (links.permission_fresh && !links.laser_late && !links.motion_late) return false;
  if (!links.permission_fresh) links.permission_fresh = links.permission_granted = true;
  links.laser_line_up = links.laser_line_up || links.laser_late;
  links.motion_fresh = links.motion_fresh || links.motion_late;
  return chain_.WhatIsMissing(links, with_shutters) == Missing::kNothing;
}

void WorkStates::AskOverUncertain(const GrantInputs& inputs) {
  if (stopping_ || activity() != Activity::kIdle || !consent_.MustAsk(inputs)) return;
  const std::string why = faulted() && !lost_a_line_ ? message_ + "; " : "";
  Explain(chain_.spent_by(), why + Question(), false, true);
  consent_.NoteAsked();
}

void WorkStates::Explain(Missing missing, const std::string& text, bool lost_a_line,
                         bool fault, bool starts_again) {
  message_ = text;
  lost_a_line_ = lost_a_line;
  starts_again_ = starts_again;
  if (fault) chain_.Latch(lost_a_line_, missing);
}

}  // namespace intaglio::cell
