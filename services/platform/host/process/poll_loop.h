#pragma once

// Lets one thread wait for DDS readers and file descriptors (serial lines, events) at
// once. A helper thread waits on the DDS wait set and hands each wake-up over through an
// eventfd; it waits again only when the loop does, so that unread samples do not make it
// spin.

#include <chrono>
#include <memory>
#include <span>

#include "services/platform/bus/bus.h"

namespace intaglio::host {

class PollLoop {
 public:
  explicit PollLoop(bus::Bus& bus);
  ~PollLoop();

  template <typename T>
  void Attach(bus::Reader<T>& reader) {
    wait_set().Attach(reader);
  }

  /// Until a reader has something, one of `fds` is readable or hung up (-1 entries are
  /// passed over), Wake is called, or the time is up. From one thread.
  void Wait(std::span<const int> fds, std::chrono::milliseconds timeout);

  /// From any thread: the next or current Wait returns.
  void Wake();

 private:
  bus::WaitSet& wait_set();
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace intaglio::host
