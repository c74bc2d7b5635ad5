#pragma once

// Reads the points and the results of jobs in a thread of its own: neither a stop nor a
// status waits for a disk. A plan is in memory once, however many pages it is sent to;
// the last one is kept. While plans are sent, another one is read only when all of them
// take 64 MB at most, so that slow readers of many jobs do not fill the memory.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"
#include "services/console/answers/work_queue.h"

namespace intaglio::console {

class CloudReader {
 public:
  using Bytes = std::shared_ptr<const std::string>;
  /// Called in the reader's thread.
  using Answer = std::function<void(Result<Bytes>)>;

  // From any thread. False: too many requests wait already.
  bool AskForPlan(std::filesystem::path folder, Answer answer);
  /// `made`, `ticks` or `channels` (job_cloud.h).
  bool AskForPart(std::string name, std::filesystem::path folder, std::uint32_t from,
                  Answer answer);
  static bool IsPart(std::string_view name);
  bool Ask(std::function<void()> read) { return queue_.Add(std::move(read)); }
  /// All of a file, up to 64 MB.
  bool AskForFile(std::filesystem::path file, Answer answer);

 private:
  struct Sent {
    std::filesystem::path folder;
    std::filesystem::file_time_type written;
    std::weak_ptr<const std::string> bytes;
  };
  /// kRefused: other plans are being sent.
  Result<Bytes> Plan(const std::filesystem::path& folder);

  static constexpr std::size_t kMaxWaiting = 32;
  // In the queue's thread.
  std::vector<Sent> sent_;
  Bytes kept_;
  WorkQueue queue_{kMaxWaiting};
};

}  // namespace intaglio::console
