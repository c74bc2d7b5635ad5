#pragma once

// How long a process waits for other processes. On a busy computer they are as late as
// the process itself: the time that is waited passes at the share of a core that one
// process can have.

#include <chrono>
#include <cstddef>
#include <functional>

namespace intaglio::host {

/// 1 on a computer with a core to spare; with more processes that want to run than cores,
/// cores / processes (of /proc/loadavg, at this moment). 1 where that cannot be read.
double ShareOfOneProcess();

class Patience {
 public:
  using Clock = std::chrono::steady_clock;
  /// No wait is longer than this by the clock of the wall, or `time` if that is longer.
  static constexpr std::chrono::seconds kLongest{90};

  /// `time`: on a computer that is not busy.
  explicit Patience(std::chrono::milliseconds time,
                    std::function<double()> share = ShareOfOneProcess,
                    std::function<Clock::time_point()> now = Clock::now);

  /// To be asked now and then, at least every second.
  bool IsUp();
  /// The same of a wait for many: the time begins anew whenever `progress`, of anything,
  /// is greater than it ever was.
  bool IsUp(std::ptrdiff_t progress);
  /// By the clock of the wall, since it began.
  std::chrono::duration<double> waited() const { return last_ - began_; }

 private:
  std::chrono::duration<double> time_, left_, longest_;
  std::ptrdiff_t progress_ = 0;
  std::function<double()> share_;
  std::function<Clock::time_point()> now_;
  Clock::time_point began_, last_;
};

}  // namespace intaglio::host
