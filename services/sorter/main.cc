#include <atomic>
#include <memory>

#include "services/job/fields/job_kind.h"
#include "services/platform/bus/role_names.h"
#include "services/platform/host/process/service_host.h"
#include "services/platform/host/stage/flow.h"
#include "services/platform/host/stage/stage_output.h"
#include "services/sorter/sort_job.h"

namespace {

using namespace intaglio;

/// Sixteen megabytes.
constexpr std::size_t kRememberedPoints = 4'000'000;

/// The discretizer's points, or its marks.
class PointOrMarkInput final : public host::StageInput {
 public:
  PointOrMarkInput(bus::Bus& bus, const std::string& instance)
      : points_(bus, instance, bus::kPointBatch),
        marks_(bus, instance, bus::kMarkBatch) {}

  Status Open(const host::StageTask& task) override {
    if (MakesMarks(task.job.job())) return marks_.Open(task.job_uid, task.attempt);
    return points_.Open(task.job_uid, task.attempt, task.input_part_count);
  }
  Result<bool> Poll(TimePoint) override {
    const auto points = points_.Poll();
    const auto marks = marks_.Poll();
    if (!points) return points;
    if (!marks) return marks;
    return *points || *marks;
  }
  void Close(bool, TimePoint) override {
    points_.Close();
    marks_.Close();
  }
  host::Computation<host::StageResult>::Function TakeComputation(
      const host::StageTask& task) override {
    estimate_ticks_ = std::make_shared<std::atomic<std::uint64_t>>(0);
    if (MakesMarks(task.job.job())) {
      return [job = task.job,
              marks = marks_.TakeContent()](const ProgressSink& progress) mutable {
        return sorter::SortMarks(job, std::move(marks), progress);
      };
    }
    return [job = task.job, cloud = points_.TakeContent(), estimate = estimate_ticks_,
            memo = memo_](const ProgressSink& progress) mutable {
      return sorter::SortJob(job, std::move(cloud), *memo, *estimate, progress);
    };
  }
  std::uint64_t estimate_ticks() const override {
    return estimate_ticks_ == nullptr ? 0 : estimate_ticks_->load();
  }
  template <typename WaitSet>
  void AttachTo(WaitSet& wait) {
    wait.Attach(points_.reader());
    wait.Attach(marks_.reader());
  }

 private:
  host::PointIntake points_;
  host::MarkIntake marks_;
  std::shared_ptr<std::atomic<std::uint64_t>> estimate_ticks_;  // of the newest task
  std::shared_ptr<sorter::OrderMemo> memo_ =
      std::make_shared<sorter::OrderMemo>(kRememberedPoints);
};

int Serve(host::ServiceHost& host) {
  PointOrMarkInput input(host.bus(), host.instance());
  host::CloudOrMarkOutput<intaglio_PathBatch> output(
      host.bus(), bus::kPathBatch, bus::kOrderedMarkBatch, bus::AnyCellPartition());
  bus::WaitSet wait(host.bus());
  input.AttachTo(wait);
  output.AttachTo(wait);
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
