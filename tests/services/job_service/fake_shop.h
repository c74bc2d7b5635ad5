#pragma once

// The real job service as a process, and all other processes played by the test: a
// client, a discretizer, a sorter, a synchronizer, on a bus that no other process sees.

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "engrave/core/warning.h"
#include "proto/job.pb.h"
#include "proto/task.pb.h"
#include "services/platform/bus/flow.h"
#include "services/platform/host/version/wire_version.h"
#include "tests/services/platform/bus/private_bus.h"

namespace intaglio::job_service {

/// bin/intaglio-job-service; killed with its holder.
class ServiceProcess {
 public:
  /// `database`: jobs.db in the folder when it is empty.
  ServiceProcess(const std::filesystem::path& folder, const std::string& tag,
                 const std::string& database = {},
                 const std::vector<std::string>& more = {});
  ~ServiceProcess() { Kill(); }
  int pid() const { return pid_; }
  void Kill();  ///< SIGKILL
  /// SIGTERM; the exit code.
  int Stop();
  /// True when it has ended by itself.
  bool Exited(int& exit_code);

 private:
  int pid_ = -1;
};

struct StatusCopy {
  std::string uid, message, result_directory, cell;
  std::uint64_t epoch = 0, revision = 0, estimate_ticks = 0;
  std::uint32_t attempt = 0;
  intaglio_JobState state = intaglio_JOB_QUEUED;
  bool armed = false;
  std::uint64_t disarm_count = 0;
  Warnings warnings;
  std::string breakage_accepted_by;
};

struct TaskCopy {
  std::string worker, job_uid, consumer;
  std::uint32_t attempt = 0;
  std::uint32_t part = 0, part_count = 1, part_attempt = 0;
  std::uint32_t input_part_count = 1;
  bool revoked = false;
  FrozenJob frozen;
};

class FakeShop {
 public:
  explicit FakeShop(const bus::BusOptions& options);

  void Submit(const std::string& submission_uid, const JobSpec& job,
              std::uint64_t epoch = 0);
  /// The command of a client that has seen this status; it stays until the shop ends.
  void Command(const StatusCopy& job, intaglio_JobCommandKind kind, std::uint64_t number,
               bool fire_uncertain = false, const std::string& sender = "ann");
  void Accept(const StatusCopy& job, std::uint64_t number);  ///< an arm with consent
  /// The newest answer, waited for, else -1; and how many came.
  int AnswerTo(std::uint64_t number, const std::string& sender = "ann");
  int answers(std::uint64_t number, const std::string& sender = "ann");
  /// Publishes a worker's health; the worker appears with the first one.
  void Health(intaglio_Stage stage, const std::string& instance,
              intaglio_HealthState state);
  /// The version that workers have from their next health on.
  void SetVersion(const std::string& version) { version_ = version; }
  void Die(intaglio_Stage stage, const std::string& instance);
  void Report(const TaskCopy& task, intaglio_Stage stage, intaglio_TaskState state,
              std::uint64_t done, std::uint64_t total,
              intaglio_ErrorCode code = intaglio_ERROR_NONE,
              const std::string& message = "", const StageOutcome& outcome = {});

  /// Tests use "s"; on the bus a name ends in that of its participant.
  std::string FullName(const std::string& instance) const;

  /// Takes what has come.
  void Poll();
  /// Polls until it holds; ten seconds at most.
  bool Until(const std::function<bool()>& condition);

  /// Newest status of the submission; an empty one when there is none.
  StatusCopy Status(const std::string& submission_uid);
  /// Submissions with a status.
  std::size_t status_count() const { return status_.size(); }
  /// Health of the job service; nothing before its first sample.
  struct HealthCopy {
    intaglio_HealthState state = intaglio_HEALTH_STARTING;
    std::string message;
  };
  HealthCopy JobServiceHealth();
  TaskCopy Task(intaglio_Stage stage);
  /// As a synchronizer sees it: silence is no permission.
  bool granted() const;
  /// The newest permission's consent to fire uncertain points.
  bool fire_uncertain() const { return fire_uncertain_; }
  int permissions_seen() const { return permissions_seen_; }

  /// Models of the task, as the discretizer gets them; true when all are there.
  bool ReceiveModels(const TaskCopy& task);
  const std::vector<std::string>& models() const { return models_; }

 private:
  std::string version_ = host::WireVersion();
  /// Without what FullName adds, wherever it is.
  std::string ShortNames(std::string_view text) const;
  void Write(intaglio_Stage stage, const std::string& instance,
             intaglio_HealthState state, bool dispose);

  bus::Bus bus_;
  bus::Writer<intaglio_JobSubmission> submissions_;
  bus::Writer<intaglio_JobCommand> commands_;
  std::array<bus::Writer<intaglio_ServiceHealth>, 3> health_;
  std::array<bus::Writer<intaglio_TaskStatus>, 3> tasks_out_;
  bus::Reader<intaglio_JobStatus> statuses_;
  bus::Reader<intaglio_JobCommandAnswer> answers_;
  std::array<bus::Reader<intaglio_StageTask>, 3> tasks_;
  bus::Reader<intaglio_Permission> permissions_;
  bus::Reader<intaglio_ModelChunk> chunks_;
  bus::Reader<intaglio_ServiceHealth> healths_;
  bus::CreditGrantor credit_;

  std::map<std::string, StatusCopy> status_;  // by submission
  std::map<std::pair<std::string, std::uint64_t>,
           std::vector<intaglio_CommandAnswerCode>>
      answered_;  // by command
  std::array<TaskCopy, 3> task_;
  HealthCopy job_service_;
  bool granted_ = false, fire_uncertain_ = false;
  int permissions_seen_ = 0;
  std::chrono::steady_clock::time_point permission_at_;
  std::string stream_;
  std::uint64_t consumed_ = 0;
  std::vector<std::string> models_;
};

}  // namespace intaglio::job_service
