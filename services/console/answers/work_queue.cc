#include "services/console/answers/work_queue.h"

#include <utility>

namespace intaglio::console {

WorkQueue::WorkQueue(std::size_t max_waiting)
    : max_waiting_(max_waiting),
      thread_([this](const std::stop_token& stop) { Run(stop); }) {}

WorkQueue::~WorkQueue() {
  thread_.request_stop();
  thread_.join();
}

bool WorkQueue::Add(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    if (work_.size() >= max_waiting_) return false;
    work_.push_back(std::move(work));
  }
  changed_.notify_one();
  return true;
}

void WorkQueue::Run(const std::stop_token& stop) {
  for (;;) {
    std::function<void()> work;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return !work_.empty(); })) return;
      work = std::move(work_.front());
      work_.pop_front();
    }
    work();
  }
}

}  // namespace intaglio::console
