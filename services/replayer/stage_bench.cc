#include "services/replayer/stage_bench.h"

#include <fmt/format.h>

#include <vector>

#include "engrave/core/try.h"
#include "services/platform/bus/error_code.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"
#include "services/replayer/found_service.h"

namespace intaglio::replayer {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr std::uint32_t kPointWindowBatches = 32;
// A service that computes publishes its progress ten times a second.
constexpr auto kPatience = 60s;
constexpr auto kTurn = 5ms;

/// Output is what the stage writes: points of a discretizer, a path of a sorter.
template <typename Batch>
class Bench final : public StageBench {
 public:
  Bench(bus::Bus& bus, const recording::McapReader& reader, Stage stage,
        std::map<std::string, StreamId> models)
      : reader_(reader),
        sort_(stage == Stage::kSort),
        models_(std::move(models)),
        output_topic_(topic()),
        output_(bus, topic()),
        tasks_(bus, sort_ ? bus::kSortTask : bus::kDiscretizeTask),
        health_(bus, bus::kServiceHealth),
        status_(bus, bus::kTaskStatus),
        grantor_(bus, kOwnName,
                 sort_ ? bus::RolePartition(bus::CellRole("replay"))
                       : bus::RolePartition(bus::kStageWorkerRole)),
        book_(bus),
        wait_(bus) {
    if (sort_) {
      points_ = std::make_unique<bus::Writer<intaglio_PointBatch>>(bus, bus::kPointBatch);
    } else {
      chunks_ = std::make_unique<bus::Writer<intaglio_ModelChunk>>(bus, bus::kModelChunk);
    }
    wait_.Attach(output_);
    wait_.Attach(status_);
    wait_.Attach(book_.reader());
  }

  Result<std::string> FindService(const KeepOn& keep_on) override;
  Result<std::string> Perform(const RecordedTask& task, const std::string& job_uid,
                              const Sink& sink, const KeepOn& keep_on) override;

 private:
  struct Running {
    const RecordedTask& task;
    const std::string& job_uid;
    std::string stream;
    std::uint64_t taken = 0;
    bool all_taken = false, ended = false;
    std::string failure = {};
    Clock::time_point moved_at = Clock::now();
  };
  static const bus::Topic<Batch>& topic();
  std::unique_ptr<StageInput> InputOf(const RecordedTask& task,
                                      const std::string& job_uid);
  Status Give(const RecordedTask& task, const std::string& job_uid);
  void TakeOutput(Running& running, const Sink& sink);
  void TakeStatus(Running& running);

  const recording::McapReader& reader_;
  bool sort_;
  std::map<std::string, StreamId> models_;
  const bus::Topic<Batch>& output_topic_;
  std::string instance_;
  bus::Reader<Batch> output_;
  bus::Writer<intaglio_StageTask> tasks_;
  bus::Reader<intaglio_ServiceHealth> health_;
  bus::Reader<intaglio_TaskStatus> status_;
  std::unique_ptr<bus::Writer<intaglio_PointBatch>> points_;
  std::unique_ptr<bus::Writer<intaglio_ModelChunk>> chunks_;
  bus::CreditGrantor grantor_;
  bus::CreditBook book_;
  bus::WaitSet wait_;
};

template <>
const bus::Topic<intaglio_PointBatch>& Bench<intaglio_PointBatch>::topic() {
  return bus::kPointBatch;
}
template <>
const bus::Topic<intaglio_PathBatch>& Bench<intaglio_PathBatch>::topic() {
  return bus::kPathBatch;
}

template <typename Batch>
CloudBatch Copied(const Batch& sample) {
  CloudBatch batch;
  batch.id = {std::string(bus::View(sample.job_uid)), sample.attempt, sample.part,
              sample.part_attempt};
  batch.part_count = sample.part_count;
  batch.sequence_number = sample.sequence_number;
  batch.first_index = sample.first_index;
  batch.total_count = sample.total_count;
  batch.last = sample.last;
  const auto copy = [](const auto& sequence, auto& values) {
    const auto view = bus::View(sequence);
    values.assign(view.begin(), view.end());
  };
  copy(sample.x_mm, batch.x_mm);
  copy(sample.y_mm, batch.y_mm);
  copy(sample.z_mm, batch.z_mm);
  copy(sample.source, batch.source);
  return batch;
}

template <typename Batch>
Result<std::string> Bench<Batch>::FindService(const KeepOn& keep_on) {
  auto found = INTAGLIO_TRY(AwaitService(
      health_, wait_, sort_ ? intaglio_ROLE_SORTER : intaglio_ROLE_DISCRETIZER, keep_on));
  instance_ = found.instance;
  return found.version;
}

template <typename Batch>
std::unique_ptr<StageInput> Bench<Batch>::InputOf(const RecordedTask& task,
                                                  const std::string& job_uid) {
  if (sort_) return std::make_unique<PointInput>(*points_, reader_, task, job_uid);
  StreamId played = task.id;
  played.job_uid = job_uid;
  return std::make_unique<ModelInput>(*chunks_, reader_, models_.at(task.id.job_uid),
                                      played);
}

template <typename Batch>
Status Bench<Batch>::Give(const RecordedTask& task, const std::string& job_uid) {
  const std::vector<char> job(task.frozen_job.begin(), task.frozen_job.end());
  intaglio_StageTask sample{};
  sample.worker = bus::Borrow(instance_);
  sample.epoch = task.epoch;
  sample.job_uid = bus::Borrow(job_uid);
  sample.attempt = task.id.attempt;
  sample.stage = sort_ ? intaglio_STAGE_SORT : intaglio_STAGE_DISCRETIZE;
  sample.part = task.id.part;
  sample.part_count = task.part_count;
  sample.part_attempt = task.id.part_attempt;
  sample.input_part_count = task.input_part_count;
  bus::Borrow(sample.frozen_job, job);
  const std::string consumer = kOwnName;
  sample.consumer = bus::Borrow(consumer);
  return tasks_.Write(sample);
}

template <typename Batch>
void Bench<Batch>::TakeOutput(Running& running, const Sink& sink) {
  output_.Take([&](const Batch& sample) {
    CloudBatch batch = Copied(sample);
    if (batch.id.job_uid != running.job_uid ||
        batch.id.attempt != running.task.id.attempt ||
        batch.id.part != running.task.id.part ||
        batch.id.part_attempt != running.task.id.part_attempt)
      return;
    running.all_taken = running.all_taken || batch.last;
    running.moved_at = Clock::now();
    (void)grantor_.Consumed(running.stream, ++running.taken, batch.last);
    batch.id.job_uid = running.task.id.job_uid;
    sink(std::move(batch));
  });
}

template <typename Batch>
void Bench<Batch>::TakeStatus(Running& running) {
  status_.Take([&](const intaglio_TaskStatus& sample) {
    if (bus::View(sample.job_uid) != running.job_uid ||
        bus::View(sample.worker) != instance_ || sample.part != running.task.id.part ||
        sample.attempt != running.task.id.attempt ||
        sample.part_attempt != running.task.id.part_attempt)
      return;
    running.moved_at = Clock::now();
    running.ended =
        sample.state == intaglio_TASK_DONE || sample.state == intaglio_TASK_FAILED;
    if (sample.state == intaglio_TASK_FAILED)
      running.failure = fmt::format("{}: {}", bus::NameOf(sample.error_code),
                                    bus::View(sample.message));
  });
}

template <typename Batch>
Result<std::string> Bench<Batch>::Perform(const RecordedTask& task,
                                          const std::string& job_uid, const Sink& sink,
                                          const KeepOn& keep_on) {
  Running running{task, job_uid,
                  bus::PartStreamName(job_uid, task.id.attempt, output_topic_.name,
                                      task.id.part, task.id.part_attempt)};
  const auto input = InputOf(task, job_uid);
  INTAGLIO_TRY(grantor_.Open(running.stream, output_.guid(), kPointWindowBatches));
  INTAGLIO_TRY(Give(task, job_uid));
  while (!running.ended || (running.failure.empty() && !running.all_taken)) {
    INTAGLIO_TRY(keep_on());
    if (Clock::now() - running.moved_at > kPatience)
      return Fail(ErrorCode::kTimedOut, "the service does not continue");
    book_.Poll();
    INTAGLIO_TRY(input->Advance(book_));
    TakeOutput(running, sink);
    TakeStatus(running);
    (void)wait_.Wait(kTurn);
  }
  (void)grantor_.Close(running.stream);
  return running.failure;
}

}  // namespace

std::unique_ptr<StageBench> MakeBench(bus::Bus& bus, const recording::McapReader& reader,
                                      Stage stage,
                                      std::map<std::string, StreamId> models) {
  if (stage == Stage::kSort)
    return std::make_unique<Bench<intaglio_PathBatch>>(bus, reader, stage,
                                                       std::move(models));
  return std::make_unique<Bench<intaglio_PointBatch>>(bus, reader, stage,
                                                      std::move(models));
}

}  // namespace intaglio::replayer
