#include <CLI/App.hpp>

#include "proto/model_kind.h"
#include "services/discretizer/discretize_job.h"
#include "services/discretizer/kept_job.h"
#include "services/discretizer/model_intake.h"
#include "services/host/cloud_output.h"
#include "services/host/service_host.h"
#include "services/host/worker_threads.h"

namespace {

using namespace intaglio;

/// The job service's model files, for the first part of a job alone.
class ModelInput final : public host::StageInput {
 public:
  ModelInput(bus::Bus& bus, const std::string& instance, Executor executor)
      : intake_(bus, instance), executor_(std::move(executor)) {}

  Status Open(const host::StageTask& task) override {
    kept_.Begin(task.job_uid, task.attempt);
    if (kept_.holds_job()) return {};
    return intake_.Open(task.job_uid, task.attempt, task.part,
                        FilesOf(task.job.job()).size());
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
    return [job = task.job, part = task.part, kept = kept_.slot(), executor = executor_,
            files = intake_.TakeFiles()](
               const ProgressSink& progress) mutable -> Result<host::StageResult> {
      if (*kept == nullptr) {
        auto prepared = discretizer::PrepareJob(job, std::move(files), progress);
        if (!prepared) return tl::unexpected(prepared.error());
        *kept = std::move(*prepared);
      }
      return discretizer::DiscretizePart(**kept, {part.index, part.count}, executor,
                                         progress);
    };
  }
  bus::Reader<intaglio_ModelChunk>& reader() { return intake_.reader(); }

 private:
  discretizer::ModelIntake intake_;
  Executor executor_;
  discretizer::KeptJob<std::shared_ptr<const discretizer::PreparedJob>> kept_;
};

int Serve(host::ServiceHost& host, std::size_t threads) {
  ModelInput input(host.bus(), host.instance(),
                   threads == 0 ? host::AllCores() : host::OnThreads(threads));
  host::CloudOutput<intaglio_PointBatch> output(host.bus(), bus::kPointBatch);
  bus::WaitSet wait(host.bus());
  wait.Attach(input.reader());
  wait.Attach(output.reader());
  host::StageWorker worker(host, bus::kDiscretizeTask, intaglio_STAGE_DISCRETIZE, input,
                           output, [&wait] { wait.Wake(); });
  return host::RunStageWorker(host, wait, worker);
}

}  // namespace

int main(int argc, char** argv) {
  std::size_t threads = 0;
  const host::ServiceDescription description{
      intaglio_ROLE_DISCRETIZER, "discretizer", "makes points of the models of a job",
      [&threads](CLI::App& app) {
        app.add_option("--threads", threads,
                       "threads that compute; all cores when not given")
            ->check(CLI::Range(1, 1024));
      }};
  return host::RunService(description, argc, argv, [&threads](host::ServiceHost& host) {
    return Serve(host, threads);
  });
}
