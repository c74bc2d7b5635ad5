#include "services/cell/point_ledger.h"

#include <algorithm>

#include "engrave/core/check.h"

namespace intaglio::cell {
namespace {

PointState StateAfter(formats::PointOutcome outcome) {
  switch (outcome) {
    case formats::PointOutcome::kMade:
      return PointState::kMade;
    case formats::PointOutcome::kMissed:
      return PointState::kMissed;
    case formats::PointOutcome::kSkipped:
      return PointState::kSkipped;
    case formats::PointOutcome::kUncertain:
      return PointState::kUncertain;
    case formats::PointOutcome::kLeftOut:
      return PointState::kLeftOut;
    case formats::PointOutcome::kNone:
      break;
  }
  throw PreconditionError("an armed point cannot be resolved to nothing");
}

bool IsNotFired(PointState state) {
  return state == PointState::kPlanned || state == PointState::kSkipped ||
         state == PointState::kLeftOut;
}

}  // namespace

std::optional<std::uint32_t> PointLedger::NextOpen(std::uint32_t from) const {
  for (std::size_t i = from; i < states_.size(); ++i) {
    if (states_[i] == PointState::kPlanned || states_[i] == PointState::kSkipped) {
      return static_cast<std::uint32_t>(i);
    }
  }
  return std::nullopt;
}

void PointLedger::LeaveOut(std::uint32_t point) {
  const PointState before = states_.at(point);
  Require(before == PointState::kPlanned || before == PointState::kSkipped,
          "point {} is in state {} and cannot be left out", point,
          static_cast<int>(before));
  Move(point, PointState::kLeftOut);
}

void PointLedger::Arm(std::uint32_t point) {
  const PointState before = states_.at(point);
  Require(before == PointState::kPlanned || before == PointState::kSkipped,
          "point {} is in state {} and may not be armed", point,
          static_cast<int>(before));
  Move(point, PointState::kArmed);
}

void PointLedger::Resolve(std::uint32_t point, formats::PointOutcome outcome) {
  Require(states_.at(point) == PointState::kArmed, "point {} is in state {}, not armed",
          point, static_cast<int>(states_[point]));
  Move(point, StateAfter(outcome));
  if (outcome != formats::PointOutcome::kSkipped) {
    ended_below_ = std::max(ended_below_, point + 1);
  }
}

void PointLedger::Reopen(std::uint32_t point) {
  Require(states_.at(point) == PointState::kUncertain,
          "point {} is in state {}, not uncertain", point,
          static_cast<int>(states_[point]));
  reopened_[point] = true;
  Move(point, PointState::kPlanned);
}

void PointLedger::Move(std::uint32_t point, PointState to) {
  if (reopened_[point]) {
    if (IsNotFired(states_[point]))
      --unknown_counts_[static_cast<std::size_t>(states_[point])];
    if (IsNotFired(to)) ++unknown_counts_[static_cast<std::size_t>(to)];
  }
  --counts_[static_cast<std::size_t>(states_[point])];
  states_[point] = to;
  ++counts_[static_cast<std::size_t>(to)];
}

}  // namespace intaglio::cell
