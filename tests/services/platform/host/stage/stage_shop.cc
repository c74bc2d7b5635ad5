#include "tests/services/platform/host/stage/stage_shop.h"

#include <algorithm>

#include "engrave/optics/focus.h"
#include "services/job/convert/job_defaults.h"
#include "services/job/files/job_file.h"
#include "services/platform/bus/role_names.h"

namespace intaglio::test {

using bus::Borrow;
using bus::View;

namespace {

void SetPart(intaglio_StageTask& task, host::TaskPart part) {
  task.part = part.index;
  task.part_count = part.count;
  task.part_attempt = part.attempt;
}

}  // namespace

StageShop::StageShop(const std::string& program, intaglio_Stage stage,
                     const bus::Topic<intaglio_StageTask>& tasks)
    : bus_(PrivateBusOptions("", bus::kStageWorkerRole)),
      stage_(stage),
      task_writer_(std::make_unique<bus::Writer<intaglio_StageTask>>(bus_, tasks)),
      health_reader_(bus_, bus::kServiceHealth),
      status_reader_(bus_, bus::kTaskStatus),
      worker_(std::string(INTAGLIO_BIN_DIR "/") + program,
              {"--tag", PrivateTag(), "--die-with-parent", "--log-level", "error"}) {}

void StageShop::Poll() {
  health_reader_.TakeAll(
      [this](const intaglio_ServiceHealth& sample, const bus::SampleOrigin& origin) {
        if (origin.alive && sample.pid == worker_.pid()) {
          instance_ = View(sample.instance);
          health_ = sample.state;
        } else if (!origin.alive && View(sample.instance) == instance_) {
          health_.reset();
        }
      });
  status_reader_.Take([this](const intaglio_TaskStatus& sample) {
    if (sample.stage != stage_ || View(sample.worker) != instance_) return;
    TaskReport report{std::string(View(sample.job_uid)),
                      sample.attempt,
                      {sample.part, sample.part_count, sample.part_attempt},
                      sample.state,
                      sample.done_count,
                      sample.total_count,
                      sample.error_code,
                      std::string(View(sample.message)),
                      {}};
    report.estimate_ticks = sample.estimate_ticks;
    const auto outcome = View(sample.outcome);
    report.outcome.ParseFromArray(outcome.data(), static_cast<int>(outcome.size()));
    reports_.push_back(std::move(report));
  });
}

bool StageShop::AwaitHealth(intaglio_HealthState state) {
  return Eventually([&] { return Poll(), health_ == state; });
}

bool StageShop::AwaitGone() {
  return Eventually([&] { return Poll(), !health_; });
}

void StageShop::Write(intaglio_StageTask task) {
  task.worker = Borrow(instance_);
  task.stage = stage_;
  (void)task_writer_->Write(task);
}

void StageShop::Give(const FrozenJob& job, std::uint32_t attempt,
                     const std::string& consumer, host::TaskPart part,
                     std::uint32_t input_part_count) {
  const std::string serialized = job.SerializeAsString();
  const std::vector<std::uint8_t> bytes(serialized.begin(), serialized.end());
  intaglio_StageTask task{};
  task.job_uid = Borrow(job.job_uid());
  task.attempt = attempt;
  task.consumer = Borrow(consumer);
  SetPart(task, part);
  task.input_part_count = input_part_count;
  Borrow(task.frozen_job, bytes);
  Write(task);
}

void StageShop::GiveBytes(const std::string& job_uid, std::uint32_t attempt,
                          const std::string& frozen_job) {
  const std::vector<std::uint8_t> bytes(frozen_job.begin(), frozen_job.end());
  intaglio_StageTask task{};
  task.job_uid = Borrow(job_uid);
  task.attempt = attempt;
  SetPart(task, {});
  Borrow(task.frozen_job, bytes);
  Write(task);
}

void StageShop::Revoke(const std::string& job_uid, std::uint32_t attempt,
                       host::TaskPart part) {
  intaglio_StageTask task{};
  task.job_uid = Borrow(job_uid);
  task.attempt = attempt;
  SetPart(task, part);
  task.revoked = true;
  Write(task);
}

std::optional<TaskReport> StageShop::Find(const std::string& job_uid, host::TaskPart part,
                                          intaglio_TaskState state) {
  Poll();
  for (const TaskReport& report : reports_) {
    if (report.job_uid == job_uid && report.part.index == part.index &&
        report.part.attempt == part.attempt && report.state == state) {
      return report;
    }
  }
  return std::nullopt;
}

std::optional<TaskReport> StageShop::AwaitReport(
    const std::string& job_uid, const std::function<bool(const TaskReport&)>& enough) {
  std::optional<TaskReport> found;
  const bool there = Eventually(
      [&] {
        Poll();
        for (const TaskReport& report : reports_) {
          if (report.job_uid == job_uid && enough(report)) return found = report, true;
        }
        return false;
      },
      std::chrono::seconds(20));
  return there ? found : std::nullopt;
}

std::optional<TaskReport> StageShop::AwaitEnd(const std::string& job_uid,
                                              std::uint32_t attempt,
                                              host::TaskPart part) {
  return AwaitReport(job_uid, [attempt, part](const TaskReport& report) {
    return report.attempt == attempt && report.part.index == part.index &&
           report.part.attempt == part.attempt &&
           (report.state == intaglio_TASK_DONE || report.state == intaglio_TASK_FAILED);
  });
}

FrozenJob FrozenJobOf(const std::string& job_uid, JobSpec spec) {
  const auto machine =
      ReadMachineFile(INTAGLIO_SOURCE_DIR "/deploy/machines/els-03.textproto");
  FrozenJob job;
  job.set_job_uid(job_uid);
  *job.mutable_machine() = machine.value();
  *job.mutable_job() = WithDefaults(std::move(spec), machine.value());
  job.mutable_optics()->set_cone_tangent(0.1);
  job.mutable_optics()->set_stage_per_glass_ratio(0.65);
  return job;
}

bool FeedModels(bus::Bus& bus, const std::string& job_uid, std::uint32_t attempt,
                const std::vector<std::string>& files, host::TaskPart part) {
  constexpr std::size_t kChunk = 1000;
  bus::Writer<intaglio_ModelChunk> writer(bus, bus::kModelChunk);
  bus::CreditBook credit(bus);
  const std::string stream = bus::PartStreamName(job_uid, attempt, bus::kModelChunk.name,
                                                 part.index, part.attempt);
  std::uint64_t number = 0;
  bus::CreditBook::Grant grant;
  const auto period = [&] { return credit.Poll(), grant = credit.Find(stream), grant; };
  if (!Eventually([&] { return period().open && writer.IsMatched(grant.reader); })) {
    return false;
  }
  for (std::uint32_t model = 0; model < files.size(); ++model) {
    const std::string& file = files[model];
    for (std::size_t offset = 0; offset == 0 || offset < file.size(); offset += kChunk) {
      const std::string piece = file.substr(offset, kChunk);
      const std::vector<std::uint8_t> bytes(piece.begin(), piece.end());
      intaglio_ModelChunk chunk{};
      chunk.job_uid = Borrow(job_uid);
      chunk.attempt = attempt;
      chunk.part = part.index;
      chunk.part_attempt = part.attempt;
      chunk.model = model;
      chunk.offset = offset;
      chunk.file_size = file.size();
      chunk.last = model + 1 == files.size() && offset + bytes.size() == file.size();
      Borrow(chunk.bytes, bytes);
      chunk.sequence_number = number;
      if (!Eventually([&] { return number < period().limit || grant.cancelled; }))
        return false;
      if (grant.cancelled || !writer.Write(chunk)) return false;
      ++number;
    }
  }
  // The writer may go when nothing of it is left to be taken.
  return Eventually([&] { return period().consumed == number || grant.cancelled; }) &&
         grant.consumed == number;
}

FrozenJob CellJobOf(const std::string& job_uid, const MachineSpec& machine,
                    const Vec3& block_mm) {
  JobSpec spec;
  Vector3& size = *spec.mutable_block()->mutable_size_mm();
  size.set_x(block_mm.x());
  size.set_y(block_mm.y());
  size.set_z(block_mm.z());
  FrozenJob job = FrozenJobOf(job_uid, spec);
  *job.mutable_machine() = machine;
  const double index = 1.5195, aperture = job.job().lens().numerical_aperture();
  OpticalValuesRecord& optics = *job.mutable_optics();
  optics.set_wavelength_nm(job.job().laser().wavelength_nm());
  optics.set_numerical_aperture(aperture);
  optics.set_refractive_index(index);
  optics.set_stage_per_glass_ratio(optics::StagePerGlassRatio(index, aperture));
  optics.set_cone_tangent(optics::ConeTangentInGlass(index, aperture));
  return job;
}

}  // namespace intaglio::test
