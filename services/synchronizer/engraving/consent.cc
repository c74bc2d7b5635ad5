#include "services/synchronizer/engraving/consent.h"

#include <fmt/format.h>

#include <algorithm>

namespace intaglio::synchronizer {

using formats::PointOutcome;

void Consent::TakeUp() {
  asks_ = asks_ || (job_.asks_when_uncertain && job_.earlier.uncertain_unanswered &&
                    record_.ledger().count(PointState::kUncertain) > 0);
}

void Consent::Note(const PulseResult& result) {
  if (result.outcome != PointOutcome::kUncertain || !job_.asks_when_uncertain) return;
  asks_ = true;
  asked_ = false;
}

// Nothing is armed while a halt is settled, nor before the first run that the consent
// lets begin: what is armed by now is what the person means, too. A run that goes on arms
// more.
void Consent::TakeConsent(const EngravingInputs& inputs, bool settling) {
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

bool Consent::Holds(const EngravingInputs& inputs) const {
  return inputs.fire_uncertain && IsOf(inputs.grant) &&
         std::any_of(covered_.begin(), covered_.end(),
                     [this](std::uint32_t point) { return IsUncertain(point); });
}

// Given before the question came up, and about all of it.
bool Consent::AnswersAll(const EngravingInputs& inputs) const {
  if (!Holds(inputs) || chain_.has_lost(inputs.grant)) return false;
  const auto covered =
      std::count_if(covered_.begin(), covered_.end(),
                    [this](std::uint32_t point) { return IsUncertain(point); });
  return static_cast<std::uint64_t>(covered) ==
         record_.ledger().count(PointState::kUncertain);
}

// What has been settled otherwise is not covered any more.
bool Consent::Reopen(const EngravingInputs& inputs, bool& reopened_any) {
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

bool Consent::MustAsk(const EngravingInputs& inputs) const {
  return asks_ && !asked_ && inputs.grant.number != 0 && !AnswersAll(inputs);
}

bool Consent::KeepsJobOpen(const EngravingInputs& inputs) const {
  if (Holds(inputs)) return true;
  const bool granted = inputs.permission_fresh && inputs.permission_granted;
  return asks_ && (!asked_ || chain_.latched() || !granted);
}

std::string Consent::Question() const {
  const PointLedger& ledger = record_.ledger();
  std::uint32_t first = 0, last = 0;
  bool found = false;
  for (std::uint32_t point = 0; point < ledger.size(); ++point) {
    if (!IsUncertain(point)) continue;
    if (!found) first = point;
    found = true;
    last = point;
  }
  const Vec3 at_mm = job_.machine_from_glass.ToGlass(job_.machine_points_mm[first]);
  return fmt::format(
      "points of which nobody knows whether they were fired: {}, at places {}..{} of the "
      "order (from 0), the first at {:.3f}, {:.3f}, {:.3f} mm of the block; check the "
      "block; `intaglio resume JOB` leaves them as they are, "
      "`intaglio resume JOB --fire-uncertain` makes them",
      ledger.count(PointState::kUncertain), first, last, at_mm.x(), at_mm.y(), at_mm.z());
}

}  // namespace intaglio::synchronizer
