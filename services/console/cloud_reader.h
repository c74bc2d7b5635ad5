#pragma once

// Reads the points and the results of jobs in a thread of its own: neither a stop nor a
// status waits for a disk. The last plan is kept and shared by all pages.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "engrave/core/result.h"
#include "services/console/work_queue.h"

namespace intaglio::console {

class CloudReader {
 public:
  using Bytes = std::shared_ptr<const std::string>;
  /// Called in the reader's thread.
  using Answer = std::function<void(Result<Bytes>)>;

  // From any thread. False: too many requests wait already.
  bool AskForPlan(std::filesystem::path folder, Answer answer);
  bool AskForMade(std::filesystem::path folder, std::uint32_t from, Answer answer);
  bool Ask(std::function<void()> read) { return queue_.Add(std::move(read)); }
  /// All of a file, up to 64 MB.
  bool AskForFile(std::filesystem::path file, Answer answer);

 private:
  struct Kept {
    std::filesystem::path folder;
    std::filesystem::file_time_type written;
    Bytes bytes;
  };
  Result<Bytes> Plan(const std::filesystem::path& folder);

  static constexpr std::size_t kMaxWaiting = 32;
  Kept kept_;  // in the queue's thread
  WorkQueue queue_{kMaxWaiting};
};

}  // namespace intaglio::console
