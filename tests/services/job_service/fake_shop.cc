#include "tests/services/job_service/fake_shop.h"

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>

#include "services/job/verdict/warnings.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"

namespace intaglio::job_service {
namespace {

using bus::Borrow;
using bus::View;

constexpr intaglio_ServiceRole kRoles[] = {
    intaglio_ROLE_DISCRETIZER, intaglio_ROLE_SORTER, intaglio_ROLE_SYNCHRONIZER};
const std::string kCell = "els-03";

/// Where the workers of a stage write.
std::string PartitionOf(intaglio_Stage stage) {
  return bus::RolePartition(stage == intaglio_STAGE_ENGRAVE ? bus::CellRole(kCell)
                                                            : bus::kStageWorkerRole);
}

template <typename T>
std::array<bus::Writer<T>, 3> WritersOf(bus::Bus& bus, const bus::Topic<T>& topic) {
  return {bus::Writer<T>(bus, topic, PartitionOf(intaglio_STAGE_DISCRETIZE)),
          bus::Writer<T>(bus, topic, PartitionOf(intaglio_STAGE_SORT)),
          bus::Writer<T>(bus, topic, PartitionOf(intaglio_STAGE_ENGRAVE))};
}

}  // namespace

ServiceProcess::ServiceProcess(const std::filesystem::path& folder,
                               const std::string& tag, const std::string& database,
                               const std::vector<std::string>& more) {
  std::vector<std::string> arguments = {
      std::string(INTAGLIO_BIN_DIR) + "/intaglio-job-service",
      "--tag",
      tag,
      "--database",
      database.empty() ? (folder / "jobs.db").string() : database,
      "--materials-db",
      folder / "materials.db",
      "--results",
      folder / "results",
      "--die-with-parent",
      "--log-level",
      "warning"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  std::vector<char*> argv;
  argv.reserve(arguments.size() + 1);
  for (std::string& argument : arguments) argv.push_back(argument.data());
  argv.push_back(nullptr);
  if (posix_spawn(&pid_, argv[0], nullptr, nullptr, argv.data(), environ) != 0) pid_ = -1;
}

void ServiceProcess::Kill() {
  if (pid_ <= 0) return;
  kill(pid_, SIGKILL);
  waitpid(pid_, nullptr, 0);
  pid_ = -1;
}

int ServiceProcess::Stop() {
  int status = -1;
  kill(pid_, SIGTERM);
  waitpid(pid_, &status, 0);
  pid_ = -1;
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

bool ServiceProcess::Exited(int& exit_code) {
  int status = -1;
  if (pid_ <= 0 || waitpid(pid_, &status, WNOHANG) != pid_) return false;
  pid_ = -1;
  exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return true;
}

FakeShop::FakeShop(const bus::BusOptions& options)
    : bus_(options),
      submissions_(bus_, bus::kJobSubmission),
      commands_(bus_, bus::kJobCommand),
      health_(WritersOf(bus_, bus::kServiceHealth)),
      tasks_out_(WritersOf(bus_, bus::kTaskStatus)),
      statuses_(bus_, bus::kJobStatus),
      answers_(bus_, bus::kJobCommandAnswer),
      tasks_{bus::Reader<intaglio_StageTask>(bus_, bus::kDiscretizeTask),
             bus::Reader<intaglio_StageTask>(bus_, bus::kSortTask),
             bus::Reader<intaglio_StageTask>(bus_, bus::kEngraveTask)},
      permissions_(bus_, bus::kPermission, kCell),
      chunks_(bus_, bus::kModelChunk),
      healths_(bus_, bus::kServiceHealth),
      credit_(bus_, "fake-discretizer", PartitionOf(intaglio_STAGE_DISCRETIZE)) {}

void FakeShop::Submit(const std::string& submission_uid, const JobSpec& job,
                      std::uint64_t epoch) {
  const std::string text = job.SerializeAsString();
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  intaglio_JobSubmission sample{};
  sample.submission_uid = Borrow(submission_uid);
  sample.epoch = epoch;
  const std::string client = "test@localhost";
  sample.client = Borrow(client);
  Borrow(sample.job, bytes);
  (void)submissions_.Write(sample);
}

void FakeShop::Command(const StatusCopy& job, intaglio_JobCommandKind kind,
                       std::uint64_t number, bool fire_uncertain,
                       const std::string& sender) {
  intaglio_JobCommand sample{};
  sample.sender = Borrow(sender);
  sample.disarm_count = job.disarm_count;
  sample.job_uid = Borrow(job.uid);
  sample.epoch = job.epoch;
  sample.number = number;
  sample.kind = kind;
  sample.fire_uncertain = fire_uncertain;
  sample.basis = intaglio_ARM_BY_PERSON;
  const std::string name = "ann@shop";
  sample.operator_name = Borrow(name);
  (void)commands_.Write(sample);
}

void FakeShop::Accept(const StatusCopy& job, std::uint64_t number) {
  const std::string sender = "ann", name = "ann@shop";
  intaglio_JobCommand sample{};
  sample.sender = Borrow(sender);
  sample.disarm_count = job.disarm_count;
  sample.job_uid = Borrow(job.uid);
  sample.epoch = job.epoch;
  sample.number = number;
  sample.kind = intaglio_COMMAND_ARM;
  sample.accept_breakage = true;
  sample.basis = intaglio_ARM_BY_PERSON;
  sample.operator_name = Borrow(name);
  (void)commands_.Write(sample);
}

std::string FakeShop::FullName(const std::string& instance) const {
  return instance + "-" + bus_.participant_name();
}

std::string FakeShop::ShortNames(std::string_view text) const {
  std::string shorter(text);
  const std::string added = "-" + bus_.participant_name();
  for (std::size_t at; (at = shorter.find(added)) != std::string::npos;) {
    shorter.erase(at, added.size());
  }
  return shorter;
}

void FakeShop::Write(intaglio_Stage stage, const std::string& instance,
                     intaglio_HealthState state, bool dispose) {
  const std::string empty, name = FullName(instance);
  intaglio_ServiceHealth sample{};
  sample.instance = Borrow(name);
  sample.role = kRoles[stage];
  sample.state = state;
  sample.version = Borrow(version_);
  sample.host = sample.job_uid = sample.message = Borrow(empty);
  sample.cell = Borrow(stage == intaglio_STAGE_ENGRAVE ? kCell : empty);
  auto& writer = health_.at(stage);
  (void)(dispose ? writer.Dispose(sample) : writer.Write(sample));
}

void FakeShop::Health(intaglio_Stage stage, const std::string& instance,
                      intaglio_HealthState state) {
  Write(stage, instance, state, false);
}

void FakeShop::Die(intaglio_Stage stage, const std::string& instance) {
  Write(stage, instance, intaglio_HEALTH_READY, true);
}

void FakeShop::Report(const TaskCopy& task, intaglio_Stage stage,
                      intaglio_TaskState state, std::uint64_t done, std::uint64_t total,
                      intaglio_ErrorCode code, const std::string& message,
                      const StageOutcome& outcome) {
  intaglio_TaskStatus sample{};
  sample.job_uid = Borrow(task.job_uid);
  sample.stage = stage;
  sample.part = task.part;
  sample.part_count = task.part_count;
  sample.part_attempt = task.part_attempt;
  sample.attempt = task.attempt;
  const std::string worker = FullName(task.worker);
  sample.worker = Borrow(worker);
  sample.state = state;
  sample.done_count = done;
  sample.total_count = total;
  sample.estimate_ticks = stage == intaglio_STAGE_ENGRAVE ? 4321 : 0;
  sample.error_code = code;
  if (state == intaglio_TASK_PAUSED) sample.pause_reason = intaglio_PAUSE_NOT_ARMED;
  sample.message = Borrow(message);
  const std::string text = outcome.SerializeAsString();
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  Borrow(sample.outcome, bytes);
  (void)tasks_out_.at(stage).Write(sample);
}

void FakeShop::Poll() {
  statuses_.Take([this](const intaglio_JobStatus& status) {
    status_[std::string(View(status.submission_uid))] = {
        std::string(View(status.job_uid)),
        ShortNames(View(status.message)),
        std::string(View(status.result_directory)),
        std::string(View(status.cell)),
        status.epoch,
        status.revision,
        status.estimate_ticks,
        status.attempt,
        status.state,
        status.armed,
        status.disarm_count,
        {},
        std::string(View(status.breakage_accepted_by))};
    for (const intaglio_JobWarning& warning : View(status.warnings)) {
      status_[std::string(View(status.submission_uid))].warnings.push_back(
          WarningOf(warning));
    }
  });
  answers_.Take([this](const intaglio_JobCommandAnswer& answer) {
    answered_[{std::string(View(answer.sender)), answer.number}].push_back(answer.code);
  });
  for (const intaglio_Stage stage :
       {intaglio_STAGE_DISCRETIZE, intaglio_STAGE_SORT, intaglio_STAGE_ENGRAVE}) {
    tasks_.at(stage).Take([&](const intaglio_StageTask& task) {
      TaskCopy& copy = task_.at(stage);
      copy = {};
      copy.worker = ShortNames(View(task.worker));
      copy.job_uid = View(task.job_uid);
      copy.consumer = ShortNames(View(task.consumer));
      copy.attempt = task.attempt;
      copy.part = task.part;
      copy.part_count = task.part_count;
      copy.part_attempt = task.part_attempt;
      copy.input_part_count = task.input_part_count;
      copy.revoked = task.revoked;
      const auto bytes = View(task.frozen_job);
      copy.frozen.ParseFromArray(bytes.data(), static_cast<int>(bytes.size()));
    });
  }
  healths_.Take([this](const intaglio_ServiceHealth& health) {
    if (health.role != intaglio_ROLE_JOB_SERVICE) return;
    job_service_ = {health.state, std::string(View(health.message))};
  });
  permissions_.Take([this](const intaglio_Permission& permission) {
    granted_ = permission.granted;
    fire_uncertain_ = permission.fire_uncertain;
    permission_at_ = std::chrono::steady_clock::now();
    ++permissions_seen_;
  });
}

int FakeShop::AnswerTo(std::uint64_t number, const std::string& sender) {
  const auto& codes = answered_[{sender, number}];
  return Until([&] { return !codes.empty(); }) ? codes.back() : -1;
}

int FakeShop::answers(std::uint64_t number, const std::string& sender) {
  return static_cast<int>(answered_[{sender, number}].size());
}

bool FakeShop::granted() const {
  // The synchronizer's lease: five periods of the job service.
  constexpr auto kLease = std::chrono::milliseconds(250);
  return granted_ && std::chrono::steady_clock::now() - permission_at_ < kLease;
}

bool FakeShop::Until(const std::function<bool()>& condition) {
  return test::Eventually([&] {
    Poll();
    return condition();
  });
}

StatusCopy FakeShop::Status(const std::string& submission_uid) {
  Poll();
  return status_[submission_uid];
}

FakeShop::HealthCopy FakeShop::JobServiceHealth() {
  Poll();
  return job_service_;
}

TaskCopy FakeShop::Task(intaglio_Stage stage) {
  Poll();
  return task_.at(stage);
}

bool FakeShop::ReceiveModels(const TaskCopy& task) {
  const std::string stream = bus::PartStreamName(
      task.job_uid, task.attempt, bus::kModelChunk.name, task.part, task.part_attempt);
  if (stream != stream_) {
    stream_ = stream;
    consumed_ = 0;
    models_.clear();
    (void)credit_.Open(stream, chunks_.guid(), 1);  // the least window: strictly in turns
  }
  bool whole = false;
  chunks_.Take([&](const intaglio_ModelChunk& chunk) {
    if (View(chunk.job_uid) != task.job_uid || chunk.attempt != task.attempt) return;
    if (chunk.part != task.part || chunk.part_attempt != task.part_attempt) return;
    if (chunk.sequence_number != consumed_) return;
    if (chunk.model == models_.size()) models_.emplace_back();
    const auto bytes = View(chunk.bytes);
    models_.back().append(bytes.begin(), bytes.end());
    whole = chunk.last && models_.back().size() == chunk.file_size;
    (void)credit_.Consumed(stream, ++consumed_, true);
  });
  return whole;
}

}  // namespace intaglio::job_service
