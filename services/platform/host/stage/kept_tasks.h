#pragma once

// Which TaskStatus instances of a worker stay on the bus: those of its newest tasks. The
// job service that was away and clients that come late read them there; older ones are
// disposed, so that a worker that runs for years holds no more than one of a day.

#include <algorithm>
#include <cstdint>
#include <deque>
#include <string>
#include <utility>

#include "services/platform/bus/bus.h"
#include "services/platform/bus/samples.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::host {

/// Not for use by two threads at once.
class KeptTasks {
 public:
  /// Two chains of parts: the one at work and the one before it, which a client that
  /// comes late may ask for.
  static constexpr std::size_t kKept = 2 * kMaxParts;

  KeptTasks(std::string worker, intaglio_Stage stage)
      : worker_(std::move(worker)), stage_(stage) {}

  /// Before a status of the task is written; disposes the oldest beyond kKept.
  void Keep(bus::Writer<intaglio_TaskStatus>& writer, const std::string& job_uid,
            std::uint32_t part) {
    const std::pair task(job_uid, part);
    if (std::find(kept_.rbegin(), kept_.rend(), task) != kept_.rend()) return;
    kept_.push_back(task);
    if (kept_.size() <= kKept) return;
    intaglio_TaskStatus sample{};
    sample.job_uid = bus::Borrow(kept_.front().first);
    sample.stage = stage_;
    sample.worker = bus::Borrow(worker_);
    sample.part = kept_.front().second;
    (void)writer.Dispose(sample);
    kept_.pop_front();
  }

 private:
  std::string worker_;
  intaglio_Stage stage_;
  std::deque<std::pair<std::string, std::uint32_t>> kept_;  // oldest first
};

}  // namespace intaglio::host
