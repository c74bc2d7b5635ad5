
#include "engrave/core/try.h"
#include "services/discretizer/discretize_job.h"
#include "services/discretizer/kept_job.h"
#include "services/discretizer/model_intake.h"
#include "services/job/convert/model_kind.h"
#include "services/job/fields/job_kind.h"
#include "services/job/marks/mark_maker.h"
#include "services/job/models/program_limits.h"
#include "services/job/models/read_limits.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/command_line/program.h"
#include "services/platform/host/process/service_host.h"
#include "services/platform/host/stage/stage_output.h"
#include "services/platform/host/threads/worker_threads.h"

namespace {

using namespace intaglio;

/// The job service's model files, for the first part of a job alone.
class ModelInput final : public host::StageInput {
 public:
  ModelInput(bus::Bus& bus, const std::string& instance, const ReadLimits& limits,
             Executor executor)
      : limits_(limits), intake_(bus, instance, limits), executor_(std::move(executor)) {}

  Status Open(const host::StageTask& task) override {
    kept_.Begin(task.job_uid, task.attempt);
    if (kept_.holds_job()) return {};
    const JobSpec& job = task.job.job();
    return intake_.Open(task.job_uid, task.attempt, task.part,
                        (MakesMarks(job) ? MarkFilesOf(job) : FilesOf(job)).size());
  }
  Result<bool> Poll(TimePoint now) override {
    kept_.DropWhenOld(now);
    const auto taken = intake_.Poll();
    return taken ? *taken || kept_.holds_job() : taken;
  }
  void Close(bool withdrawn, TimePoint now) override {
    intake_.Close();
    kept_.End(withdrawn, now);
  }
  host::Computation<host::StageResult>::Function TakeComputation(
      const host::StageTask& task) override {
    if (MakesMarks(task.job.job())) {
      return [job = task.job, limits = limits_,
              files = intake_.TakeFiles()](const ProgressSink& progress) mutable {
        return discretizer::MakeMarksOf(job, std::move(files), limits, progress);
      };
    }
    return [job = task.job, part = task.part, kept = kept_.slot(), executor = executor_,
            limits = limits_, files = intake_.TakeFiles()](
               const ProgressSink& progress) mutable -> Result<host::StageResult> {
      if (*kept == nullptr) {
        auto prepared = INTAGLIO_TRY(
            discretizer::PrepareJob(job, std::move(files), limits, progress));
        *kept = std::move(prepared);
      }
      return discretizer::DiscretizePart(**kept, {part.index, part.count}, executor,
                                         progress);
    };
  }
  bus::Reader<intaglio_ModelChunk>& reader() { return intake_.reader(); }

 private:
  ReadLimits limits_;
  discretizer::ModelIntake intake_;
  Executor executor_;
  discretizer::KeptJob<std::shared_ptr<const discretizer::PreparedJob>> kept_;
};

int Serve(host::ServiceHost& host, const ReadLimits& limits, std::size_t threads) {
  ModelInput input(host.bus(), host.instance(), limits,
                   threads == 0 ? host::AllCores() : host::OnThreads(threads));
  host::CloudOrMarkOutput<intaglio_PointBatch> output(
      host.bus(), bus::kPointBatch, bus::kMarkBatch,
      bus::RolePartition(bus::kStageWorkerRole));
  bus::WaitSet wait(host.bus());
  wait.Attach(input.reader());
  output.AttachTo(wait);
  host::StageWorker worker(host, bus::kDiscretizeTask, intaglio_STAGE_DISCRETIZE, input,
                           output, [&wait] { wait.Wake(); });
  return host::RunStageWorker(host, wait, worker);
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t threads = 0;
  double size_limits = 1;
  const host::ServiceDescription description{
      intaglio_ROLE_DISCRETIZER, "discretizer", "makes points from the models of a job",
      [&](command_line::Command app) {
        app.AddOption("--threads", threads,
                      "number of computing threads; default all cores")
            .Within(1, 1024);
        app.AddOption("--size-limits", size_limits,
                      "factor on the size limits of files, pictures, meshes and clouds "
                      "(docs/jobs.md)")
            .FromEnvironment(kSizeLimitsVariable)
            .Within(kMinSizeLimits, kGreatestSizeLimits)
            .ShowDefault();
      }};
  return host::RunService(description, argc, argv, [&](host::ServiceHost& host) {
    return Serve(host, mesh_reader::LimitsOfProgram(size_limits), threads);
  });
}
