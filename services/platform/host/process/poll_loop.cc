#include "services/platform/host/process/poll_loop.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <semaphore>
#include <thread>
#include <vector>

#include "engrave/core/check.h"

namespace intaglio::host {

struct PollLoop::Impl {
  explicit Impl(bus::Bus& bus)
      : wait_set(bus), event_fd(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
    Require(event_fd >= 0, "eventfd failed with errno {}", errno);
  }
  ~Impl() { close(event_fd); }

  void Signal() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = write(event_fd, &one, sizeof one);
  }

  bus::WaitSet wait_set;
  int event_fd;
  std::binary_semaphore loop_waits{0};
  bool helper_is_armed = false;  // used by the loop's thread alone
  std::vector<pollfd> polled;
  std::jthread helper;
};

PollLoop::PollLoop(bus::Bus& bus) : impl_(std::make_unique<Impl>(bus)) {
  impl_->helper = std::jthread([impl = impl_.get()](const std::stop_token& stop) {
    for (;;) {
      impl->loop_waits.acquire();
      while (!stop.stop_requested() &&
             !impl->wait_set.Wait(std::chrono::milliseconds(1000))) {
      }
      if (stop.stop_requested()) return;
      impl->Signal();
    }
  });
}

PollLoop::~PollLoop() {
  impl_->helper.request_stop();
  impl_->wait_set.Wake();
  impl_->loop_waits.release();
  impl_->helper.join();
}

bus::WaitSet& PollLoop::wait_set() { return impl_->wait_set; }

void PollLoop::Wait(std::span<const int> fds, std::chrono::milliseconds timeout) {
  if (!impl_->helper_is_armed) {
    impl_->helper_is_armed = true;
    impl_->loop_waits.release();
  }
  impl_->polled.assign(1, {impl_->event_fd, POLLIN, 0});
  for (const int fd : fds) {
    if (fd >= 0) impl_->polled.push_back({fd, POLLIN, 0});
  }
  poll(impl_->polled.data(), impl_->polled.size(), static_cast<int>(timeout.count()));
  std::uint64_t signals = 0;
  if ((impl_->polled[0].revents & POLLIN) != 0 &&
      read(impl_->event_fd, &signals, sizeof signals) == sizeof signals) {
    impl_->helper_is_armed = false;
  }
}

void PollLoop::Wake() { impl_->wait_set.Wake(); }

}  // namespace intaglio::host
