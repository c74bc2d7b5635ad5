#include "services/replayer/cell/cell_messages.h"

#include <algorithm>
#include <utility>

#include "services/platform/bus/error_code.h"
#include "services/platform/bus/samples.h"
#include "services/replayer/recorded_members.h"

namespace intaglio::replayer {
namespace {

// A synchronizer gathers pulses for this time before it reports their results.
constexpr std::uint64_t kGatheredNs = 25'000'000;

constexpr const char* kSampleColumns[] = {"x_mm",    "y_mm",    "z_mm",
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

std::optional<SegmentMessages> ReadSegments(const recording::Value& value) {
  SegmentMessages messages;
  Members members(value);
  members.Get("job_uid", messages.job_uid);
  members.Get("run", messages.run);
  members.Get("sequence_number", messages.number);
  members.Get("start_tick", messages.start_tick);
  members.Get("abort", messages.abort);
  members.Get("last", messages.last);
  for (int i = 0; i < 6; ++i) members.Get(kSampleColumns[i], messages.columns[i]);
  members.Get("duration_subticks", messages.duration_subticks);
  members.Get("pulse", messages.pulse);
  const std::size_t size = messages.duration_subticks.size();
  bool even = messages.pulse.size() == size;
  for (const auto& column : messages.columns) even = even && column.size() == size;
  return members.good() && even ? std::optional(std::move(messages)) : std::nullopt;
}

std::optional<PulseMessages> ReadPulses(const recording::Value& value) {
  PulseMessages messages;
  Members members(value);
  members.Get("job_uid", messages.job_uid);
  members.Get("sequence_number", messages.number);
  members.Get("tick", messages.tick);
  members.Get("point", messages.point);
  members.Get("outcome", messages.outcome);
  members.Get("reason", messages.reason);
  const std::size_t size = messages.tick.size();
  const bool even = messages.point.size() == size && messages.outcome.size() == size &&
                    messages.reason.size() == size;
  return members.good() && even ? std::optional(std::move(messages)) : std::nullopt;
}

std::optional<StatusMessage> ReadStatus(const recording::Value& value) {
  StatusMessage messages;
  Members members(value);
  members.Get("job_uid", messages.job_uid);
  members.Get("attempt", messages.attempt);
  members.Get("stage", messages.stage);
  members.Get("state", messages.state);
  members.Get("error_code", messages.error_code);
  messages.error_code = ErrorNameOf(messages.error_code);
  members.Get("message", messages.message);
  members.Get("done_count", messages.done_count);
  members.Get("total_count", messages.total_count);
  members.Get("estimate_ticks", messages.estimate_ticks);
  std::vector<std::uint8_t> outcome;
  members.Get("outcome", outcome);
  messages.outcome.assign(outcome.begin(), outcome.end());
  return members.good() ? std::optional(std::move(messages)) : std::nullopt;
}

SegmentMessages MessageOf(const intaglio_MotionSegmentBatch& sample) {
  SegmentMessages messages;
  messages.job_uid = bus::View(sample.job_uid);
  messages.run = sample.run;
  messages.number = sample.sequence_number;
  messages.start_tick = sample.start_tick;
  messages.abort = sample.abort;
  messages.last = sample.last;
  Copy(sample.x_mm, messages.columns[0]);
  Copy(sample.y_mm, messages.columns[1]);
  Copy(sample.z_mm, messages.columns[2]);
  Copy(sample.vx_mm_s, messages.columns[3]);
  Copy(sample.vy_mm_s, messages.columns[4]);
  Copy(sample.vz_mm_s, messages.columns[5]);
  Copy(sample.duration_subticks, messages.duration_subticks);
  Copy(sample.pulse, messages.pulse);
  return messages;
}

PulseMessages MessageOf(const intaglio_PulseEventBatch& sample) {
  PulseMessages messages;
  messages.job_uid = bus::View(sample.job_uid);
  messages.number = sample.sequence_number;
  Copy(sample.tick, messages.tick);
  Copy(sample.point, messages.point);
  Copy(sample.outcome, messages.outcome);
  Copy(sample.reason, messages.reason);
  return messages;
}

StatusMessage MessageOf(const intaglio_TaskStatus& sample) {
  StatusMessage messages;
  messages.job_uid = bus::View(sample.job_uid);
  messages.attempt = sample.attempt;
  messages.stage = sample.stage == intaglio_STAGE_ENGRAVE ? "STAGE_ENGRAVE" : "";
  messages.state = NameOf(sample.state);
  messages.error_code = bus::NameOf(sample.error_code);
  messages.message = bus::View(sample.message);
  messages.done_count = sample.done_count;
  messages.total_count = sample.total_count;
  messages.estimate_ticks = sample.estimate_ticks;
  const auto outcome = bus::View(sample.outcome);
  messages.outcome.assign(outcome.begin(), outcome.end());
  return messages;
}

bool CellRun::undisturbed() const {
  return whole && !aborted && !open &&
         std::all_of(pulses.begin(), pulses.end(),
                     [](const RunPulse& one) { return one.fired(); });
}

bool CellMessages::disturbed() const {
  return given_up_count > 0 ||
         !std::all_of(runs.begin(), runs.end(),
                      [](const CellRun& run) { return run.undisturbed(); });
}

std::size_t CellMessages::broken_count() const {
  return static_cast<std::size_t>(std::count_if(
      runs.begin(), runs.end(), [](const CellRun& run) { return run.aborted; }));
}

bool CellListener::Receive(const SegmentMessages& messages, std::uint64_t at_ns) {
  if (messages.job_uid != job_uid_) return false;
  auto& runs = messages_.runs;
  if (messages.abort) {
    if (!runs.empty() && runs.back().number <= messages.run &&
        runs.back().ended_ns == 0) {
      runs.back().aborted = true;
      runs.back().ended_ns = at_ns;
    }
    return false;
  }
  const bool begins = runs.empty() || messages.run > runs.back().number;
  if (begins) {
    // The end of the run before it: a batch with its last segment, or an abort.
    if (!runs.empty() && !runs.back().whole && !runs.back().aborted)
      NoteGap(runs.back().number);
    runs.emplace_back();
    runs.back().number = messages.run;
    runs.back().start_tick = messages.start_tick;
    runs.back().begun_ns = at_ns;
  }
  CellRun& run = runs.back();
  if (messages.number > run.next_number) NoteGap(run.number);
  run.next_number = messages.number + 1;
  for (int i = 0; i < 6; ++i) Append(messages.columns[i], run.columns[i]);
  Append(messages.duration_subticks, run.duration_subticks);
  Append(messages.pulse, run.pulse);
  run.whole = run.whole || messages.last;
  return begins;
}

void CellListener::NoteGap(std::uint32_t run) {
  std::uint32_t& first = messages_.incomplete_run;
  first = first == 0 ? run : std::min(first, run);
}

/// The newest run that had begun, else the first one.
std::uint32_t CellListener::RunAt(std::uint64_t at_ns) const {
  const auto& runs = messages_.runs;
  const auto run = std::find_if(runs.rbegin(), runs.rend(), [&](const CellRun& one) {
    return one.begun_ns <= at_ns;
  });
  if (run != runs.rend()) return run->number;
  return runs.empty() ? 1 : runs.front().number;
}

void CellListener::Receive(const PulseMessages& messages, std::uint64_t at_ns) {
  if (messages.job_uid != job_uid_) return;
  if (messages.number > next_pulses_) NoteGap(RunAt(at_ns));
  next_pulses_ = messages.number + 1;
  for (std::size_t i = 0; i < messages.tick.size(); ++i) {
    const RunPulse pulse{messages.tick[i], messages.point[i], messages.outcome[i],
                         messages.reason[i]};
    if (pulse.reason == intaglio_SKIP_LEFT_OUT) {
      messages_.left_out.push_back(pulse.point);
    } else {
      pulses_.push_back({pulse, at_ns});
    }
    if (pulse.fired()) ++fired_count_;
  }
}

void CellListener::Receive(const StatusMessage& messages) {
  if (messages.job_uid != job_uid_ || messages.stage != "STAGE_ENGRAVE") return;
  auto& states = messages_.states;
  if (states.empty() || states.back() != messages.state) states.push_back(messages.state);
  message_ = messages.message;
  if (messages.ended()) messages_.end = messages;
}

// What is taken back of one run may lie at ticks of the next one. And those of a laser
// that was switched off in between begin again: a run that came later is not meant.
bool CellListener::MayBeOf(const CellRun& run, const ReportedPulse& sent) const {
  if (run.start_tick > sent.pulse.tick || sent.at_ns < run.begun_ns) return false;
  return sent.pulse.fired() || sent.at_ns > run.begun_ns + kGatheredNs;
}

CellMessages CellListener::Messages() const {
  CellMessages messages = messages_;
  auto& runs = messages.runs;
  for (const ReportedPulse& sent : pulses_) {
    // The newest run that begins before it.
    auto run = std::find_if(runs.rbegin(), runs.rend(), [&](const CellRun& candidate) {
      return MayBeOf(candidate, sent);
    });
    if (run != runs.rend()) run->pulses.push_back(sent.pulse);
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
    messages.uncertain_run =
        uncertain && messages.uncertain_run == 0 ? run.number : messages.uncertain_run;
    run.pulses.erase(fired.base(), run.pulses.end());
  }
  messages.given_up_count = std::erase_if(
      runs, [](const CellRun& run) { return run.aborted && run.pulses.empty(); });
  return messages;
}

}  // namespace intaglio::replayer
