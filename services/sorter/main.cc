#include <atomic>
#include <memory>

#include "services/platform/bus/role_names.h"
#include "services/platform/host/process/service_host.h"
#include "services/platform/host/stage/cloud_output.h"
#include "services/sorter/sort_job.h"

namespace {

using namespace intaglio;

/// The discretizer's points.
class PointInput final : public host::StageInput {
 public:
  PointInput(bus::Bus& bus, const std::string& instance)
      : intake_(bus, instance, bus::kPointBatch) {}

  Status Open(const host::StageTask& task) override {
    return intake_.Open(task.job_uid, task.attempt, task.input_part_count);
  }
  Result<bool> Poll(TimePoint) override { return intake_.Poll(); }
  void Close(bool, TimePoint) override { intake_.Close(); }
  host::Computation<host::StageResult>::Function TakeComputation(
      const host::StageTask& task) override {
    estimate_ticks_ = std::make_shared<std::atomic<std::uint64_t>>(0);
    return [job = task.job, cloud = intake_.TakeCloud(),
            estimate = estimate_ticks_](const ProgressSink& progress) mutable {
      return sorter::SortJob(job, std::move(cloud), *estimate, progress);
    };
  }
  std::uint64_t estimate_ticks() const override {
    return estimate_ticks_ == nullptr ? 0 : estimate_ticks_->load();
  }
  bus::Reader<intaglio_PointBatch>& reader() { return intake_.reader(); }

 private:
  host::CloudIntake<intaglio_PointBatch> intake_;
  std::shared_ptr<std::atomic<std::uint64_t>> estimate_ticks_;  // of the newest task
};

int Serve(host::ServiceHost& host) {
  PointInput input(host.bus(), host.instance());
  host::CloudOutput<intaglio_PathBatch> output(host.bus(), bus::kPathBatch,
                                               bus::AnyCellPartition());
  bus::WaitSet wait(host.bus());
  wait.Attach(input.reader());
  wait.Attach(output.reader());
  host::StageWorker worker(host, bus::kSortTask, intaglio_STAGE_SORT, input, output,
                           [&wait] { wait.Wake(); });
  return host::RunStageWorker(host, wait, worker);
}

}  // namespace

int main(int argc, char** argv) {
  return host::RunService(
      {.role = intaglio_ROLE_SORTER,
       .name = "sorter",
       .purpose = "puts the points of a job in the order of engraving",
       .add_options = {}},
      argc, argv, Serve);
}
