#include "services/client/shop/job_record.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "services/client/shop/queue_time.h"
#include "services/client/shop/set_counts.h"
#include "services/history/job_names.h"
#include "services/job/verdict/warnings.h"

namespace intaglio::client {
namespace {

void AddStages(const JobView& job, JobRecord& record) {
  for (const JobView::Progress& progress : job.progress) {
    if (progress.total_count == 0) continue;
    StageRecord& stage = *record.add_stages();
    stage.set_stage(NameOf(progress.stage));
    stage.set_done(ShownCount(progress.done_count));
    stage.set_total(ShownCount(progress.total_count));
    stage.set_elapsed_s(progress.elapsed_s);
    if (progress.elapsed_s > 0) {
      stage.set_rate(static_cast<double>(progress.done_count) / progress.elapsed_s);
    }
  }
}

}  // namespace

JobRecord JobRecordOf(const JobView& job) {
  JobRecord record;
  record.set_job(job.number);
  record.set_uid(job.uid);
  record.set_name(job.name);
  record.set_cell(job.cell);
  record.set_state(history::StateName(job.state));
  record.set_pause_reason(history::PauseReasonName(job.pause_reason));
  record.set_armed(job.armed && !job.ended());
  record.set_disarm_reason(job.disarm_reason);
  record.set_attempt(job.attempt);
  AddStages(job, record);
  if (job.rate_hz > 0) {
    record.set_estimated_s(static_cast<double>(job.estimate_ticks) / job.rate_hz);
  }
  record.set_rate_hz(job.rate_hz);
  record.set_speed_percent(job.speed_percent);
  record.set_message(job.message);
  record.set_result_directory(job.result_directory);
  AddTo(*record.mutable_warnings(), job.warnings);
  record.set_breakage_accepted_by(job.breakage_accepted_by);
  record.set_verdict(job.verdict);
  SetCounts(job.counts, record);
  record.set_makes(job.makes);
  record.set_alarm(job.alarm);
  record.set_queue_place(job.queue_place);
  return record;
}

JobList JobListOf(const std::map<std::string, JobView>& jobs,
                  std::chrono::system_clock::time_point now) {
  JobList list;
  std::vector<JobView> open;
  for (const auto& [uid, job] : jobs) {
    *list.add_jobs() = JobRecordOf(job);
    if (!job.ended()) open.push_back(job);
  }
  for (QueueTime& queue : QueueTimesOf(open, now)) *list.add_queues() = std::move(queue);
  std::sort(list.mutable_jobs()->begin(), list.mutable_jobs()->end(),
            [](const JobRecord& a, const JobRecord& b) { return a.job() < b.job(); });
  return list;
}

}  // namespace intaglio::client
