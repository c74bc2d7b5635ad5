#pragma once

// What the commands without processes have in common.

#include <chrono>
#include <string>

#include "engrave/core/progress.h"
#include "engrave/core/result.h"
#include "engrave/formats/point_file_kinds.h"
#include "services/cli/progress/progress_bar.h"
#include "services/job/models/job_cloud.h"

namespace intaglio::cli {

/// A progress bar on the standard error stream, drawn ten times a second at most.
class Meter {
 public:
  /// What the stage counts: points, or shares of its work.
  enum class Of { kPoints, kShares };

  explicit Meter(std::string stage, Of of = Of::kPoints);
  ~Meter();
  Meter(const Meter&) = delete;
  Meter& operator=(const Meter&) = delete;

  /// Not to be called after the meter's end.
  ProgressSink Sink();

 private:
  using Clock = std::chrono::steady_clock;
  std::string stage_;
  Of of_;
  ProgressBar bar_;
  Clock::time_point began_ = Clock::now(), shown_{};
};

/// With a progress bar, on all cores.
Result<JobCloud> MakeMeteredCloud(const JobSpec& job, const ReadLimits& limits);

/// Files of points, of the format that the file's ending names.
using formats::ReadPoints;
using formats::WritePoints;

}  // namespace intaglio::cli
