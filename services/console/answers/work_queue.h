#pragma once

// A thread of its own for work that may wait for a disk or computes for long: neither a
// stop nor a status waits for it.

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace intaglio::console {

class WorkQueue {
 public:
  explicit WorkQueue(std::size_t max_waiting);
  /// Work that has not begun is dropped.
  ~WorkQueue();

  /// From any thread. False: too much work waits already.
  bool Add(std::function<void()> work);

 private:
  void Run(const std::stop_token& stop);

  const std::size_t max_waiting_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<std::function<void()>> work_;
  std::jthread thread_;
};

}  // namespace intaglio::console
