#include "services/replayer/cell/cell_words.h"

#include <algorithm>
#include <utility>

#include "services/platform/bus/error_code.h"
#include "services/platform/bus/samples.h"
#include "services/replayer/recorded_members.h"

namespace intaglio::replayer {
namespace {

// A synchronizer gathers pulses for this time before it reports their results.
constexpr std::uint64_t kGatheredNs = 25'000'000;

constexpr const char* kColumns[] = {"x_mm",    "y_mm",    "z_mm",
                                    "vx_mm_s", "vy_mm_s", "vz_mm_s"};

const char* NameOf(intaglio_TaskState state) {
  switch (state) {
    case intaglio_TASK_ACCEPTED:
      return "TASK_ACCEPTED";
    case intaglio_TASK_RUNNING:
      return "TASK_RUNNING";
    case intaglio_TASK_PAUSED:
      return "TASK_PAUSED";
    case intaglio_TASK_DONE:
      return "TASK_DONE";
    case intaglio_TASK_FAILED:
      return "TASK_FAILED";
  }
  return "";
}

/// Recordings of before had the name itself for a code, today's have the enumerator's:
/// ERROR_LINK_LOST for link_lost, and ERROR_NONE for none.
std::string ErrorNameOf(const std::string& recorded) {
  for (int code = intaglio_ERROR_NONE; code <= intaglio_ERROR_CANCELLED; ++code) {
    std::string name = bus::NameOf(static_cast<intaglio_ErrorCode>(code));
    std::string enumerator = name.empty() ? "NONE" : name;
    for (char& letter : enumerator) {
      if (letter >= 'a' && letter <= 'z') letter = static_cast<char>(letter - 'a' + 'A');
    }
    if (recorded == "ERROR_" + enumerator) return name;
  }
  return recorded;
}

template <typename Sequence, typename Column>
void Copy(const Sequence& sequence, Column& column) {
  const auto view = bus::View(sequence);
  column.assign(view.begin(), view.end());
}

void Append(const auto& from, auto& to) { to.insert(to.end(), from.begin(), from.end()); }

}  // namespace

std::optional<SegmentWords> ReadSegments(const recording::Value& value) {
  SegmentWords words;
  Members members(value);
  members.Get("job_uid", words.job_uid);
  members.Get("run", words.run);
  members.Get("sequence_number", words.number);
  members.Get("start_tick", words.start_tick);
  members.Get("abort", words.abort);
  members.Get("last", words.last);
  for (int i = 0; i < 6; ++i) members.Get(kColumns[i], words.columns[i]);
  members.Get("duration_subticks", words.duration_subticks);
  members.Get("pulse", words.pulse);
  const std::size_t size = words.duration_subticks.size();
  bool even = words.pulse.size() == size;
  for (const auto& column : words.columns) even = even && column.size() == size;
  return members.good() && even ? std::optional(std::move(words)) : std::nullopt;
}

std::optional<PulseWords> ReadPulses(const recording::Value& value) {
  PulseWords words;
  Members members(value);
  members.Get("job_uid", words.job_uid);
  members.Get("tick", words.tick);
  members.Get("point", words.point);
  members.Get("outcome", words.outcome);
  members.Get("reason", words.reason);
  const std::size_t size = words.tick.size();
  const bool even = words.point.size() == size && words.outcome.size() == size &&
                    words.reason.size() == size;
  return members.good() && even ? std::optional(std::move(words)) : std::nullopt;
}

std::optional<StatusWords> ReadStatus(const recording::Value& value) {
  StatusWords words;
  Members members(value);
  members.Get("job_uid", words.job_uid);
  members.Get("attempt", words.attempt);
  members.Get("stage", words.stage);
  members.Get("state", words.state);
  members.Get("error_code", words.error_code);
  words.error_code = ErrorNameOf(words.error_code);
  members.Get("message", words.message);
  members.Get("done_count", words.done_count);
  members.Get("total_count", words.total_count);
  members.Get("estimate_ticks", words.estimate_ticks);
  std::vector<std::uint8_t> outcome;
  members.Get("outcome", outcome);
  words.outcome.assign(outcome.begin(), outcome.end());
  return members.good() ? std::optional(std::move(words)) : std::nullopt;
}

SegmentWords WordsOf(const intaglio_MotionSegmentBatch& sample) {
  SegmentWords words;
  words.job_uid = bus::View(sample.job_uid);
  words.run = sample.run;
  words.number = sample.sequence_number;
  words.start_tick = sample.start_tick;
  words.abort = sample.abort;
  words.last = sample.last;
  Copy(sample.x_mm, words.columns[0]);
  Copy(sample.y_mm, words.columns[1]);
  Copy(sample.z_mm, words.columns[2]);
  Copy(sample.vx_mm_s, words.columns[3]);
  Copy(sample.vy_mm_s, words.columns[4]);
  Copy(sample.vz_mm_s, words.columns[5]);
  Copy(sample.duration_subticks, words.duration_subticks);
  Copy(sample.pulse, words.pulse);
  return words;
}

PulseWords WordsOf(const intaglio_PulseEventBatch& sample) {
  PulseWords words;
  words.job_uid = bus::View(sample.job_uid);
  Copy(sample.tick, words.tick);
  Copy(sample.point, words.point);
  Copy(sample.outcome, words.outcome);
  Copy(sample.reason, words.reason);
  return words;
}

StatusWords WordsOf(const intaglio_TaskStatus& sample) {
  StatusWords words;
  words.job_uid = bus::View(sample.job_uid);
  words.attempt = sample.attempt;
  words.stage = sample.stage == intaglio_STAGE_ENGRAVE ? "STAGE_ENGRAVE" : "";
  words.state = NameOf(sample.state);
  words.error_code = bus::NameOf(sample.error_code);
  words.message = bus::View(sample.message);
  words.done_count = sample.done_count;
  words.total_count = sample.total_count;
  words.estimate_ticks = sample.estimate_ticks;
  const auto outcome = bus::View(sample.outcome);
  words.outcome.assign(outcome.begin(), outcome.end());
  return words;
}

bool CellRun::undisturbed() const {
  return whole && !aborted &&
         std::all_of(pulses.begin(), pulses.end(),
                     [](const RunPulse& one) { return one.fired(); });
}

bool CellWords::disturbed() const {
  return given_up_count > 0 ||
         !std::all_of(runs.begin(), runs.end(),
                      [](const CellRun& run) { return run.undisturbed(); });
}

std::size_t CellWords::broken_count() const {
  return static_cast<std::size_t>(std::count_if(
      runs.begin(), runs.end(), [](const CellRun& run) { return run.aborted; }));
}

bool CellListener::Take(const SegmentWords& words, std::uint64_t at_ns) {
  if (words.job_uid != job_uid_) return false;
  auto& runs = words_.runs;
  if (words.abort) {
    if (!runs.empty() && runs.back().number <= words.run && runs.back().ended_ns == 0) {
      runs.back().aborted = true;
      runs.back().ended_ns = at_ns;
    }
    return false;
  }
  const bool begins = runs.empty() || words.run > runs.back().number;
  if (begins) {
    runs.emplace_back();
    runs.back().number = words.run;
    runs.back().start_tick = words.start_tick;
    runs.back().begun_ns = at_ns;
  }
  CellRun& run = runs.back();
  for (int i = 0; i < 6; ++i) Append(words.columns[i], run.columns[i]);
  Append(words.duration_subticks, run.duration_subticks);
  Append(words.pulse, run.pulse);
  run.whole = run.whole || words.last;
  return begins;
}

void CellListener::Take(const PulseWords& words, std::uint64_t at_ns) {
  if (words.job_uid != job_uid_) return;
  for (std::size_t i = 0; i < words.tick.size(); ++i) {
    const RunPulse pulse{words.tick[i], words.point[i], words.outcome[i],
                         words.reason[i]};
    if (pulse.reason == intaglio_SKIP_LEFT_OUT) {
      words_.left_out.push_back(pulse.point);
    } else {
      pulses_.push_back({pulse, at_ns});
    }
    if (pulse.fired()) ++fired_count_;
  }
}

void CellListener::Take(const StatusWords& words) {
  if (words.job_uid != job_uid_ || words.stage != "STAGE_ENGRAVE") return;
  auto& states = words_.states;
  if (states.empty() || states.back() != words.state) states.push_back(words.state);
  message_ = words.message;
  if (words.ended()) words_.end = words;
}

// What is taken back of one run may lie at ticks of the next one. And those of a laser
// that was switched off in between begin again: a run that came later is not meant.
bool CellListener::MayBeOf(const CellRun& run, const SaidPulse& said) const {
  if (run.start_tick > said.pulse.tick || said.at_ns < run.begun_ns) return false;
  return said.pulse.fired() || said.at_ns > run.begun_ns + kGatheredNs;
}

CellWords CellListener::Words() const {
  CellWords words = words_;
  auto& runs = words.runs;
  for (const SaidPulse& said : pulses_) {
    // The newest run that begins before it.
    auto run = std::find_if(runs.rbegin(), runs.rend(), [&](const CellRun& candidate) {
      return MayBeOf(candidate, said);
    });
    if (run != runs.rend()) run->pulses.push_back(said.pulse);
  }
  for (CellRun& run : runs) {
    std::stable_sort(
        run.pulses.begin(), run.pulses.end(),
        [](const RunPulse& a, const RunPulse& b) { return a.tick < b.tick; });
    const auto fired = std::find_if(run.pulses.rbegin(), run.pulses.rend(),
                                    [](const RunPulse& pulse) { return pulse.fired(); });
    const bool uncertain = std::any_of(
        run.pulses.begin(), run.pulses.end(),
        [](const RunPulse& pulse) { return pulse.outcome == intaglio_PULSE_UNCERTAIN; });
    words.uncertain_run =
        uncertain && words.uncertain_run == 0 ? run.number : words.uncertain_run;
    run.pulses.erase(fired.base(), run.pulses.end());
  }
  words.given_up_count = std::erase_if(
      runs, [](const CellRun& run) { return run.aborted && run.pulses.empty(); });
  return words;
}

}  // namespace intaglio::replayer
