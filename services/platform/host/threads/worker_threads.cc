#include "services/platform/host/threads/worker_threads.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace intaglio::host {
namespace {

void RunOnThreads(std::size_t threads, std::size_t count,
                  const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next = 0;
  std::exception_ptr thrown;
  std::mutex mutex;
  const auto take = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        work(i);
      } catch (...) {
        const std::lock_guard lock(mutex);
        thrown = std::current_exception();
        next = count;
      }
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < std::min(threads, count); ++i) {
      others.emplace_back([&take] {
        GiveWay();
        take();
      });
    }
    take();
  }
  if (thrown) std::rethrow_exception(thrown);
}

}  // namespace

Executor OnThreads(std::size_t threads) {
  return [threads](std::size_t count, const std::function<void(std::size_t)>& work) {
    RunOnThreads(threads, count, work);
  };
}

Executor AllCores() {
  return OnThreads(std::max(1U, std::thread::hardware_concurrency()));
}

// Both apply to this thread alone, as Linux defines it; when refused, nothing is lost. In
// real time a nice value has no effect, and a computation would never be interrupted by
// threads of the same priority.
void GiveWay() {
  constexpr int kNice = 10;
  (void)setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
  const int policy = sched_getscheduler(0);
  sched_param of_process{};
  const bool real_time = (policy & ~SCHED_RESET_ON_FORK) == SCHED_FIFO ||
                         (policy & ~SCHED_RESET_ON_FORK) == SCHED_RR;
  if (!real_time || sched_getparam(getpid(), &of_process) != 0) return;
  const sched_param behind{
      std::max(sched_get_priority_min(SCHED_RR), of_process.sched_priority - 1)};
  (void)sched_setparam(0, &behind);
}

std::function<double()> ShareOfTime(double seconds) {
  const auto began = std::chrono::steady_clock::now();
  return [began, seconds] {
    const std::chrono::duration<double> used = std::chrono::steady_clock::now() - began;
    return used.count() / seconds;
  };
}

}  // namespace intaglio::host
