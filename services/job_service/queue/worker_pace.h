#pragma once

// Which discretizer is so slow that the others would be done sooner without it: each of
// its last kSlowParts parts took more than kSlowRatio times the median of the parts that
// others made of the same attempt of a job, both for the part and for a point of it.
//
// 1. Parts are of about the same work, but one may have many points or none: a part
// counts
//    as slow only if it is by both measures.
// 2. A part counts if others have made kMinOtherParts of its attempt. The first part that
//    a discretizer makes of an attempt is no measure: it reads the models before.
// 3. A part of less than kMinSlow_s is not slow: below, a busy moment of the computer is
//    the reason.
// Values only: no bus, no clock. Used from one thread.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "services/job_service/records/task_id.h"

namespace intaglio::job_service {

/// A discretizer with an eighth of the parts of a job at such a rate makes the job last
/// as long as without the others; a host that is only older is two or three times slower.
inline constexpr double kSlowRatio = 5;
inline constexpr std::size_t kSlowParts = 3;
inline constexpr std::size_t kMinOtherParts = 5;
inline constexpr double kMinSlow_s = 0.5;
/// A slow one is tried again after this time: what else ran on its computer may be over.
inline constexpr std::chrono::minutes kSlowFor{10};

class WorkerPace {
 public:
  /// A part that is done. How many times slower than the others the worker is, when this
  /// part shows that it is slow; then its parts are counted anew.
  std::optional<double> NoteDone(const std::string& worker, const TaskId& task,
                                 double elapsed_s, std::uint64_t point_count);

 private:
  struct Done {
    std::string worker, job_uid;
    std::uint32_t attempt = 0;
    double elapsed_s = 0, per_point_s = 0;
    bool first = false;
  };
  /// nullopt: there is nothing to compare it with.
  std::optional<double> RatioOf(const Done& done) const;

  static constexpr std::size_t kKept = 256;  // eight jobs of 32 parts at the same time
  std::deque<Done> done_;                    // the newest last
  // Ratios of slow parts in a row, by worker; of those alone that are in done_.
  std::map<std::string, std::vector<double>> slow_;
};

}  // namespace intaglio::job_service
