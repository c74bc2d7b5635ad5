#include "services/client/job_client.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "engrave/core/try.h"
#include "services/job/models/discretize_outcome.h"
#include "services/job/mounted/mounted_sample.h"
#include "services/job/verdict/warnings.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/peers/identity_role.h"
#include "services/platform/host/peers/role_refusal.h"
#include "services/platform/host/process/patience.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::client {
namespace {

using bus::Borrow;
using bus::View;
using namespace std::chrono_literals;

// A job service that is seen again publishes all that it knows within a second.
constexpr auto kForgottenAfter = 10s;
constexpr auto kEndedStaysFor = 60s;
// The job service tries its disk again every second.
constexpr auto kFaultTime = 2s;

constexpr int kLastStage = intaglio_STAGE_ENGRAVE;

}  // namespace

JobClient::Commands::Commands(bus::Bus& bus)
    : commands(bus, bus::kJobCommand), answers(bus, bus::kJobCommandAnswer) {}

JobClient::JobClient(bus::Bus& bus, std::function<Clock::time_point()> now)
    : sender_(fmt::format("{}-{}-{}", OperatorName(), getpid(), NewSubmissionKey())),
      statuses_(bus, bus::kJobStatus),
      job_counts_(bus, bus::kJobCount),
      mounted_(bus, bus::kMounted),
      tasks_(bus, bus::kTaskStatus),
      health_(bus, bus::kServiceHealth),
      listed_(bus),
      disk_spaces_(bus, bus::kDiskSpace),
      wait_(bus),
      now_(std::move(now)) {
  // Two rights: to submit, and to command.
  try {
    submissions_ =
        std::make_unique<bus::Writer<intaglio_JobSubmission>>(bus, bus::kJobSubmission);
  } catch (const bus::NotAllowedError& error) {
    no_submissions_ = host::RoleRefusal(bus.role(), "submit jobs",
                                        "operator or a submitter", error.what());
  }
  try {
    commands_ = std::make_unique<Commands>(bus);
  } catch (const bus::NotAllowedError& error) {
    no_commands_ = host::RoleRefusal(bus.role(), "command jobs and machines", "operator",
                                     error.what());
  }
  if (commands_) wait_.Attach(commands_->answers);
  wait_.Attach(statuses_);
  wait_.Attach(job_counts_);
  wait_.Attach(mounted_);
  wait_.Attach(tasks_);
  wait_.Attach(health_);
}

void JobClient::Receive(const intaglio_JobStatus& status) {
  JobView view;
  view.uid = View(status.job_uid);
  view.submission_uid = View(status.submission_uid);
  view.name = View(status.name);
  view.message = View(status.message);
  view.result_directory = View(status.result_directory);
  view.cell = View(status.cell);
  view.epoch = status.epoch;
  view.number = status.number;
  view.attempt = status.attempt;
  view.state = status.state;
  view.pause_reason = status.pause_reason;
  for (const intaglio_StageProgress& p : View(status.progress)) {
    view.progress.push_back({p.stage, p.done_count, p.total_count, p.elapsed_s});
  }
  view.estimate_ticks = status.estimate_ticks;
  view.rate_hz = status.rate_hz;
  view.revision = status.revision;
  view.speed_percent = status.speed_percent;
  view.armed = status.armed;
  view.disarm_count = status.disarm_count;
  view.disarm_reason = View(status.disarm_reason);
  for (const intaglio_JobWarning& warning : View(status.warnings)) {
    view.warnings.push_back(WarningOf(warning));
  }
  view.breakage_accepted_by = View(status.breakage_accepted_by);
  view.makes = View(status.makes);
  view.counts = status.counts;
  view.verdict = View(status.verdict);
  view.alarm = View(status.alarm);
  view.awaits_block = status.awaits_block;
  view.block_id = View(status.block_id);
  view.queue_place = status.queue_place;
  if (view.uid.empty()) {
    refused_[view.submission_uid] = view;
  } else {
    lost_.erase(view.uid);
    jobs_[view.uid] = view;
  }
}

void JobClient::LoseStatus(const std::string& uid, const std::string& submission_uid) {
  if (uid.empty()) {
    old_refusals_.push_back(submission_uid);
  } else if (jobs_.contains(uid)) {
    lost_.try_emplace(uid, now_());
  }
}

void JobClient::DropForgotten() {
  if (lost_.empty()) return;
  const auto now = now_();
  const bool served =
      std::any_of(services_.begin(), services_.end(), [](const auto& service) {
        return service.second.role == intaglio_ROLE_JOB_SERVICE;
      });
  std::vector<std::string> ended;
  for (auto& [uid, since] : lost_) {
    if (!jobs_.at(uid).ended()) {
      if (!served) since = now;
    } else if (now - since > kEndedStaysFor) {
      ended.push_back(uid);
    }
  }
  for (const std::string& uid : ended) Drop(uid);
}

void JobClient::Drop(const std::string& uid) {
  lost_.erase(uid);
  jobs_.erase(uid);
  outcomes_.erase(outcomes_.lower_bound({uid, 0}),
                  outcomes_.upper_bound({uid, kLastStage}));
}

bool JobClient::IsForgotten(const std::string& uid) const {
  const auto lost = lost_.find(uid);
  return lost != lost_.end() && !jobs_.at(uid).ended() &&
         now_() - lost->second > kForgottenAfter;
}

void JobClient::Receive(const intaglio_TaskStatus& status) {
  if (host::IsComparison(status.part_attempt)) return;
  const std::pair key(std::string(View(status.job_uid)), static_cast<int>(status.stage));
  StageOutcomes& stage = outcomes_[key];
  if (status.attempt < stage.attempt) return;
  if (status.attempt > stage.attempt) stage = {status.attempt, 1, {}};
  stage.part_count = status.part_count;
  const auto bytes = View(status.outcome);
  StageOutcome outcome;
  if (bytes.empty() ||
      !outcome.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()))) {
    return;
  }
  stage.outcomes[status.part] = outcome;
}

void JobClient::Poll(std::chrono::milliseconds timeout) {
  for (const std::string& uid : old_refusals_) refused_.erase(uid);
  old_refusals_.clear();
  (void)wait_.Wait(timeout);
  statuses_.TakeAll(
      [this](const intaglio_JobStatus& status, const bus::SampleOrigin& origin) {
        if (origin.alive) return Receive(status);
        LoseStatus(std::string(View(status.job_uid)),
                   std::string(View(status.submission_uid)));
      });
  TakeMounts();
  tasks_.TakeAll([this](const intaglio_TaskStatus& status, const bus::SampleOrigin& o) {
    if (o.alive && (host::HasNoRole(o) || host::IsOwnTask(status, o))) Receive(status);
  });
  if (commands_) {
    commands_->answers.Take(
        [this](const intaglio_JobCommandAnswer& answer) { Receive(answer); });
  }
  health_.TakeAll(
      [this](const intaglio_ServiceHealth& health, const bus::SampleOrigin& o) {
        if (!host::HasNoRole(o) && !host::IsOwnHealth(health, o)) return;
        const std::string instance(View(health.instance));
        if (!o.alive) {
          services_.erase(instance);
          return;
        }
        services_[instance] = ServiceViewOf(health, std::chrono::steady_clock::now());
      });
  TakeCounts();
  listed_.Poll();
  TakeDisks();
  DropForgotten();
}

void JobClient::TakeCounts() {
  job_counts_.TakeAll([this](const intaglio_JobCount& count, const bus::SampleOrigin& o) {
    const std::string instance(View(count.instance));
    if (o.alive) {
      counts_[instance] = count.job_count;
    } else {
      counts_.erase(instance);
    }
  });
}

// The processes of two job services, one of which has just died, have the same jobs.
std::optional<std::uint64_t> JobClient::counted_jobs() const {
  std::optional<std::uint64_t> greatest;
  for (const auto& [instance, service] : services_) {
    if (service.role != intaglio_ROLE_JOB_SERVICE) continue;
    const auto count = counts_.find(instance);
    if (count == counts_.end()) return std::nullopt;
    greatest = std::max(greatest.value_or(0), count->second);
  }
  return greatest;
}

bool JobClient::KnowsAllJobs() const {
  const auto counted = counted_jobs();
  return counted && jobs_.size() - lost_.size() >= *counted;
}

bool JobClient::KnowsAllServices(const std::vector<ServiceView>& found) const {
  bool served = false;
  for (const auto& [instance, service] : services_) {
    if (service.role != intaglio_ROLE_JOB_SERVICE) continue;
    const auto list = listed_.lists().find(instance);
    if (list == listed_.lists().end()) return false;
    for (const ListedService& listed : list->second)
      if (std::ranges::find(found, listed.instance, &ServiceView::instance) ==
          found.end())
        return false;
    served = true;
  }
  return served;
}

void JobClient::TakeMounts() {
  mounted_.Take([this](const intaglio_CellMount& mount) {
    auto parts = PartsOf(mount.parts);
    if (!parts) return;
    mounts_[std::string(View(mount.cell))] = {std::move(*parts),
                                              std::string(View(mount.operator_name)),
                                              std::string(View(mount.mounted_utc))};
  });
}

void JobClient::TakeDisks() {
  disk_spaces_.TakeAll([this](const intaglio_DiskSpace& disk,
                              const bus::SampleOrigin& o) {
    const std::string instance(View(disk.instance)), folder(View(disk.folder));
    if (!o.alive) {
      disks_.erase({instance, folder});
    } else {
      disks_[{instance, folder}] = {instance, folder, disk.free_bytes, disk.total_bytes};
    }
  });
}

std::vector<DiskView> JobClient::disks() const {
  std::vector<DiskView> views;
  for (const auto& [key, view] : disks_) views.push_back(view);
  return views;
}

std::optional<Error> JobClient::JobServiceFault() const {
  for (const auto& [instance, service] : services_) {
    const bool faulty = service.role == intaglio_ROLE_JOB_SERVICE &&
                        service.state == intaglio_HEALTH_FAULT;
    if (faulty)
      return Error{ErrorCode::kFault, "the job service cannot work: " + service.message,
                   instance};
  }
  return std::nullopt;
}

Result<bool> JobClient::AwaitAnswer(const std::function<bool()>& condition,
                                    std::chrono::milliseconds timeout) {
  std::optional<Clock::time_point> faulty_since;
  const auto is_decided = [&] {
    if (condition()) return true;
    if (!JobServiceFault()) {
      faulty_since.reset();
      return false;
    }
    const auto now = Clock::now();
    if (!faulty_since) faulty_since = now;
    return now - *faulty_since >= kFaultTime;
  };
  host::Patience patience(timeout);
  while (!is_decided() && !patience.IsUp()) Poll(50ms);
  if (condition()) return true;
  if (auto fault = JobServiceFault()) return tl::unexpected(std::move(*fault));
  return false;
}

bool JobClient::PollUntil(const std::function<bool()>& condition,
                          std::chrono::milliseconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  for (;;) {
    if (condition()) return true;
    if (std::chrono::steady_clock::now() >= end) return false;
    Poll(50ms);
  }
}

Result<JobView> JobClient::Find(const std::string& uid_or_number) const {
  std::string known;
  for (const auto& [uid, view] : jobs_) {
    if (uid == uid_or_number || std::to_string(view.number) == uid_or_number) return view;
    known += (known.empty() ? "" : ", ") + std::to_string(view.number);
  }
  if (auto fault = JobServiceFault()) return tl::unexpected(std::move(*fault));
  if (services_.empty()) return Fail(ErrorCode::kTimedOut, kNoJobService);
  return Fail(ErrorCode::kNotFound,
              fmt::format("no job '{}'; the known jobs are: {}", uid_or_number,
                          known.empty() ? "none" : known),
              uid_or_number);
}

std::optional<StageOutcome> JobClient::OutcomeOf(const std::string& job_uid,
                                                 intaglio_Stage stage) const {
  const auto found = outcomes_.find({job_uid, static_cast<int>(stage)});
  if (found == outcomes_.end()) return std::nullopt;
  const auto& [attempt, part_count, parts] = found->second;
  if (parts.empty() || parts.size() < part_count) return std::nullopt;
  StageOutcome all = parts.begin()->second;
  for (auto part = std::next(parts.begin()); part != parts.end(); ++part) {
    all.set_elapsed_s(all.elapsed_s() + part->second.elapsed_s());
    AddPart(part->second.discretize(), *all.mutable_discretize());
  }
  return all;
}

std::vector<ServiceView> JobClient::services() const {
  std::vector<ServiceView> views;
  for (const auto& [instance, view] : services_) views.push_back(view);
  return views;
}

}  // namespace intaglio::client
