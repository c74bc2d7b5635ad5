// The part of the job service that has to do with submissions.

#include <fmt/format.h>

#include <memory>
#include <mutex>
#include <utility>

#include "materials_db/material_store.h"
#include "services/job/files/submission_id.h"
#include "services/job/marks/mark_maker.h"
#include "services/job_service/job_service.h"
#include "services/job_service/submission.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"
#include "services/platform/host/version/software_version.h"

namespace intaglio::job_service {
namespace {

using bus::View;

/// The material base, for the threads that read submissions.
struct Materials {
  explicit Materials(materials_db::MaterialStore&& opened) : store(std::move(opened)) {}
  std::mutex mutex;
  materials_db::MaterialStore store;
};

}  // namespace

SubmissionReader::Read ReadingWith(const std::filesystem::path& path) {
  auto store = materials_db::MaterialStore::Open(path);
  if (!store) {
    const ErrorCode code = store.error().code;
    throw StoreError(store.error().message,
                     code == ErrorCode::kIo || code == ErrorCode::kTimedOut);
  }
  const auto materials = std::make_shared<Materials>(std::move(*store));
  return [materials](const std::vector<std::uint8_t>& job) {
    const auto find = [&materials](const std::string& name) {
      const std::lock_guard lock(materials->mutex);
      return materials->store.Find(name);
    };
    return FreezeSubmission(job, find, host::SoftwareVersion());
  };
}

void JobService::TakeSubmissions(Nanoseconds now) {
  submissions_.TakeAll(
      [&](const intaglio_JobSubmission& submission, const bus::SampleOrigin& origin) {
        const std::string process = origin.writer ? origin.writer->participant : "";
        if (origin.alive) Submit(submission, process, now);
      });
  for (SubmissionReader::Answer& answer : reader_.Take(now)) {
    if (answer.frozen) {
      Accept(answer, std::move(*answer.frozen));
    } else {
      Refuse(answer.uid, answer.frozen.error().message, now);
    }
  }
  while (const auto uid = refusals_.TakeOldest(now)) board_.Withdraw("", *uid);
  while (const auto uid = recalls_.TakeOldest(now)) {
    board_.Withdraw(*uid, recalled_.at(*uid));
    recalled_.erase(*uid);
  }
}

void JobService::Submit(const intaglio_JobSubmission& submission,
                        const std::string& process, Nanoseconds now) {
  const std::string submission_uid(View(submission.submission_uid));
  if (const auto outcome = store_.OutcomeOf(submission_uid)) {
    if (!outcome->empty()) return Refuse(submission_uid, *outcome, now);
    return Recall(submission_uid, now);
  }
  if (const auto why = WhyKeyIsTaken(submission_uid))
    return Refuse(submission_uid, *why, now);
  if (submission.epoch != 0 && submission.epoch != epoch_) {
    return Refuse(submission_uid,
                  "the submission is for another run of the job service; submit again",
                  now);
  }
  const auto job = View(submission.job);
  const bool waits = reader_.Add({submission_uid,
                                  std::string(View(submission.client)),
                                  {job.begin(), job.end()},
                                  process},
                                 now);
  if (waits || now < next_drop_log_) return;
  next_drop_log_ = now + std::chrono::seconds(1);
  host::LogWarning(
      "submission {} is dropped: more than {} of its process {} wait; end that process",
      submission_uid, SubmissionReader::kMaxOfProcess, process);
}

std::optional<std::string> JobService::WhyKeyIsTaken(const std::string& uid) {
  const std::string key(SubmissionKeyOf(uid));
  if (key.empty()) return {};
  const auto number = store_.TakenUnder(uid.substr(0, uid.rfind(':') + 1));
  if (!number) return {};
  return fmt::format(
      "submission id '{}' was used for another job, job {}: give a new id to submit this "
      "one as well",
      key, *number);
}

// A job that ended long ago is not on the bus any more: it is for a moment.
void JobService::Recall(const std::string& submission_uid, Nanoseconds now) {
  const auto uid = store_.JobOf(submission_uid);
  if (!uid || queue_.Find(*uid) != nullptr) return;
  const auto past = store_.LoadEnded(*uid);
  if (!past) return;
  Publish(*past);
  if (recalled_.emplace(*uid, submission_uid).second) recalls_.Add(*uid, now);
}

void JobService::Accept(const SubmissionReader::Answer& submission, FrozenJob frozen) {
  JobRecord job;
  job.number = store_.NextNumber();
  job.epoch = epoch_;
  job.uid = fmt::format("{}-{:x}", job.number, epoch_);
  job.submission_uid = submission.uid;
  job.result_directory = (options_.results / job.uid).string();
  frozen.set_job_uid(job.uid);
  frozen.set_epoch(epoch_);
  frozen.set_result_directory(job.result_directory);
  job.name = frozen.job().name();
  job.cell = frozen.machine().name();
  job.material = frozen.job().glass();
  if (MakesMarks(frozen.job())) job.makes = "marks";
  job.priority = frozen.job().priority();
  job.arm = JobArm({.asks_before_resume = frozen.job().ask_before_resume()});
  job.rate_hz = frozen.job().laser().rate_hz();
  job.frozen_job = frozen.SerializeAsString();
  OpenCell(job.cell);
  host::LogInfo("job {} \"{}\" of {} for {}", job.uid, job.name, submission.client,
                job.cell);
  queue_.Add(std::move(job));
}

void JobService::Refuse(const std::string& submission_uid, const std::string& reasons,
                        Nanoseconds now) {
  store_.KeepRefusal(submission_uid, reasons);
  host::LogInfo("submission {} is refused: {}", submission_uid, reasons);
  JobRecord refused;
  refused.submission_uid = submission_uid;
  refused.state = intaglio_JOB_FAILED;
  refused.message = reasons;
  refused.revision = 1;
  Publish(refused);
  refusals_.Add(submission_uid, now);
}

}  // namespace intaglio::job_service
