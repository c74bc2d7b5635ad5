#pragma once

// Between the thread that receives and the thread that writes. It never makes the former
// wait: a large message is refused when too much waits already, a small one only when the
// process's memory is at stake. Both are counted by their bytes.
//
// Any thread may call anything.

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <utility>
#include <vector>

namespace intaglio::recorder {

struct QueueLimits {
  std::uint64_t large_bytes = 64u << 20;   ///< no more large ones when this much waits
  std::uint64_t total_bytes = 256u << 20;  ///< nor small ones when this much does
};

template <typename Item>
class WriteQueue {
 public:
  explicit WriteQueue(const QueueLimits& limits) : limits_(limits) {}

  /// False: refused, and the item is left as it was.
  bool Push(Item&& item, std::uint64_t bytes, bool large) {
    const std::lock_guard lock(mutex_);
    const std::uint64_t limit = large ? limits_.large_bytes : limits_.total_bytes;
    // One item always fits, however large it is.
    if (waiting_bytes_ > 0 && waiting_bytes_ + bytes > limit) return false;
    items_.push_back(std::move(item));
    waiting_bytes_ += bytes;
    added_bytes_ += bytes;
    arrived_.notify_one();
    return true;
  }

  /// All that waits, after at most `timeout`. Items that were taken before then count as
  /// finished.
  std::vector<Item> Take(std::chrono::milliseconds timeout) {
    std::unique_lock lock(mutex_);
    waiting_bytes_ -= std::exchange(taken_bytes_, 0);
    arrived_.wait_for(lock, timeout, [this] { return !items_.empty(); });
    taken_bytes_ = std::exchange(added_bytes_, 0);
    return std::exchange(items_, {});
  }

 private:
  QueueLimits limits_;
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<Item> items_;
  std::uint64_t waiting_bytes_ = 0;  // in items_ and with the one who took
  std::uint64_t added_bytes_ = 0;    // in items_
  std::uint64_t taken_bytes_ = 0;
};

}  // namespace intaglio::recorder
