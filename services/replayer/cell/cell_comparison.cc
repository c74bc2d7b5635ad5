#include "services/replayer/cell/cell_comparison.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <tuple>
#include <vector>

#include "engrave/core/counted.h"
#include "services/platform/bus/topics.h"

namespace intaglio::replayer {
namespace {

constexpr const char* kColumns[] = {"x_mm",    "y_mm",    "z_mm",
                                    "vx_mm_s", "vy_mm_s", "vz_mm_s"};

SampleDifference Difference(const char* topic, const std::string& member,
                            std::string then, std::string now) {
  SampleDifference difference;
  difference.set_topic(topic);
  difference.set_member(member);
  difference.set_then(std::move(then));
  difference.set_now(std::move(now));
  return difference;
}

template <typename T>
std::optional<SampleDifference> Differs(const char* topic, const char* member,
                                        const T& then, const T& now) {
  if constexpr (std::is_same_v<T, double>) {
    if (std::bit_cast<std::uint64_t>(then) == std::bit_cast<std::uint64_t>(now))
      return std::nullopt;
  } else if (then == now) {
    return std::nullopt;
  }
  return Difference(topic, member, fmt::format("{}", then), fmt::format("{}", now));
}

std::optional<SampleDifference> CompareSegments(const CellRun& then, const CellRun& now,
                                                TaskComparison& counts) {
  const char* topic = bus::kMotionSegmentBatch.name;
  const std::size_t size =
      std::min(then.duration_subticks.size(), now.duration_subticks.size());
  std::optional<SampleDifference> found;
  std::size_t i = 0;
  for (; i < size && !found; ++i) {
    for (int column = 0; column < 6 && !found; ++column) {
      found = Differs(topic, kColumns[column], then.columns[column][i],
                      now.columns[column][i]);
    }
    if (!found)
      found = Differs(topic, "duration_subticks", then.duration_subticks[i],
                      now.duration_subticks[i]);
    if (!found) found = Differs(topic, "pulse", then.pulse[i], now.pulse[i]);
    if (found) break;
  }
  counts.set_segment_count(counts.segment_count() + i);
  if (!found && then.undisturbed()) {
    found = Differs(topic, "segments", then.duration_subticks.size(),
                    now.duration_subticks.size());
    if (!found) found = Differs(topic, "last", then.whole, now.whole);
  }
  if (found) found->set_index(i);
  return found;
}

std::optional<SampleDifference> ComparePulses(const CellRun& then, const CellRun& now,
                                              TaskComparison& counts) {
  const char* topic = bus::kPulseEventBatch.name;
  const std::size_t then_count = then.pulses.size(), now_count = now.pulses.size();
  const std::size_t size = std::min(then_count, now_count);
  std::optional<SampleDifference> found;
  std::size_t i = 0;
  for (; i < size; ++i) {
    const RunPulse &a = then.pulses[i], &b = now.pulses[i];
    found = Differs(topic, "point", a.point, b.point);
    if (!found && !then.respeeded)
      found = Differs(topic, "tick", a.tick - then.start_tick, b.tick - now.start_tick);
    if (!found) found = Differs(topic, "outcome", a.outcome, b.outcome);
    if (!found && then.undisturbed())
      found = Differs(topic, "reason", a.reason, b.reason);
    if (found) break;
  }
  counts.set_pulse_count(counts.pulse_count() + i);
  if (!found) found = Differs(topic, "points", then_count, now_count);
  if (found) {
    found->set_index(i);
    if (i < then_count) found->set_point(then.pulses[i].point);
  }
  return found;
}

std::optional<SampleDifference> CompareRun(const CellRun* then, const CellRun* now,
                                           TaskComparison& counts) {
  std::optional<SampleDifference> found;
  const auto messages = [](const CellRun* run) {
    return run == nullptr ? std::string("none") : Counted(run->pulses.size(), "point");
  };
  if (then == nullptr || now == nullptr) {
    found =
        Difference(bus::kMotionSegmentBatch.name, "run", messages(then), messages(now));
  } else {
    if (!then->respeeded) found = CompareSegments(*then, *now, counts);
    if (!found) found = ComparePulses(*then, *now, counts);
    counts.set_run_count(counts.run_count() + 1);
  }
  if (found) found->set_run(then != nullptr ? then->number : now->number);
  return found;
}

EngraveOutcome OutcomeOf(const StatusMessage& messages, bool disturbed) {
  StageOutcome stage;
  if (!stage.ParseFromString(messages.outcome)) return {};
  EngraveOutcome outcome = stage.engrave();
  outcome.clear_first_tick();
  outcome.clear_last_tick();
  outcome.clear_controller_pulse_count();
  outcome.clear_run_count();
  // A forecast, which is computed aside and may come too late.
  outcome.clear_predicted_rms_error_um();
  outcome.clear_predicted_max_error_um();
  outcome.clear_wrong_mechanics_max_error_um();
  // Recordings from before overrides above 100 %.
  if (outcome.max_speed_percent() == 0)
    outcome.set_max_speed_percent(std::max(100U, outcome.min_speed_percent()));
  if (disturbed) {
    outcome.clear_used_ticks();
    outcome.clear_settled_by_memory_count();
    outcome.clear_speed_changes();
    outcome.clear_min_speed_percent();
    outcome.clear_max_speed_percent();
  }
  return outcome;
}

/// A pause without a trace in runs or pulses is the host's: it did not receive the
/// machine for longer than a lease.
std::vector<std::string> WithoutPauses(const std::vector<std::string>& states) {
  std::vector<std::string> left;
  for (const std::string& state : states) {
    if (state == "TASK_PAUSED" || (!left.empty() && left.back() == state)) continue;
    left.push_back(state);
  }
  return left;
}

/// A state is replaced by the next one before a reader on a busy host has received it: so
/// one of both may lack some that the other has, in its order.
std::optional<SampleDifference> CompareStates(const char* topic, const CellMessages& then,
                                              const CellMessages& now) {
  const auto a = WithoutPauses(then.states), b = WithoutPauses(now.states);
  const auto& [fewer, more] = a.size() < b.size() ? std::tie(a, b) : std::tie(b, a);
  std::size_t found = 0;
  for (const std::string& state : more)
    found += found < fewer.size() && fewer[found] == state ? 1 : 0;
  if (found == fewer.size()) return std::nullopt;
  return Difference(topic, "states", fmt::format("{}", fmt::join(a, " ")),
                    fmt::format("{}", fmt::join(b, " ")));
}

std::optional<SampleDifference> CompareEnds(const CellMessages& then,
                                            const CellMessages& now) {
  const char* topic = bus::kTaskStatus.name;
  StatusMessage none;
  none.state = "none";
  const StatusMessage &a = *then.end, &b = now.end ? *now.end : none;
  auto found = Differs(topic, "state", a.state, b.state);
  if (!found) found = Differs(topic, "error_code", a.error_code, b.error_code);
  if (!found) found = Differs(topic, "message", a.message, b.message);
  if (!found) found = Differs(topic, "done_count", a.done_count, b.done_count);
  if (!found) found = Differs(topic, "total_count", a.total_count, b.total_count);
  if (!found)
    found = Differs(topic, "estimate_ticks", a.estimate_ticks, b.estimate_ticks);
  const bool disturbed =
      then.disturbed() || std::any_of(then.runs.begin(), then.runs.end(),
                                      [](const CellRun& run) { return run.respeeded; });
  if (!found)
    found = Differs(topic, "outcome", OutcomeOf(a, disturbed).ShortDebugString(),
                    OutcomeOf(b, disturbed).ShortDebugString());
  // Which states a host has time to report depends on chance once it is disturbed.
  if (!found && !disturbed) found = CompareStates(topic, then, now);
  return found;
}

}  // namespace

void KeepRunsBefore(std::size_t run, CellMessages& then, CellMessages& now) {
  for (CellMessages* messages : {&then, &now}) {
    if (messages->runs.size() > run) messages->runs.resize(run);
    messages->end.reset();
  }
}

std::optional<SampleDifference> CompareCells(const CellMessages& then,
                                             const CellMessages& now,
                                             TaskComparison& counts) {
  const std::size_t runs =
      then.end ? std::max(then.runs.size(), now.runs.size()) : then.runs.size();
  for (std::size_t k = 0; k < runs; ++k) {
    auto found = CompareRun(k < then.runs.size() ? &then.runs[k] : nullptr,
                            k < now.runs.size() ? &now.runs[k] : nullptr, counts);
    if (found) return found;
  }
  if (!then.end) return std::nullopt;
  if (auto found = Differs(bus::kPulseEventBatch.name, "left_out",
                           fmt::format("{}", fmt::join(then.left_out, " ")),
                           fmt::format("{}", fmt::join(now.left_out, " "))))
    return found;
  return CompareEnds(then, now);
}

}  // namespace intaglio::replayer
