#include "services/discretizer/discretize_job.h"
#include "services/host/cloud_output.h"
#include "services/host/service_host.h"

namespace {

using namespace intaglio;

/// The job service's model files.
class ModelInput final : public host::StageInput {
 public:
  ModelInput(bus::Bus& bus, const std::string& instance) : intake_(bus, instance) {}

  Status Open(const host::StageTask& task) override {
    return intake_.Open(task.job_uid, task.attempt,
                        static_cast<std::size_t>(task.job.job().models_size()));
  }
  Result<bool> Poll() override { return intake_.Poll(); }
  void Close() override { intake_.Close(); }
  host::Computation<host::StageResult>::Function TakeComputation(
      const host::StageTask& task) override {
    return [job = task.job,
            files = intake_.TakeFiles()](const ProgressSink& progress) mutable {
      return discretizer::DiscretizeJob(job, std::move(files), progress);
    };
  }
  bus::Reader<intaglio_ModelChunk>& reader() { return intake_.reader(); }

 private:
  discretizer::ModelIntake intake_;
};

int Serve(host::ServiceHost& host) {
  ModelInput input(host.bus(), host.instance());
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
  return host::RunService({.role = intaglio_ROLE_DISCRETIZER,
                           .name = "discretizer",
                           .purpose = "makes points of the models of a job",
                           .add_options = {}},
                          argc, argv, Serve);
}
