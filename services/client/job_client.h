#pragma once

// A client on the bus: submits jobs, commands them, follows them.

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "proto/job.pb.h"
#include "proto/task.pb.h"
#include "services/client/job_view.h"
#include "services/client/listed_services.h"
#include "services/platform/bus/bus.h"

namespace intaglio::client {

inline constexpr char kNoJobService[] =
    "no job service answers: start one (intaglio up), or check --domain, --interface, "
    "--tag and --security";

/// 16 hex digits, at random.
std::string NewSubmissionKey();

/// Every client sees the jobs; submissions and commands are refused (kRefused) unless the
/// client's identity allows them: the role submitter allows only submissions.
class JobClient {
 public:
  using Clock = std::chrono::steady_clock;
  /// `now`: the clock that measures how long ago a job was published; tests inject their
  /// own.
  explicit JobClient(bus::Bus& bus, std::function<Clock::time_point()> now = Clock::now);

  /// Takes what has come, after waiting for it up to `timeout`.
  void Poll(std::chrono::milliseconds timeout);
  /// Polls until `condition` holds; false when the time is up first.
  bool PollUntil(const std::function<bool()>& condition,
                 std::chrono::milliseconds timeout);

  /// The job as the job service took it; kRefused with its reasons; kTimedOut when there
  /// is no job service; kFault when there is one that cannot work or does not answer:
  /// then it is not known whether it took the job, and the message has the key. With the
  /// same `key` and the same job nothing is submitted twice
  /// (services/job/files/submission_id.h); empty: a new key. `timeout`: on a computer
  /// that is not busy (patience.h).
  Result<JobView> Submit(const JobSpec& job, std::chrono::milliseconds timeout,
                         std::string key = {});
  /// Longer than the bus needs to find a job service that is there.
  static constexpr std::chrono::seconds kAnswerTime{5};
  /// Sends a command about the job as `job` has it, and waits for the answer to it.
  /// kRefused with its code and message; kFault when the job service cannot work, with
  /// its reason; kTimedOut when no answer comes: the command is withdrawn then.
  Status Command(const JobView& job, const JobOrder& order,
                 std::chrono::milliseconds timeout = kAnswerTime);
  /// What is mounted in the machine, as a person reports at it (ARM_BY_PERSON), or as a
  /// program was started with: that ends no arm when nothing changes. Errors as Command.
  Status Mount(const std::string& cell, const MountedParts& parts,
               intaglio_ArmBasis basis, std::chrono::milliseconds timeout = kAnswerTime);
  /// A worker that was left out is given tasks again. Errors as Command.
  Status Admit(const std::string& worker,
               std::chrono::milliseconds timeout = kAnswerTime);
  /// As people have reported, by machine.
  const std::map<std::string, MountView>& mounts() const { return mounts_; }
  /// This client's identity allows commands: arm, mount, pause ...
  bool may_command() const { return commands_ != nullptr; }
  /// The same without waiting; the number of the command, for AnswerTo. It stays until it
  /// is answered, also by the next job service.
  Result<std::uint64_t> Send(const JobView& job, const JobOrder& order);
  /// Once Poll has received it.
  std::optional<CommandReply> AnswerTo(std::uint64_t number) const;
  /// The job service forgets a command that was sent, unless it was taken.
  void Withdraw(std::uint64_t number);

  /// Every job service that is there has listed the services of the shop, and each of
  /// them is among those that were found. False without a job service.
  bool KnowsAllServices(const std::vector<ServiceView>& found) const;
  /// By uid; of the last revision seen. An ended job that the job service has forgotten
  /// leaves a minute later: by then every client that follows it has read its end.
  const std::map<std::string, JobView>& jobs() const { return jobs_; }
  /// Every job service that is there has counted its jobs, and as many have come. False
  /// without a job service.
  bool KnowsAllJobs() const;
  /// As the job service counts them; nullopt: it has not yet, or there is none.
  std::optional<std::uint64_t> counted_jobs() const;
  /// The job was open when it was seen last, and a living job service has not published
  /// it for 10 s: it has ended while this process was stopped or cut off. The history
  /// records how.
  bool IsForgotten(const std::string& uid) const;
  /// By uid, or by the short number that people use; kNotFound lists what there is.
  Result<JobView> Find(const std::string& uid_or_number) const;
  /// What a finished stage of the job reported, all parts together: elapsed_s is then the
  /// time of all workers.
  std::optional<StageOutcome> OutcomeOf(const std::string& job_uid,
                                        intaglio_Stage stage) const;
  /// The job service is there and cannot work, and why; nullopt: it can, or there is
  /// none.
  std::optional<Error> JobServiceFault() const;
  /// By its process and folder.
  std::vector<DiskView> disks() const;
  /// Living services.
  std::vector<ServiceView> services() const;

 private:
  void Receive(const intaglio_JobStatus& status);
  void Receive(const intaglio_TaskStatus& status);
  /// No writer has the job's status any more: the job service is gone or has forgotten
  /// it.
  void LoseStatus(const std::string& uid, const std::string& submission_uid);
  void DropForgotten();
  void Drop(const std::string& uid);
  void Receive(const intaglio_JobCommandAnswer& answer);
  void TakeDisks();
  void TakeCounts();
  void TakeMounts();
  Error WhyNoAnswer(const std::string& key, double waited_s) const;
  /// `condition`, or kFault once the job service has reported a fault for two seconds.
  Result<bool> AwaitAnswer(const std::function<bool()>& condition,
                           std::chrono::milliseconds timeout);
  /// The answer to a command about `what`, for people.
  Status AwaitCommand(std::uint64_t number, const std::string& what,
                      std::chrono::milliseconds timeout);
  struct Commands {
    explicit Commands(bus::Bus& bus);
    bus::Writer<intaglio_JobCommand> commands;
    bus::Reader<intaglio_JobCommandAnswer> answers;
  };
  std::string sender_;  // no other client has it
  // Null: its identity does not allow it, and why.
  std::unique_ptr<bus::Writer<intaglio_JobSubmission>> submissions_;
  std::string no_submissions_;
  std::unique_ptr<Commands> commands_;
  std::string no_commands_;
  bus::Reader<intaglio_JobStatus> statuses_;
  bus::Reader<intaglio_JobCount> job_counts_;
  bus::Reader<intaglio_CellMount> mounted_;
  bus::Reader<intaglio_TaskStatus> tasks_;
  bus::Reader<intaglio_ServiceHealth> health_;
  ListedServices listed_;
  bus::Reader<intaglio_DiskSpace> disk_spaces_;
  bus::WaitSet wait_;
  std::map<std::string, JobView> jobs_;
  std::map<std::string, JobView> refused_;   // by submission
  std::map<std::string, MountView> mounts_;  // by machine
  std::vector<std::string> old_refusals_;    // no longer on the bus; were read by then
  struct StageOutcomes {
    std::uint32_t attempt = 0, part_count = 1;
    std::map<std::uint32_t, StageOutcome> outcomes;  // by part
  };
  std::uint64_t last_number_ = 0;                                  // of a command
  std::map<std::uint64_t, CommandReply> replies_;                  // by command
  std::map<std::pair<std::string, int>, StageOutcomes> outcomes_;  // by job and stage
  std::map<std::string, ServiceView> services_;
  std::map<std::string, std::uint64_t> counts_;  // of jobs, by job service
  std::map<std::pair<std::string, std::string>, DiskView>
      disks_;  // by process and folder
  /// Jobs without a status on the bus, since when; for open ones this time does not
  /// pass while there is no job service.
  std::map<std::string, Clock::time_point> lost_;
  std::function<Clock::time_point()> now_;
};

}  // namespace intaglio::client
