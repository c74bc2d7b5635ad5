#include "services/client/event_lines.h"

#include <algorithm>
#include <limits>
#include <ostream>

#include "services/client/exit_codes.h"
#include "services/history/job_names.h"
#include "services/job/files/json_text.h"
#include "services/job/verdict/outcome_counts.h"
#include "services/job/verdict/warnings.h"
#include "services/platform/host/process/patience.h"
#include "services/platform/host/stage/counts_at_end.h"
#include "services/platform/host/times/utc_time.h"

namespace intaglio::client {
namespace {

using namespace std::chrono_literals;

// A job service that was restarted is back by then; without one nothing is settled.
constexpr auto kAlone = 2s;

std::uint32_t Count(std::uint64_t count) {
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(count, std::numeric_limits<std::uint32_t>::max()));
}

}  // namespace

JobEnd EndOf(JobClient& client, const JobView& job) {
  const auto is_settled = [&] { return IsSettled(client.jobs().at(job.uid)); };
  const auto is_served = [&] {
    const auto services = client.services();
    return std::any_of(services.begin(), services.end(), [](const ServiceView& service) {
      return service.role == intaglio_ROLE_JOB_SERVICE;
    });
  };
  host::Patience alone(kAlone);
  for (host::Patience patience(kSettledWithin); !is_settled() && !patience.IsUp();) {
    if (is_served()) alone = host::Patience(kAlone);
    if (alone.IsUp()) break;
    client.Poll(50ms);
  }
  const JobView view = client.jobs().at(job.uid);
  JobEnd end;
  end.counts = AtEnd(view.counts);
  if (!is_settled()) {
    const auto outcome = client.OutcomeOf(job.uid, intaglio_STAGE_ENGRAVE);
    if (outcome && outcome->has_engrave()) end.counts = CountsOf(outcome->engrave());
  }
  end.verdict =
      VerdictOf(view.state == intaglio_JOB_DONE, end.counts, view.warnings, view.makes);
  if (is_settled()) end.verdict.verdict = VerdictFromName(view.verdict);
  return end;
}

int ExitCodeOf(VerdictKind verdict) { return IsGood(verdict) ? kExitGood : kExitNotGood; }

int ExitCodeOf(const JobView& job, const ShopVerdict& verdict) {
  if (job.state == intaglio_JOB_CANCELLED) return kExitCancelled;
  if (job.state != intaglio_JOB_DONE) return kExitMachine;
  return ExitCodeOf(verdict.verdict);
}

JobEvent EventOf(const char* event, const JobView& job, const std::string& id) {
  JobEvent line;
  line.set_event(event);
  line.set_id(id);
  line.set_job(job.number);
  line.set_uid(job.uid);
  line.set_name(job.name);
  line.set_cell(job.cell);
  line.set_state(history::StateName(job.state));
  line.set_pause_reason(history::PauseReasonName(job.pause_reason));
  line.set_attempt(job.attempt);
  line.set_armed(job.armed && !job.ended());
  line.set_message(job.message);
  line.set_result_directory(job.result_directory);
  line.set_alarm(job.alarm);
  line.set_makes(job.makes);
  line.set_awaits_block(job.awaits_block);
  line.set_block_id(job.block_id);
  const JobView::Progress* stage = StageAtWork(job);
  if (stage == nullptr || job.state == intaglio_JOB_QUEUED) return line;
  line.set_stage(NameOf(stage->stage));
  line.set_done(Count(stage->done_count));
  line.set_total(Count(stage->total_count));
  line.set_elapsed_s(stage->elapsed_s);
  if (stage->elapsed_s > 0) {
    line.set_rate(static_cast<double>(stage->done_count) / stage->elapsed_s);
  }
  return line;
}

EventLines::EventLines(std::ostream& out, Clock clock)
    : out_(out), clock_(std::move(clock)) {}

void EventLines::Submitted(const JobView& job, const std::string& id) {
  Write(EventOf("submitted", job, id));
}

void EventLines::Show(const JobView& job, const std::string& id) {
  const auto now = clock_();
  const bool first = !shown_.contains(job.uid);
  Shown& shown = shown_[job.uid];
  const JobEvent line = EventOf("progress", job, id);
  if (job.warnings != shown.warnings) {
    shown.warnings = job.warnings;
    JobEvent event = line;
    event.set_event("warnings");
    AddTo(*event.mutable_warnings(), job.warnings);
    Write(std::move(event));
  }
  const bool state = first || line.state() != shown.state ||
                     line.armed() != shown.armed ||
                     line.pause_reason() != shown.pause_reason;
  const bool message = line.message() != shown.message || line.alarm() != shown.alarm;
  const auto stage =
      static_cast<std::uint32_t>(StageAtWork(job) ? StageAtWork(job)->stage : 0);
  const bool moved =
      stage != shown.stage || line.done() != shown.done || line.total() != shown.total;
  const bool whole = line.total() > 0 && line.done() == line.total();
  const bool due = moved && (whole || now - shown.at >= kPeriod);
  if (!state && !message && !due) return;
  shown = {line.state(), line.message(), line.alarm(), line.pause_reason(), stage,
           line.done(),  line.total(),   line.armed(), job.warnings,        now};
  JobEvent event = line;
  event.set_event(state ? "state" : message ? "message" : "progress");
  Write(std::move(event));
}

void EventLines::Ended(const JobView& job, const JobEnd& end, const std::string& id) {
  JobEvent event = EventOf("ended", job, id);
  event.set_verdict(VerdictName(end.verdict.verdict));
  event.set_planned(Count(end.counts.planned));
  event.set_made(Count(end.counts.made));
  event.set_missed(Count(end.counts.missed));
  event.set_skipped(Count(end.counts.skipped));
  event.set_uncertain(Count(end.counts.uncertain));
  AddTo(*event.mutable_warnings(), job.warnings);
  if (event.message().empty()) event.set_message(end.verdict.reason);
  shown_.erase(job.uid);
  Write(std::move(event));
}

void EventLines::Write(JobEvent event) {
  event.set_time(host::UtcText(clock_()));
  // A name or message that is not UTF-8 came from a file; the line is written without it.
  auto json = JsonTextOf(event, JsonLayout::kOneLine);
  if (!json) {
    event.clear_name();
    event.clear_message();
    event.clear_warnings();
    json = JsonTextOf(event, JsonLayout::kOneLine);
  }
  if (json) out_ << *json << '\n' << std::flush;
}

}  // namespace intaglio::client
