#pragma once

// About how long jobs will take that have no plan yet, by `intaglio preview` of each, one
// at a time. A job is asked for once, when its time has not been known for a while: most
// are planned at once, and those that wait behind others are not.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "proto/console.pb.h"
#include "services/client/job_view.h"
#include "services/console/answers/work_queue.h"

namespace intaglio::console {

class AboutTimes {
 public:
  using Clock = std::chrono::steady_clock;
  /// How long a job has no time before it is asked for.
  static constexpr std::chrono::seconds kPatience{3};

  /// `database`: of the job service; empty: nothing is asked for. `materials`: material
  /// base, empty: the user's.
  AboutTimes(std::filesystem::path database, std::string materials);
  ~AboutTimes();
  AboutTimes(const AboutTimes&) = delete;
  AboutTimes& operator=(const AboutTimes&) = delete;

  /// From one thread, at each look at the shop. Ended jobs are forgotten.
  void Follow(const std::map<std::string, client::JobView>& jobs, Clock::time_point now);
  /// Estimates of the open jobs that have no plan yet.
  std::vector<AboutTime> Known() const;

 private:
  struct Asked {
    Clock::time_point since;
    bool is_asked = false, is_planned = false;
    double time_s = 0;  ///< 0: not known
  };
  void Ask(const std::string& uid);

  const std::filesystem::path database_;
  const std::string materials_;
  std::filesystem::path scratch_;
  mutable std::mutex mutex_;  // of what follows
  std::map<std::string, Asked> jobs_;
  std::optional<WorkQueue> runs_;  // ends before the others go
};

}  // namespace intaglio::console
