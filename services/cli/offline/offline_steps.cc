#include "services/cli/offline/offline_steps.h"

#include <unistd.h>

#include <iostream>

#include "services/platform/host/threads/worker_threads.h"

namespace intaglio::cli {

Meter::Meter(std::string stage, Of of)
    : stage_(std::move(stage)), of_(of), bar_(std::cerr, isatty(STDERR_FILENO) != 0) {}

Meter::~Meter() { bar_.Finish(); }

ProgressSink Meter::Sink() {
  return [this](std::uint64_t done, std::uint64_t total) {
    const auto now = Clock::now();
    if (now - shown_ < std::chrono::milliseconds(100) && done != total) return true;
    shown_ = now;
    const double elapsed_s = std::chrono::duration<double>(now - began_).count();
    if (of_ == Of::kShares) {
      bar_.ShowShare(stage_, done, total, elapsed_s);
    } else {
      bar_.Show(stage_, done, total, elapsed_s);
    }
    return true;
  };
}

Result<JobCloud> MakeMeteredCloud(const JobSpec& job, const ReadLimits& limits) {
  Meter meter("discretize", Meter::Of::kShares);
  return MakeJobCloud(job, limits, host::AllCores(), {meter.Sink(), meter.Sink()});
}

}  // namespace intaglio::cli
