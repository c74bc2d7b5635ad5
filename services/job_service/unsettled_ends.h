#pragma once

// Jobs that were ended from outside, by a cancel or a failure, while their machine may
// have fired: what is in the glass is known when it has reported the end of its
// engraving. One that does not report it within kWithin is settled by what was known
// before. Used from one thread.

#include <chrono>
#include <map>
#include <string>
#include <vector>

#include "services/job_service/records/task_id.h"

namespace intaglio::job_service {

class UnsettledEnds {
 public:
  /// As long as a worker may be silent (queue/job_queue.cc).
  static constexpr std::chrono::seconds kWithin{10};

  void Add(const std::string& job_uid, Nanoseconds now) { since_.emplace(job_uid, now); }
  void Remove(const std::string& job_uid) { since_.erase(job_uid); }

  /// Each once.
  std::vector<std::string> TakeOverdue(Nanoseconds now) {
    std::vector<std::string> overdue;
    for (const auto& [uid, since] : since_) {
      if (now - since >= kWithin) overdue.push_back(uid);
    }
    for (const std::string& uid : overdue) since_.erase(uid);
    return overdue;
  }

 private:
  std::map<std::string, Nanoseconds> since_;  // by job
};

}  // namespace intaglio::job_service
