#pragma once

// A computation in a thread of its own, with its progress, its cancellation and its
// result. All members are for one thread; what happens in the computation's thread is
// behind the atomics and the future.

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <future>
#include <new>
#include <thread>
#include <utility>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::host {

template <typename T>
class Computation {
 public:
  using Function = std::function<Result<T>(const ProgressSink&)>;

  /// Starts at once. `wake` is called from the other thread when the result is there.
  Computation(Function compute, std::function<void()> wake)
      : thread_([this, compute = std::move(compute), wake = std::move(wake)]() mutable {
          GiveWay();
          auto result = Guarded(compute);
          compute = nullptr;  // and with it what it has captured: the input
          promise_.set_value(std::move(result));
          wake();
        }) {}
  /// Asks for the end and waits for it.
  ~Computation() { Cancel(); }
  Computation(const Computation&) = delete;
  Computation& operator=(const Computation&) = delete;

  void Cancel() { cancelled_ = true; }
  bool ready() const {
    return future_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  /// Once, when ready. An exception has become an Error.
  Result<T> Take() { return future_.get(); }
  std::uint64_t done() const { return done_; }
  std::uint64_t total() const { return total_; }

 private:
  Result<T> Guarded(const Function& compute) {
    try {
      return compute([this](std::uint64_t done, std::uint64_t total) {
        done_ = done;
        total_ = total;
        return !cancelled_;
      });
    } catch (const std::bad_alloc&) {
      return Fail(ErrorCode::kTooLarge, "the job needs more memory than is available");
    } catch (const std::exception& error) {
      return Fail(ErrorCode::kFault, std::string("internal error: ") + error.what());
    }
  }

  std::atomic<bool> cancelled_{false};
  std::atomic<std::uint64_t> done_{0}, total_{0};
  std::promise<Result<T>> promise_;
  std::future<Result<T>> future_ = promise_.get_future();
  std::jthread thread_;  // the last member: it is joined before the others go
};

}  // namespace intaglio::host
