#pragma once

// The clock of this computer, and a wait on it that is as exact as the system allows.

#include <chrono>
#include <utility>

#include "services/reference_controller/controller.h"

namespace intaglio::reference_controller {

/// The waits between the turns of a thread that has something to do every 10 us. The
/// kernel holds a real-time thread that never sleeps for 50 ms of each second
/// (kernel.sched_rt_runtime_us), so this sleeps 60 us of each millisecond, and in between
/// reads the clock.
class TurnWait {
 public:
  explicit TurnWait(ControllerTime time) : time_(std::move(time)) {}
  void WaitFor(std::chrono::nanoseconds idle);

 private:
  ControllerTime time_;
  std::chrono::nanoseconds slept_at_{0};
};

/// Sleeps up to 100 us before the time, and then reads the clock until it has come.
ControllerTime ExactTime();

}  // namespace intaglio::reference_controller
