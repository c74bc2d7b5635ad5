#include "services/cli/batch/batch_run.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <iostream>

#include "services/cli/terminal/interrupt.h"
#include "services/client/figure_text.h"
#include "services/history/job_names.h"
#include "services/job/verdict/warnings.h"
#include "services/platform/host/times/utc_time.h"

namespace intaglio::cli {
namespace {

using namespace std::chrono_literals;

constexpr auto kSubmitTime = 15s;
constexpr auto kCancelTime = 5s;
// A job service that was restarted is back by then.
constexpr auto kServiceTime = 60s;

double Seconds(std::chrono::steady_clock::duration time) {
  return std::chrono::duration<double>(time).count();
}

/// Its block is in the machine, and may have cracks.
bool IsEngraved(const client::JobView& job) {
  return job.state == intaglio_JOB_ENGRAVING || job.state == intaglio_JOB_PAUSED;
}

bool IsGood(JobResult result) {
  return result == JobResult::kGood || result == JobResult::kGoodWithWarnings;
}

void SetCounts(const client::JobEnd& end, BatchJobResult& result) {
  const auto count = [](std::uint64_t n) { return static_cast<std::uint32_t>(n); };
  result.set_verdict(VerdictName(end.verdict.verdict));
  result.set_planned(count(end.counts.planned));
  result.set_made(count(end.counts.made));
  result.set_missed(count(end.counts.missed));
  result.set_skipped(count(end.counts.skipped));
  result.set_uncertain(count(end.counts.uncertain));
}

JobResult WhatBecameOf(const client::JobView& job, VerdictKind verdict) {
  switch (job.state) {
    case intaglio_JOB_DONE:
      if (verdict == VerdictKind::kGoodWithWarnings) return JobResult::kGoodWithWarnings;
      return verdict == VerdictKind::kGood ? JobResult::kGood : JobResult::kNotGood;
    case intaglio_JOB_FAILED:
      return JobResult::kFailed;
    case intaglio_JOB_CANCELLED:
      return JobResult::kCancelled;
    default:
      return JobResult::kNotMade;
  }
}

std::vector<PlannedJob> PlannedOf(const std::vector<BatchJob>& jobs) {
  std::vector<PlannedJob> planned;
  for (const BatchJob& job : jobs) planned.push_back(job.planned);
  return planned;
}

}  // namespace

BatchRun::BatchRun(client::JobClient& client, std::vector<BatchJob> jobs,
                   BatchRunOptions options, client::EventLines* events)
    : client_(client),
      jobs_(std::move(jobs)),
      options_(std::move(options)),
      events_(events),
      plan_(PlannedOf(jobs_), options_.parallel),
      ends_(jobs_.size(), JobResult::kNotMade),
      bar_(std::cerr, isatty(STDERR_FILENO) != 0) {
  results_.set_file(options_.file);
  for (const BatchJob& job : jobs_) {
    BatchJobResult& result = *results_.add_jobs();
    result.set_id(job.id);
    result.set_name(job.name);
    result.set_state("not_submitted");
    result.set_verdict("none");
  }
}

BatchResults BatchRun::Run() {
  results_.set_started_utc(host::UtcText(std::chrono::system_clock::now()));
  while (!plan_.over() && Interrupts() == 0) Turn();
  if (!plan_.over()) Leave();
  bar_.Finish();
  for (BatchJobResult& job : *results_.mutable_jobs()) {
    if (job.state() != "not_submitted") continue;
    job.set_message(interrupted_
                        ? "interrupted before its turn came"
                        : "not started after a job that is not good (--keep-going)");
  }
  results_.set_ended_utc(host::UtcText(std::chrono::system_clock::now()));
  results_.set_time_s(Seconds(Clock::now() - began_));
  Count(results_);
  return results_;
}

void BatchRun::Turn() {
  for (const BatchPlan::Start& start : plan_.Next()) Submit(start);
  client_.Poll(50ms);
  // An end changes the map.
  std::vector<std::size_t> numbers;
  for (const auto& [job, out] : out_) numbers.push_back(job);
  for (const std::size_t job : numbers) Follow(job, out_.at(job));
  const auto services = client_.services();
  if (std::any_of(services.begin(), services.end(),
                  [](const client::ServiceView& service) {
                    return service.role == intaglio_ROLE_JOB_SERVICE;
                  })) {
    service_seen_ = Clock::now();
  }
  if (Clock::now() - service_seen_ > kServiceTime) {
    numbers.clear();
    for (const auto& [job, out] : out_) numbers.push_back(job);
    plan_.Stop();
    for (const std::size_t job : numbers) {
      GiveUp(job, "left",
             "the job service no longer runs, so the result of the job is unknown: start "
             "it again (intaglio up), then intaglio list");
    }
  }
  ShowProgress();
}

void BatchRun::Submit(const BatchPlan::Start& start) {
  const BatchJob& job = jobs_[start.job];
  BatchJobResult& entry = result(start.job);
  entry.set_cell(start.cell);
  entry.set_key(job.key.empty() ? client::NewSubmissionKey() : job.key);
  const auto submitted =
      client_.Submit(job.by_cell.at(start.cell), kSubmitTime, entry.key());
  if (!submitted) return Refuse(start.job, submitted.error().message);
  entry.set_job(submitted->number);
  entry.set_uid(submitted->uid);
  entry.set_result_directory(submitted->result_directory);
  entry.set_state(history::StateName(submitted->state));
  Out& out = out_[start.job];
  out.uid = submitted->uid;
  out.since = Clock::now();
  const auto basis =
      options_.same_block ? intaglio_ARM_SAME_BLOCK : intaglio_ARM_BY_PROGRAM;
  if (options_.arm)
    out.arm.emplace(client_, *submitted,
                    client::ArmTerms{options_.accept_breakage, basis});
  if (events_ != nullptr) events_->Submitted(*submitted, job.id);
}

void BatchRun::Follow(std::size_t job, Out& out) {
  const client::JobView view = client_.jobs().at(out.uid);
  result(job).set_state(history::StateName(view.state));
  result(job).set_message(view.message);
  if (view.ended()) {
    if (out.ended == Clock::time_point()) out.ended = Clock::now();
    const bool waits =
        !client::IsSettled(view) && Clock::now() - out.ended < client::kSettledWithin;
    return waits ? void() : End(job, view);
  }
  if (client_.IsForgotten(out.uid)) {
    return GiveUp(job, "left",
                  fmt::format("the job has ended while this program was stopped or "
                              "disconnected: see intaglio history --job {}",
                              view.number));
  }
  if (events_ != nullptr) events_->Show(view, jobs_[job].id);
  if (out.arm) out.arm->Follow(view);
  ReportWaiting(job, view, out);
}

std::string BatchRun::WaitsFor(const client::JobView& view, const Out& out) const {
  if (view.armed) return {};
  if (view.state == intaglio_JOB_PAUSED) {
    return fmt::format("{}; intaglio resume {}",
                       view.paused_by_operator() ? view.disarm_reason : view.message,
                       view.number);
  }
  if (!out.arm || view.state == intaglio_JOB_QUEUED) return {};
  const std::string hint = "; " + client::ArmCommandOf(view);
  const Warning* consent = view.open_consent();
  if (consent != nullptr) return consent->text + hint;
  const std::string awaits = out.arm->WhatBlockItAwaits(view);
  if (!awaits.empty()) return awaits + hint;
  if (out.arm->state() == client::ArmOnce::State::kLeft) return out.arm->reason() + hint;
  // Its arm was taken and withdrawn; the status that shows it armed may not be here yet.
  const bool disarmed = out.arm->state() == client::ArmOnce::State::kArmed &&
                        view.disarm_count != out.arm->disarm_count();
  return disarmed ? view.disarm_reason + hint : std::string();
}

void BatchRun::ReportWaiting(std::size_t job, const client::JobView& view, Out& out) {
  const std::string why = WaitsFor(view, out);
  if (why.empty()) {
    out.waits_since = {};
    out.waits_for.clear();
    return;
  }
  result(job).set_message("waits for a person: " + why);
  if (out.waits_since == Clock::time_point()) out.waits_since = Clock::now();
  if (why != out.waits_for) {
    Report(fmt::format("{} (job {}, {}) waits for a person: {}, or cancel", jobs_[job].id,
                       view.number, view.cell, why));
  }
  out.waits_for = why;
  const bool too_long = options_.pause_limit_s > 0 &&
                        Seconds(Clock::now() - out.waits_since) > options_.pause_limit_s;
  if (!too_long || out.cancelled) return;
  Report(fmt::format("{} (job {}) is cancelled: it waited for a person for {}",
                     jobs_[job].id, view.number,
                     client::ShortDuration(options_.pause_limit_s)));
  Cancel(view, out);
}

void BatchRun::Cancel(const client::JobView& view, Out& out) {
  out.cancelled = true;
  (void)client_.Send(view, {.kind = intaglio_COMMAND_CANCEL});
}

void BatchRun::End(std::size_t job, const client::JobView& view) {
  const client::JobEnd end = EndOf(client_, view);
  BatchJobResult& entry = result(job);
  entry.set_time_s(Seconds(Clock::now() - out_.at(job).since));
  SetCounts(end, entry);
  AddTo(*entry.mutable_warnings(), view.warnings);
  if (entry.message().empty()) entry.set_message(end.verdict.reason);
  if (events_ != nullptr) events_->Ended(view, end, jobs_[job].id);
  Report(fmt::format("{} (job {}, {}) {}, {}{}", jobs_[job].id, view.number, view.cell,
                     client::NameOf(view.state), VerdictName(end.verdict.verdict),
                     entry.message().empty() ? "" : ": " + entry.message()));
  ends_[job] = WhatBecameOf(view, end.verdict.verdict);
  Settle(job, IsGood(ends_[job]));
}

void BatchRun::Refuse(std::size_t job, const std::string& message) {
  result(job).set_state("refused");
  ends_[job] = JobResult::kFailed;
  GiveUp(job, "refused", message);
}

void BatchRun::GiveUp(std::size_t job, const char* event_name,
                      const std::string& message) {
  BatchJobResult& entry = result(job);
  entry.set_message(message);
  Report(fmt::format("{} {}: {}", jobs_[job].id, entry.state(), message));
  if (events_ != nullptr) {
    JobEvent event;
    event.set_event(event_name);
    event.set_job(entry.job());
    event.set_uid(entry.uid());
    event.set_id(jobs_[job].id);
    event.set_name(jobs_[job].name);
    event.set_cell(entry.cell());
    event.set_verdict(VerdictName(VerdictKind::kNone));
    event.set_message(message);
    events_->Write(event);
  }
  Settle(job, false);
}

void BatchRun::Settle(std::size_t job, bool good) {
  out_.erase(job);
  for (const std::size_t other : plan_.Ended(job, good)) {
    BatchJobResult& skipped = result(other);
    skipped.set_state("skipped");
    skipped.set_message(fmt::format("comes after {}, which is not good", jobs_[job].id));
    Report(fmt::format("{} is skipped: it {}", jobs_[other].id, skipped.message()));
    if (events_ == nullptr) continue;
    JobEvent event;
    event.set_event("skipped");
    event.set_id(jobs_[other].id);
    event.set_name(jobs_[other].name);
    event.set_verdict(VerdictName(VerdictKind::kNone));
    event.set_message(skipped.message());
    events_->Write(event);
  }
  if (good || options_.keep_going) return;
  plan_.Stop();
  // What has its machine goes on; what waits behind it does not begin.
  for (auto& [number, out] : out_) {
    const client::JobView& view = client_.jobs().at(out.uid);
    if (view.state != intaglio_JOB_QUEUED || out.cancelled) continue;
    Cancel(view, out);
  }
}

void BatchRun::CancelWaiting() {
  for (auto& [job, out] : out_) {
    const client::JobView& view = client_.jobs().at(out.uid);
    if (view.ended() || IsEngraved(view) || out.cancelled) continue;
    Cancel(view, out);
  }
}

void BatchRun::Leave() {
  interrupted_ = true;
  plan_.Stop();
  Report(
      "interrupted: waiting jobs are cancelled, a job that is being engraved continues; "
      "Ctrl-C again ends at once");
  const int before = Interrupts();
  const auto settled = [&] {
    CancelWaiting();
    std::vector<std::size_t> ended;
    for (const auto& [job, out] : out_) {
      if (client_.jobs().at(out.uid).ended()) ended.push_back(job);
    }
    for (const std::size_t job : ended) Follow(job, out_.at(job));
    return Interrupts() > before ||
           std::all_of(out_.begin(), out_.end(), [this](const auto& entry) {
             return IsEngraved(client_.jobs().at(entry.second.uid));
           });
  };
  client_.PollUntil(settled, kCancelTime);
  for (const auto& [job, out] : out_) {
    const client::JobView& view = client_.jobs().at(out.uid);
    BatchJobResult& entry = result(job);
    entry.set_state(history::StateName(view.state));
    entry.set_time_s(Seconds(Clock::now() - out.since));
    entry.set_message(out.waits_for.empty()
                          ? fmt::format("continues: intaglio watch {}", view.number)
                          : "waits for a person: " + out.waits_for);
    Report(fmt::format("{} (job {}, {}) is still {}: it {}", jobs_[job].id, view.number,
                       view.cell, client::NameOf(view.state), entry.message()));
    if (events_ != nullptr) events_->Write(client::EventOf("left", view, jobs_[job].id));
  }
}

void BatchRun::Report(const std::string& line) {
  bar_.Finish();
  std::cerr << line << "\n";
}

void BatchRun::ShowProgress() {
  const auto count = [this](BatchPlan::State state) { return plan_.count(state); };
  const std::size_t ended = count(BatchPlan::State::kGood) +
                            count(BatchPlan::State::kBad) +
                            count(BatchPlan::State::kSkipped);
  const auto waiting = std::count_if(out_.begin(), out_.end(), [](const auto& entry) {
    return !entry.second.waits_for.empty();
  });
  bar_.ShowShare(
      "batch", ended, jobs_.size(), Seconds(Clock::now() - began_),
      fmt::format("{} under way{}, {} good, {} not", count(BatchPlan::State::kOut),
                  waiting == 0 ? "" : fmt::format(" ({} wait for a person)", waiting),
                  count(BatchPlan::State::kGood), count(BatchPlan::State::kBad)));
}

void BatchRun::Count(BatchResults& results) const {
  const auto count = [this](JobResult result) {
    return static_cast<std::uint32_t>(std::count(ends_.begin(), ends_.end(), result));
  };
  results.set_good(count(JobResult::kGood));
  results.set_good_with_warnings(count(JobResult::kGoodWithWarnings));
  results.set_not_good(count(JobResult::kNotGood));
  results.set_failed(count(JobResult::kFailed));
  results.set_cancelled(count(JobResult::kCancelled));
  results.set_not_made(count(JobResult::kNotMade));
}

}  // namespace intaglio::cli
