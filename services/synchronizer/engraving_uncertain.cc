#include <fmt/format.h>

#include <algorithm>

#include "services/synchronizer/engraving.h"

// What is done about points of which nobody knows whether they were fired: they are left,
// and a job that says so waits until a person has looked at the block. They are fired
// again by a person's word alone, which comes with a grant and counts once: for what is
// uncertain when it is heard, and for what becomes so because it was armed before and is
// still being settled then. So the journal has it before anything more is armed; what is
// armed later, in this life or another, is not meant by it, nor is what a life did not
// come to open before it ended.

namespace intaglio::synchronizer {

// What lies before the place that is engraved from is left for good. While it halts
// nothing is armed any more, and nothing is before the first run that the word lets
// begin: what is armed by now is what the person means, too. A run that goes on arms
// more.
void Engraving::HearWord(const EngravingInputs& inputs) {
  if (!inputs.fire_uncertain || inputs.grant.number <= word_grant_ || stopping_) return;
  if (!record_.KeepConsent(inputs.grant.number)) {
    return;
  }
  word_grant_ = inputs.grant.number;
  word_of_.clear();
  const bool settles = phase_ == Phase::kHalting;
  for (std::uint32_t point = inputs.first_point; point < record_.ledger().size();
       ++point) {
    const PointState state = record_.ledger().state(point);
    if (state == PointState::kUncertain || (settles && state == PointState::kArmed)) {
      word_of_.push_back(point);
    }
  }
}

bool Engraving::WordIsOf(const Grant& grant) const {
  return word_grant_ > 0 && grant.number == word_grant_;
}

bool Engraving::WordStands(const EngravingInputs& inputs) const {
  return inputs.fire_uncertain && WordIsOf(inputs.grant) &&
         std::any_of(word_of_.begin(), word_of_.end(), [this](std::uint32_t point) {
           return record_.ledger().state(point) == PointState::kUncertain;
         });
}

// Said before the question was, and about all of it.
bool Engraving::WordAnswers(const EngravingInputs& inputs) const {
  if (!WordStands(inputs) || chain_.has_lost(inputs.grant)) return false;
  const auto meant =
      std::count_if(word_of_.begin(), word_of_.end(), [this](std::uint32_t point) {
        return record_.ledger().state(point) == PointState::kUncertain;
      });
  return static_cast<std::uint64_t>(meant) ==
         record_.ledger().count(PointState::kUncertain);
}

// Once the chain is whole, with nothing armed: what has been settled otherwise is not
// meant any more. As with what is left out, they may be more than the journal's ring
// takes at once; false: the next turns go on.
bool Engraving::ReopenUncertain(const EngravingInputs& inputs) {
  if (!inputs.fire_uncertain || !WordIsOf(inputs.grant)) word_of_.clear();
  for (; !word_of_.empty(); word_of_.pop_back()) {
    const std::uint32_t point = word_of_.back();
    if (record_.ledger().state(point) != PointState::kUncertain) continue;
    if (!record_.Reopen(point, word_grant_)) return false;
    idle_runs_ = 0;
  }
  asks_ = asks_ && record_.ledger().count(PointState::kUncertain) > 0;
  return true;
}

// Also when nothing is open any more: it costs the grant, as a fault does, and the answer
// is a newer one. Before any was heard of, there is none that could be spent.
void Engraving::AskOverUncertain(const EngravingInputs& inputs) {
  const bool settled = phase_ == Phase::kPreparing || phase_ == Phase::kWaiting;
  if (!asks_ || asked_ || stopping_ || !settled || inputs.grant.number == 0) return;
  if (WordAnswers(inputs)) return;
  const std::string why = faulted() && !lost_a_line_ ? message_ + "; " : "";
  Explain(Missing::kNothing, why + QuestionOverUncertain(), true);
  asked_ = true;
}

std::string Engraving::QuestionOverUncertain() const {
  std::uint32_t first = 0, last = 0;
  bool found = false;
  for (std::uint32_t point = 0; point < record_.ledger().size(); ++point) {
    if (record_.ledger().state(point) != PointState::kUncertain) continue;
    if (!found) first = point;
    found = true;
    last = point;
  }
  const Vec3 at_mm = job_.machine_from_glass.ToGlass(job_.machine_points_mm[first]);
  return fmt::format(
      "points of which nobody knows whether they were fired: {}, at places {}..{} of the "
      "order (from 0), the first at {:.3f}, {:.3f}, {:.3f} mm of the block; look at the "
      "block; `intaglio resume JOB` leaves them as they are, "
      "`intaglio resume JOB --fire-uncertain` makes them",
      record_.ledger().count(PointState::kUncertain), first, last, at_mm.x(), at_mm.y(),
      at_mm.z());
}

// A question that is open is a reason to wait: only a grant that came after it is the
// answer.
bool Engraving::NothingIsLeft(const EngravingInputs& inputs) const {
  if (WordStands(inputs)) return false;
  const bool granted = inputs.permission_fresh && inputs.permission_granted;
  if (asks_ && (!asked_ || chain_.latched() || !granted)) return false;
  return !record_.ledger().NextOpen(0) || idle_runs_ >= kMaxIdleRuns;
}

}  // namespace intaglio::synchronizer
