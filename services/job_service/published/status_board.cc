#include "services/job_service/published/status_board.h"

#include <utility>
#include <vector>

#include "services/job/mounted/mounted_sample.h"
#include "services/job/verdict/warnings.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"
#include "services/platform/host/stage/counts_at_end.h"

namespace intaglio::job_service {

using bus::Borrow;

StatusBoard::StatusBoard(bus::Bus& bus, std::string instance)
    : instance_(std::move(instance)),
      statuses_(bus, bus::kJobStatus),
      counts_(bus, bus::kJobCount),
      mounts_(bus, bus::kMounted) {}

void StatusBoard::Publish(const MountRecord& mount) {
  intaglio_CellMount sample{};
  sample.cell = Borrow(mount.cell);
  sample.number = mount.number;
  sample.parts = SampleOf(mount.parts);
  sample.operator_name = Borrow(mount.operator_name);
  sample.mounted_utc = Borrow(mount.mounted_utc);
  if (auto written = mounts_.Write(sample); !written) {
    host::LogWarning("what is mounted in {}: {}", mount.cell, written.error().message);
  }
}

void StatusBoard::Announce(const std::set<std::string>& job_uids) {
  counted_.insert(job_uids.begin(), job_uids.end());
  WriteCount();
}

void StatusBoard::WriteCount() {
  intaglio_JobCount sample{};
  sample.instance = Borrow(instance_);
  sample.job_count = counted_.size();
  if (auto written = counts_.Write(sample); !written) {
    host::LogWarning("count of the jobs: {}", written.error().message);
  }
}

void StatusBoard::Publish(const JobRecord& job) { Write(job, job.counts, ""); }

// What was in the glass when the job ended is better than nothing, until its synchronizer
// has reported the end.
void StatusBoard::PublishEnded(const JobRecord& job, const JobResult& result) {
  Write(job, result.counts.planned > 0 ? result.counts : AtEnd(job.counts),
        result.verdict);
}

void StatusBoard::Write(const JobRecord& job, const intaglio_PointCounts& counts,
                        const std::string& verdict) {
  std::vector<intaglio_StageProgress> progress;
  for (const intaglio_Stage stage : kStages) {
    const StageRecord& record = job.stage(stage);
    progress.push_back({stage, record.done_count, record.total_count, record.elapsed_s});
  }
  intaglio_JobStatus sample{};
  sample.job_uid = Borrow(job.uid);
  sample.submission_uid = Borrow(job.submission_uid);
  sample.epoch = job.epoch;
  sample.number = job.number;
  sample.name = Borrow(job.name);
  sample.state = job.state;
  sample.pause_reason = job.pause_reason;
  sample.attempt = job.attempt;
  Borrow(sample.progress, progress);
  sample.estimate_ticks = job.estimate_ticks;
  sample.rate_hz = job.rate_hz;
  const std::string message =
      job.at_work.empty() ? job.message : job.at_work + "; " + job.message;
  sample.message = Borrow(message);
  sample.result_directory = Borrow(job.result_directory);
  sample.cell = Borrow(job.cell);
  sample.revision = job.revision;
  sample.speed_percent = job.speed_percent;
  sample.armed = job.arm.armed();
  sample.last_command = job.arm.kept().last_command;
  sample.disarm_count = job.arm.disarm_count();
  sample.disarm_reason = Borrow(job.arm.disarm_reason());
  const auto warnings = SamplesOf(job.warnings);
  Borrow(sample.warnings, warnings);
  sample.breakage_accepted_by = Borrow(job.arm.kept().breakage_accepted_by);
  sample.makes = Borrow(job.makes);
  sample.counts = counts;
  sample.verdict = Borrow(verdict);
  sample.alarm = Borrow(job.alarm);
  sample.awaits_block = job.awaits_block;
  sample.block_id = Borrow(job.arm.kept().block_id);
  sample.queue_place = job.queue_place;
  if (!job.uid.empty() && counted_.insert(job.uid).second) WriteCount();
  published_.emplace(job.uid, job.submission_uid);
  if (auto written = statuses_.Write(sample); !written) {
    host::LogWarning("status of job {}: {}", job.uid, written.error().message);
  }
}

void StatusBoard::Withdraw(const std::string& job_uid,
                           const std::string& submission_uid) {
  published_.erase({job_uid, submission_uid});
  intaglio_JobStatus sample{};
  sample.job_uid = Borrow(job_uid);
  sample.submission_uid = Borrow(submission_uid);
  const std::string empty;
  sample.name = sample.message = sample.result_directory = sample.cell = Borrow(empty);
  sample.disarm_reason = sample.breakage_accepted_by = Borrow(empty);
  sample.makes = sample.verdict = sample.alarm = sample.block_id = Borrow(empty);
  if (auto disposed = statuses_.Dispose(sample); !disposed) {
    host::LogWarning("end of the status of job {}: {}", job_uid,
                     disposed.error().message);
  }
  if (counted_.erase(job_uid) > 0) WriteCount();
}

void StatusBoard::WithdrawAllBut(const std::set<std::string>& job_uids) {
  const auto published = published_;
  for (const auto& [uid, submission] : published) {
    if (!job_uids.contains(uid)) Withdraw(uid, submission);
  }
}

}  // namespace intaglio::job_service
