#pragma once

// The attachments of a job, which are recorded besides its messages: its specification,
// the machine, the material's values, and the software, from the tasks of the job.

#include <deque>
#include <set>
#include <string>
#include <vector>

#include "services/platform/bus/bus.h"
#include "services/platform/recording/mcap_records.h"

namespace intaglio::recorder {

/// Attachments of a task's frozen job (serialized intaglio.FrozenJob); none when it
/// cannot be read. `now_ns` is the time they carry.
std::vector<recording::Attachment> AttachmentsOf(recording::ByteView frozen_job,
                                                 std::uint64_t now_ns);

/// Watches the tasks of all stages. From one thread.
class JobAttachments {
 public:
  explicit JobAttachments(bus::Bus& bus);
  /// The attachments of jobs that are new since the last call.
  std::vector<recording::Attachment> Take(std::uint64_t now_ns);

 private:
  bus::Reader<intaglio_StageTask> discretize_, sort_, engrave_;
  // Jobs, the newest: a task that comes again is of one of these.
  std::set<std::string> known_;
  std::deque<std::string> by_age_;
};

}  // namespace intaglio::recorder
