#include "services/client/proof/shop_proofs.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "engrave/formats/journal_file.h"
#include "engrave/io/atomic_file.h"
#include "services/client/exit_codes.h"
#include "services/client/proof/evidence/glass_search.h"
#include "services/client/proof/known_outcome.h"
#include "services/client/proof/marks/mark_evidence.h"
#include "services/client/proof/marks/mark_search.h"
#include "services/client/proof/proof_folder.h"
#include "services/job/files/json_text.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

constexpr int kNice = 10;
// By then a job service has published its open jobs.
constexpr std::chrono::seconds kJobsKnownTime{10};

/// Something of it was engraved on this computer.
bool WasBegun(const fs::path& folder) {
  std::error_code error;
  return fs::exists(folder / "journal.bin", error) && HasPlan(folder);
}

bool IsComplete(const fs::path& folder) {
  std::error_code error;
  for (const char* file : {kReportFile, kViewsFile, kCustomerFile}) {
    if (file == kCustomerFile && HasMarks(folder)) continue;
    if (!fs::is_regular_file(folder / file, error)) return false;
  }
  return true;
}

JobStages StagesOf(const JobClient& client, const JobView& job) {
  JobStages stages;
  const auto outcome = [&](intaglio_Stage stage, StageOutcome* into) {
    if (const auto known = client.OutcomeOf(job.uid, stage)) *into = *known;
    return into->stage_case() != StageOutcome::STAGE_NOT_SET;
  };
  if (!outcome(intaglio_STAGE_DISCRETIZE, stages.mutable_discretize()))
    stages.clear_discretize();
  if (!outcome(intaglio_STAGE_SORT, stages.mutable_sort())) stages.clear_sort();
  if (!outcome(intaglio_STAGE_ENGRAVE, stages.mutable_engrave())) stages.clear_engrave();
  stages.set_job_number(job.number);
  stages.set_ended_utc(UtcNow());
  AddTo(*stages.mutable_warnings(), job.warnings);
  stages.set_breakage_accepted_by(job.breakage_accepted_by);
  return stages;
}

/// The last line of a process that has failed.
std::string LastLine(std::string output) {
  while (!output.empty() && output.back() == '\n') output.pop_back();
  return output.substr(output.find_last_of('\n') + 1);
}

}  // namespace

ShopView ViewOf(const JobClient& client) {
  const auto services = client.services();
  return {client.jobs(), [&client](const JobView& job) { return StagesOf(client, job); },
          std::any_of(services.begin(), services.end(), [](const ServiceView& service) {
            return service.role == intaglio_ROLE_JOB_SERVICE;
          })};
}

std::vector<std::string> ShopProofs::Turn(const ShopView& shop, Clock::time_point now) {
  if (!began_) began_ = now;
  std::vector<std::string> sentences;
  Receive(shop, now);
  TakeEnd(now, sentences);
  Start(shop, now);
  RemoveOldGlass(shop, now);
  return sentences;
}

std::size_t ShopProofs::pending_count() const {
  const auto waiting = std::count_if(pending_.begin(), pending_.end(),
                                     [](const Pending& p) { return p.reported.empty(); });
  return static_cast<std::size_t>(waiting) + (process_ ? 1 : 0);
}

void ShopProofs::Receive(const ShopView& shop, Clock::time_point now) {
  for (const auto& [uid, job] : shop.jobs) {
    if (!job.ended() || job.cell != options_.cell || seen_.contains(uid)) continue;
    seen_.insert(uid);
    const fs::path folder = job.result_directory;
    if (!WasBegun(folder) || IsComplete(folder)) continue;
    pending_.push_back({job, now, now, kFirstRetry, ""});
  }
}

void ShopProofs::Start(const ShopView& shop, Clock::time_point now) {
  if (process_) return;
  const auto is_due = [&](const Pending& p) {
    if (now < p.not_before) return false;
    const bool all_known =
        shop.stages(p.job).has_engrave() && !IsOpen(p.job.result_directory);
    return all_known || now - p.ended_at >= kOutcomeTime;
  };
  const auto due = std::find_if(pending_.begin(), pending_.end(), is_due);
  if (due == pending_.end()) return;
  proved_ = *due;
  pending_.erase(due);
  const fs::path folder = proved_->job.result_directory;
  // Without it the report lacks the stages; what the disk refuses, the process reports.
  const auto stages = JsonTextOf(shop.stages(proved_->job));
  std::error_code ignored;
  if (stages && !fs::exists(folder / kStagesFile, ignored))
    (void)io::WriteFileAtomically(folder / kStagesFile, *stages);
  const fs::path log = options_.folder / "proof.log";
  fs::remove(log, ignored);  // of the last one
  ChildProcess::Command command{
      "proof",
      options_.program,
      {"verify", folder.string(), "--glass", options_.folder.string(), "--renew",
       "--customer-picture"},
      log,
      kNice};
  command.arguments.insert(command.arguments.end(), options_.arguments.begin(),
                           options_.arguments.end());
  auto started = ChildProcess::Start(command);
  if (started) {
    process_ = std::make_unique<ChildProcess>(std::move(*started));
  } else {
    not_started_ = started.error().message;
  }
}

void ShopProofs::TakeEnd(Clock::time_point now, std::vector<std::string>& sentences) {
  if (!proved_ || (process_ && process_->running())) return;
  const bool complete = IsComplete(proved_->job.result_directory);
  if (!complete) {
    Retry(now, process_ ? LastLine(process_->LastOutput()) : not_started_, sentences);
  } else if (!proved_->reported.empty()) {
    sentences.push_back(fmt::format("job {}: report and pictures are in {} now",
                                    proved_->job.number, proved_->job.result_directory));
  }
  proved_.reset();
  process_.reset();
}

void ShopProofs::Retry(Clock::time_point now, const std::string& error,
                       std::vector<std::string>& sentences) {
  Pending again = *proved_;
  again.not_before = now + again.retry;
  again.retry = std::min(2 * again.retry, kLastRetry);
  if (again.reported != error) {
    sentences.push_back(
        fmt::format("job {}: no report and pictures yet, tried again later, or by "
                    "intaglio verify {}: {}",
                    again.job.number, again.job.result_directory, error));
  }
  again.reported = error.empty() ? "unknown" : error;
  pending_.push_back(std::move(again));
}

// What an open job has left in the glass of an earlier engraver is needed at its end.
void ShopProofs::RemoveOldGlass(const ShopView& shop, Clock::time_point now) {
  if (old_glass_removed_ || process_ || !pending_.empty()) return;
  if (now - *began_ < kJobsKnownTime) return;
  if (!shop.has_job_service) return;
  old_glass_removed_ = true;
  std::set<std::uint32_t> needed;
  for (const auto& [uid, job] : shop.jobs) {
    if (job.ended() || job.cell != options_.cell) continue;
    const auto spans = ReadTickSpans(fs::path(job.result_directory) / "journal.bin");
    if (!spans) continue;
    for (const TickSpan& span : *spans) needed.insert(span.power_up);
  }
  RemoveGlassRecords(options_.folder, needed);
  RemoveMarkRecords(options_.folder, needed);
}

}  // namespace intaglio::client
