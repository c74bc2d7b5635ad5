#include "services/platform/host/process/patience.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <thread>
#include <utility>

namespace intaglio::host {

// proc(5): "0.20 0.18 0.12 3/180 11206": 3 of 180 tasks can run now, one of them this
// one.
double ShareOfOneProcess() {
  std::ifstream file("/proc/loadavg");
  std::string load;
  unsigned runnable = 0;
  if (!(file >> load >> load >> load >> runnable)) return 1;
  const double cores = std::max(1U, std::thread::hardware_concurrency());
  return std::min(1.0, cores / std::max(1U, runnable));
}

Patience::Patience(std::chrono::milliseconds time, std::function<double()> share,
                   std::function<Clock::time_point()> now)
    : time_(time),
      left_(time),
      longest_(std::max<std::chrono::duration<double>>(time, kLongest)),
      share_(std::move(share)),
      now_(std::move(now)),
      began_(now_()),
      last_(began_) {}

bool Patience::IsUp() {
  const auto now = now_();
  left_ -= share_() * std::chrono::duration<double>(now - last_);
  last_ = now;
  return left_.count() <= 0 || now - began_ >= longest_;
}

bool Patience::IsUp(std::ptrdiff_t progress) {
  if (progress > progress_) {
    progress_ = progress;
    left_ = time_;
    began_ = last_ = now_();
  }
  return IsUp();
}

}  // namespace intaglio::host
