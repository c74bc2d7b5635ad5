#pragma once

// CloudSender as the output of a stage.

#include <utility>

#include "services/platform/host/stage/cloud_flow.h"
#include "services/platform/host/stage/stage_worker.h"

namespace intaglio::host {

template <typename Batch>
class CloudOutput final : public StageOutput {
 public:
  CloudOutput(bus::Bus& bus, const bus::Topic<Batch>& topic, const std::string& consumers)
      : sender_(bus, topic, consumers) {}

  void Begin(const StageTask& task, PointCloud cloud, TimePoint now) override {
    sender_.Begin(task.job_uid, task.attempt, task.part, std::move(cloud), now);
  }
  Result<bool> Advance(TimePoint now) override { return sender_.Advance(now); }
  void End() override { sender_.End(); }
  bus::Reader<intaglio_Credit>& reader() { return sender_.reader(); }

 private:
  CloudSender<Batch> sender_;
};

}  // namespace intaglio::host
