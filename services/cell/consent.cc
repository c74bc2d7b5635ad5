#include "services/cell/consent.h"

#include <algorithm>

namespace intaglio::cell {

void Consent::TakeUp() {
  asks_ = asks_ || (terms_.asks_when_uncertain && terms_.uncertain_unanswered &&
                    record_.ledger().count(PointState::kUncertain) > 0);
}

void Consent::NoteUncertain() {
  if (!terms_.asks_when_uncertain) return;
  asks_ = true;
  asked_ = false;
}

// Nothing is armed while a halt is settled, nor before the first run that the consent
// lets begin: what is armed by now is what the person means, too. A run that goes on arms
// more.
void Consent::TakeConsent(const GrantInputs& inputs, bool settling) {
  if (!inputs.fire_uncertain || inputs.grant.number <= grant_number_) return;
  if (!record_.KeepConsent(inputs.grant.number)) return;
  grant_number_ = inputs.grant.number;
  covered_.clear();
  const PointLedger& ledger = record_.ledger();
  for (std::uint32_t point = inputs.first_point; point < ledger.size(); ++point) {
    const PointState state = ledger.state(point);
    if (state == PointState::kUncertain || (settling && state == PointState::kArmed)) {
      covered_.push_back(point);
    }
  }
}

bool Consent::Holds(const GrantInputs& inputs) const {
  return inputs.fire_uncertain && IsOf(inputs.grant) &&
         std::any_of(covered_.begin(), covered_.end(),
                     [this](std::uint32_t point) { return IsUncertain(point); });
}

// Given before the question came up, and about all of it.
bool Consent::AnswersAll(const GrantInputs& inputs) const {
  if (!Holds(inputs) || chain_.has_lost(inputs.grant)) return false;
  const auto covered =
      std::count_if(covered_.begin(), covered_.end(),
                    [this](std::uint32_t point) { return IsUncertain(point); });
  return static_cast<std::uint64_t>(covered) ==
         record_.ledger().count(PointState::kUncertain);
}

// What has been settled otherwise is not covered any more.
bool Consent::Reopen(const GrantInputs& inputs, bool& reopened_any) {
  if (!inputs.fire_uncertain || !IsOf(inputs.grant)) covered_.clear();
  for (; !covered_.empty(); covered_.pop_back()) {
    const std::uint32_t point = covered_.back();
    if (!IsUncertain(point)) continue;
    if (!record_.Reopen(point, grant_number_)) return false;
    reopened_any = true;
  }
  asks_ = asks_ && record_.ledger().count(PointState::kUncertain) > 0;
  return true;
}

bool Consent::MustAsk(const GrantInputs& inputs) const {
  return asks_ && !asked_ && inputs.grant.number != 0 && !AnswersAll(inputs);
}

bool Consent::KeepsJobOpen(const GrantInputs& inputs) const {
  if (Holds(inputs)) return true;
  const bool granted = inputs.permission_fresh && inputs.permission_granted;
  return asks_ && (!asked_ || chain_.latched() || !granted);
}

std::pair<std::uint32_t, std::uint32_t> Consent::UncertainRange() const {
  std::pair<std::uint32_t, std::uint32_t> range;
  bool found = false;
  for (std::uint32_t point = 0; point < record_.ledger().size(); ++point) {
    if (!IsUncertain(point)) continue;
    if (!found) range.first = point;
    found = true;
    range.second = point;
  }
  return range;
}

}  // namespace intaglio::cell
