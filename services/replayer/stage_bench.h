#pragma once

// A test bench for one service: everything around it is played from a recording. One task
// at a time.

#include <chrono>
#include <functional>
#include <memory>
#include <string>

#include "services/platform/bus/flow.h"
#include "services/replayer/rehearsal.h"
#include "services/replayer/stage_input.h"

namespace intaglio::replayer {

class StageBench {
 public:
  using Sink = std::function<void(CloudBatch&& batch)>;
  virtual ~StageBench() = default;

  /// Waits for the service; its software version. kTimedOut.
  virtual Result<std::string> FindService(const KeepOn& keep_on) = 0;
  /// Gives the task under the name `job_uid`, and passes its results on. Returns the
  /// reason when it failed; empty when it was done.
  virtual Result<std::string> Perform(const RecordedTask& task,
                                      const std::string& job_uid, const Sink& sink,
                                      const KeepOn& keep_on) = 0;
};

/// `models`: a stream of each job's models that is whole; for kDiscretize.
std::unique_ptr<StageBench> MakeBench(bus::Bus& bus, const recording::McapReader& reader,
                                      Stage stage,
                                      std::map<std::string, StreamId> models);

}  // namespace intaglio::replayer
