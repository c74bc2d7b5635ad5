#include "services/replayer/rehearsal.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>

#include "engrave/core/try.h"
#include "engrave/io/crc32.h"
#include "services/platform/bus/bus.h"
#include "services/platform/recording/conventions.h"
#include "services/replayer/cause.h"
#include "services/replayer/comparison.h"
#include "services/replayer/option_differences.h"
#include "services/replayer/stage_bench.h"

namespace intaglio::replayer {
namespace {

using Extents = std::map<StreamId, StreamExtent>;

/// Over all bits of the batches, to distinguish two runs.
std::uint32_t Checksum(const CloudBatch& batch, std::uint32_t before) {
  const auto add = [&before](const auto& values) {
    before = io::Crc32(std::as_bytes(std::span(values)), before);
  };
  add(batch.x_mm);
  add(batch.y_mm);
  add(batch.z_mm);
  add(batch.source);
  return before;
}

class Rehearsal {
 public:
  Rehearsal(bus::Bus& bus, const recording::McapReader& reader,
            const RehearsalOptions& options, const KeepOn& keep_on)
      : bus_(bus),
        reader_(reader),
        options_(options),
        keep_on_(keep_on),
        sort_(options.stage == Stage::kSort),
        task_topic_(sort_ ? bus::kSortTask.name : bus::kDiscretizeTask.name),
        input_topic_(sort_ ? bus::kPointBatch.name : bus::kModelChunk.name),
        output_topic_(sort_ ? bus::kPathBatch.name : bus::kPointBatch.name) {}

  Result<ReplayComparison> Run();

 private:
  struct Performed {
    TaskComparison counts;
    std::optional<SampleDifference> first;
    std::uint32_t checksum = 0;
  };
  Status ReadRecording();
  Status ReadTasks();
  bool HasInput(const RecordedTask& task);
  void LogMissing();
  Status ChangeOptions(RecordedTask& task);
  Result<Performed> Perform(const RecordedTask& task, const std::string& job_uid);
  Status FindCause(const RecordedTask& task, const Performed& performed);

  bus::Bus& bus_;
  const recording::McapReader& reader_;
  const RehearsalOptions& options_;
  const KeepOn& keep_on_;
  bool sort_;
  std::string task_topic_, input_topic_, output_topic_;
  std::vector<RecordedTask> tasks_;
  Extents inputs_, outputs_;
  std::map<std::string, StreamId> models_;  // a whole stream, by job
  std::unique_ptr<StageBench> bench_;
  ReplayComparison result_;
};

Status Rehearsal::ReadTasks() {
  std::set<StreamId> known;
  RecordedValues values(reader_, task_topic_);
  for (;;) {
    const auto value = INTAGLIO_TRY(values.Next());
    if (!value) return {};
    auto task = ReadTask(*value);
    if (!task || task->revoked || !outputs_.contains(task->id)) continue;
    if (!known.insert(task->id).second) continue;
    task->log_time_ns = values.log_time_ns();
    tasks_.push_back(std::move(*task));
  }
}

Status Rehearsal::ReadRecording() {
  for (const auto& [topic, extents] :
       {std::pair(&output_topic_, &outputs_), {&input_topic_, &inputs_}}) {
    auto found = INTAGLIO_TRY(ExtentsOf(reader_, *topic));
    *extents = std::move(found);
  }
  if (!sort_) {
    for (const auto& [id, extent] : inputs_) {
      if (extent.whole) models_.try_emplace(id.job_uid, id);
    }
  }
  INTAGLIO_TRY(ReadTasks());
  if (tasks_.empty()) {
    return Fail(ErrorCode::kMissing,
                fmt::format("the recording has no {} whose {} was recorded: nothing to "
                            "compare",
                            task_topic_, output_topic_));
  }
  LogMissing();
  return {};
}

/// The recorder's own samples are not in the file.
void Rehearsal::LogMissing() {
  const auto records = reader_.ReadMetadata(recording::kMissingRecord);
  if (!records) return;
  for (const recording::Metadata& record : *records) {
    const auto entry = [&record](const char* name) {
      const auto found = record.entries.find(name);
      return found == record.entries.end() ? std::string() : found->second;
    };
    if (entry("topic") != input_topic_ && entry("topic") != output_topic_) continue;
    result_.add_input(fmt::format("{} samples of {} were not recorded: {}",
                                  entry("count"), entry("topic"), entry("reason")));
  }
}

bool Rehearsal::HasInput(const RecordedTask& task) {
  const auto lacks = [&](const std::string& what) {
    result_.add_input(fmt::format("{} of job {} is not complete in the recording", what,
                                  task.id.job_uid));
    return false;
  };
  if (!sort_) return models_.contains(task.id.job_uid) || lacks(input_topic_);
  for (std::uint32_t part = 0; part < task.input_part_count; ++part) {
    const bool whole =
        std::any_of(inputs_.begin(), inputs_.end(), [&](const auto& input) {
          const StreamId& id = input.first;
          return id.job_uid == task.id.job_uid && id.attempt == task.id.attempt &&
                 id.part == part && input.second.whole;
        });
    if (!whole) return lacks(fmt::format("part {} of {}", part, input_topic_));
  }
  return true;
}

Status Rehearsal::ChangeOptions(RecordedTask& task) {
  FrozenJob then;
  if (!then.ParseFromString(task.frozen_job)) {
    return Fail(ErrorCode::kUnsupported,
                fmt::format("the job of a recorded {} cannot be read", task_topic_));
  }
  result_.set_version_then(then.software_version());
  if (!options_.change) return {};
  FrozenJob now = then;
  INTAGLIO_TRY(options_.change(now));
  if (result_.options().empty()) {
    for (OptionDifference& difference : OptionDifferences(then, now))
      *result_.add_options() = std::move(difference);
  }
  task.frozen_job = now.SerializeAsString();
  return {};
}

Result<Rehearsal::Performed> Rehearsal::Perform(const RecordedTask& task,
                                                const std::string& job_uid) {
  Performed performed;
  TaskComparison& counts = performed.counts;
  counts.set_job_uid(task.id.job_uid);
  counts.set_attempt(task.id.attempt);
  counts.set_part(task.id.part);
  counts.set_part_attempt(task.id.part_attempt);
  const StreamExtent& extent = outputs_.at(task.id);
  counts.set_recorded_in_part(!extent.whole);
  RecordedValues values(reader_, output_topic_, task.log_time_ns);
  Status damage;
  std::uint64_t number = 0;
  const auto next_then = [&]() -> std::optional<CloudBatch> {
    while (number < extent.count) {
      auto value = values.Next();
      if (!value) damage = tl::unexpected(value.error());
      if (!value || !*value) return std::nullopt;
      auto batch = ReadBatch(**value);
      if (!batch || batch->id != task.id || batch->sequence_number != number) continue;
      ++number;
      return batch;
    }
    return std::nullopt;
  };
  const auto note = [&](const CloudBatch* then, const CloudBatch* now) {
    counts.set_batch_count(counts.batch_count() + 1);
    if (then != nullptr) counts.set_point_count(counts.point_count() + then->x_mm.size());
    auto difference = Compare(then, now);
    if (!difference) return;
    difference->set_topic(output_topic_);
    counts.set_different_batch_count(counts.different_batch_count() + 1);
    if (!performed.first) performed.first = std::move(difference);
  };
  const auto failure = INTAGLIO_TRY(bench_->Perform(
      task, job_uid,
      [&](CloudBatch&& now) {
        performed.checksum = Checksum(now, performed.checksum);
        const auto then = next_then();
        if (then || extent.whole) note(then ? &*then : nullptr, &now);
      },
      keep_on_));
  while (const auto then = next_then()) note(&*then, nullptr);
  if (!damage) return tl::unexpected(damage.error());
  if (!failure.empty() && performed.first)
    performed.first->set_now("none: the task failed, " + failure);
  return performed;
}

/// Searches the first task that made something else.
Status Rehearsal::FindCause(const RecordedTask& task, const Performed& performed) {
  return NameCause(result_, [&]() -> Result<bool> {
    const auto again = INTAGLIO_TRY(Perform(task, task.id.job_uid + "-again"));
    return again.checksum != performed.checksum;
  });
}

Result<ReplayComparison> Rehearsal::Run() {
  result_.set_service(sort_ ? "sorter" : "discretizer");
  INTAGLIO_TRY(ReadRecording());
  bench_ = MakeBench(bus_, reader_, options_.stage, models_);
  const auto version = INTAGLIO_TRY(bench_->FindService(keep_on_));
  result_.set_version_now(version);
  bool all_performed = true;
  std::optional<std::pair<const RecordedTask*, Performed>> different;
  for (RecordedTask& task : tasks_) {
    if (!HasInput(task)) {
      all_performed = false;
      continue;
    }
    INTAGLIO_TRY(ChangeOptions(task));
    auto performed = INTAGLIO_TRY(Perform(task, task.id.job_uid));
    *result_.add_tasks() = performed.counts;
    if (performed.first && !different) different.emplace(&task, std::move(performed));
  }
  result_.set_identical(!different && all_performed);
  if (different) {
    *result_.mutable_first() = *different->second.first;
    if (auto found = FindCause(*different->first, different->second); !found)
      return tl::unexpected(found.error());
  } else if (!all_performed) {
    result_.set_cause("input");
    result_.set_explanation(result_.input(result_.input_size() - 1));
  }
  return std::move(result_);
}

}  // namespace

Result<ReplayComparison> Rehearse(bus::Bus& bus, const recording::McapReader& reader,
                                  const RehearsalOptions& options,
                                  const KeepOn& keep_on) {
  return Rehearsal(bus, reader, options, keep_on).Run();
}

}  // namespace intaglio::replayer
