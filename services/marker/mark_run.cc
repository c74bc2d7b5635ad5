#include "services/marker/mark_run.h"

#include <algorithm>
#include <utility>

#include "engrave/core/check.h"
#include "engrave/core/try.h"

namespace intaglio::marker {

using drivers::MarkFate;
using formats::PointOutcome;

void MarkRun::TakeUp(const std::vector<ArmedMark>& armed) {
  for (const ArmedMark& one : armed) armed_[one.mark] = {one.run, 0, true, 0};
}

// It remembers the newest marks, and those of a run come in rising order: behind one that
// it knows, one that it does not know never came.
bool MarkRun::NeverCame(const drivers::MarkEvent& event) const {
  const auto known = known_.find(event.run);
  return event.fate == MarkFate::kUncertain && known != known_.end() &&
         known->second < event.mark;
}

bool MarkRun::Receive(const drivers::MarkEvent& event) {
  if (questions_ > 0 && event.fate != MarkFate::kUncertain) {
    std::uint32_t& newest = known_[event.run];
    newest = std::max(newest, event.mark);
  }
  const auto found = armed_.find(event.mark);
  if (found == armed_.end() || found->second.run != event.run || !found->second.handed)
    return false;
  PointOutcome outcome = PointOutcome::kNone;
  formats::MarkSkip why = formats::MarkSkip::kNone;
  switch (event.fate) {
    case MarkFate::kBegun:
      return false;
    case MarkFate::kDone:
      outcome = PointOutcome::kMade;
      break;
    case MarkFate::kNotBegun:
      outcome = PointOutcome::kSkipped;
      break;
    case MarkFate::kNoPrintMark:
      outcome = PointOutcome::kLeftOut;
      why = formats::MarkSkip::kNoPrintMark;
      break;
    // A part of a mark is there: to make it again is a person's choice.
    case MarkFate::kBroken:
    case MarkFate::kUncertain:
      outcome = NeverCame(event) ? PointOutcome::kSkipped : PointOutcome::kUncertain;
      break;
  }
  if (questions_ > 0 && outcome == PointOutcome::kMade) ++by_memory_;
  armed_.erase(found);
  record_.Resolve(event.mark, outcome, why);
  return outcome == PointOutcome::kUncertain;
}

bool MarkRun::LeaveOutBegunRepeats() {
  if (!eye_) return true;
  const cell::PointLedger& ledger = record_.ledger();
  const auto repeat_of = [&](std::uint32_t mark) {
    return drivers::RepeatOf(set_.marks[mark].web_mm, eye_->pitch_mm);
  };
  // A job may have millions of marks.
  std::vector<bool> begun;
  for (std::uint32_t mark = 0; mark < ledger.size(); ++mark) {
    const std::uint32_t repeat = repeat_of(mark);
    if (repeat >= begun.size()) begun.resize(repeat + 1);
    const cell::PointState state = ledger.state(mark);
    if (state != cell::PointState::kPlanned && state != cell::PointState::kSkipped)
      begun[repeat] = true;
  }
  eye_->first_repeat = ~0u;
  for (auto open = ledger.NextOpen(0); open; open = ledger.NextOpen(*open + 1)) {
    const std::uint32_t repeat = repeat_of(*open);
    if (!begun[repeat]) {
      eye_->first_repeat = std::min(eye_->first_repeat, repeat);
    } else if (!record_.LeaveOut(*open, formats::MarkSkip::kRepeatBegun)) {
      return false;
    }
  }
  return true;
}

Status MarkRun::Begin() {
  Require(armed_.empty(), "a run begins with {} marks armed", armed_.size());
  const std::uint32_t run = record_.BeginRun(driver_.state().newest_run);
  INTAGLIO_TRY(driver_.UseEye(eye_));
  INTAGLIO_TRY(driver_.Begin(run, set_.pens));
  ++count_;
  session_ = driver_.state().session;
  next_ = next_handed_ = 0;
  finished_ = false;
  questions_ = 0;
  asked_session_ = 0;
  return {};
}

Status MarkRun::Turn() {
  ArmMore();
  record_.FlushAppended();
  INTAGLIO_TRY(HandOver());
  const bool all_handed = armed_.lower_bound(next_handed_) == armed_.end();
  if (finished_ || !all_handed || record_.ledger().NextOpen(next_)) return {};
  INTAGLIO_TRY(driver_.Finish());
  finished_ = true;
  return {};
}

void MarkRun::ArmMore() {
  if (finished_) return;
  const bool remembers = driver_.state().remembers_marks;
  const std::size_t min_armed = remembers ? kMinArmed : kMaxArmedUnremembered;
  const std::size_t limit = remembers ? kMaxArmed : kMaxArmedUnremembered;
  double ahead_s = 0;
  for (const auto& [mark, armed] : armed_) ahead_s += armed.time_s;
  while (armed_.size() < limit && (armed_.size() < min_armed || ahead_s < kArmedAheadS)) {
    const auto open = record_.ledger().NextOpen(next_);
    if (!open || !record_.Arm(*open)) return;
    const double time_s = SecondsOf(*open);
    armed_[*open] = {record_.run(), record_.appended(), false, time_s};
    ahead_s += time_s;
    next_ = *open + 1;
  }
}

/// At least.
double MarkRun::SecondsOf(std::uint32_t mark) const {
  constexpr double kJumpS = 1e-3;
  const mark::Mark& one = set_.marks[mark];
  const mark::Pen& pen = set_.pens[one.pen];
  return kJumpS + pen.pass_count * mark::LengthOf(one) / pen.speed_mm_s;
}

Status MarkRun::HandOver() {
  for (auto next = armed_.lower_bound(next_handed_);
       next != armed_.end() && next->second.journaled_at <= record_.durable() &&
       driver_.Room() > 0;
       ++next) {
    const auto sent = driver_.Append({next->first, set_.marks[next->first]});
    if (!sent) return sent;
    next->second.handed = true;
    next_handed_ = next->first + 1;
  }
  return {};
}

void MarkRun::End() {
  for (auto next = armed_.begin(); next != armed_.end();) {
    if (next->second.handed) {
      ++next;
      continue;
    }
    record_.Resolve(next->first, PointOutcome::kSkipped);
    next = armed_.erase(next);
  }
  finished_ = true;
  questions_ = 0;
  asked_session_ = 0;
}

std::uint64_t MarkRun::Settle(std::chrono::nanoseconds now) {
  const drivers::MarkDeviceState& state = driver_.state();
  if (asked_session_ != state.session) {
    // Its own events come first, if there are any.
    asked_session_ = state.session;
    questions_ = 0;
    ask_again_at_ = now + kAnswerTime / 4;
  }
  if (now < ask_again_at_) return 0;
  const bool could_answer = state.number >= asked_at_status_ + kAnswerStatuses ||
                            now >= ask_again_at_ + 9 * kAnswerTime;
  if (questions_ > 0 && !could_answer) return 0;
  const bool remembers = state.remembers_marks && !state.power_up.empty() &&
                         PowerUpNumber(state.power_up) == record_.power_up();
  if (!remembers || questions_ >= kMaxQuestions) return GiveUp();
  ++questions_;
  known_.clear();
  ask_again_at_ = now + kAnswerTime;
  asked_at_status_ = state.number;
  Ask();
  return 0;
}

// Row by row of numbers without a gap. What the driver refuses is asked again.
void MarkRun::Ask() {
  for (auto next = armed_.begin(); next != armed_.end();) {
    const auto first = next;
    std::uint32_t count = 0;
    while (next != armed_.end() && next->first == first->first + count &&
           next->second.run == first->second.run) {
      ++count;
      ++next;
    }
    // With the one before, which it may know.
    const std::uint32_t before = first->first > 0 ? 1 : 0;
    (void)driver_.RequestPast(first->second.run, first->first - before, count + before);
  }
}

std::uint64_t MarkRun::GiveUp() {
  const std::uint64_t count = armed_.size();
  for (const auto& [mark, armed] : std::exchange(armed_, {}))
    record_.Resolve(mark, PointOutcome::kUncertain);
  return count;
}

}  // namespace intaglio::marker
