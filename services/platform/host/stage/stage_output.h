#pragma once

// What a stage sends to the next one: points, or the marks of a job of marks.

#include <utility>

#include "services/platform/host/stage/flow.h"
#include "services/platform/host/stage/stage_worker.h"

namespace intaglio::host {

template <typename Batch>
class CloudOrMarkOutput final : public StageOutput {
 public:
  CloudOrMarkOutput(bus::Bus& bus, const bus::Topic<Batch>& points,
                    const bus::Topic<intaglio_MarkBatch>& marks,
                    const std::string& consumers)
      : points_(bus, points, consumers), marks_(bus, marks, consumers) {}

  void Begin(const StageTask& task, StageResult result, TimePoint now) override {
    if (result.marks) {
      marks_.Begin(task.job_uid, task.attempt, {.attempt = task.part.attempt},
                   std::move(*result.marks), now);
    } else {
      points_.Begin(task.job_uid, task.attempt, task.part, std::move(result.cloud), now);
    }
  }
  Result<bool> Advance(TimePoint now) override {
    const auto points = points_.Advance(now);
    const auto marks = marks_.Advance(now);
    if (!points) return points;
    if (!marks) return marks;
    return *points && *marks;
  }
  void End() override {
    points_.End();
    marks_.End();
  }
  template <typename WaitSet>
  void AttachTo(WaitSet& wait) {
    wait.Attach(points_.reader());
    wait.Attach(marks_.reader());
  }

 private:
  Sender<PointCodec<Batch>> points_;
  MarkSender marks_;
};

}  // namespace intaglio::host
