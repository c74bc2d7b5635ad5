#pragma once

// One part of a job that is made a second time, by another discretizer, to compare the
// two.
//
//   under way --two checksums are equal--> settled: no comparison any more
//      |  ^--a worker that has not made it--+
//      v                                    |
//   disputed: all differ, and nobody else is there

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "services/job_service/records/task_id.h"
#include "services/platform/host/stage/task_part.h"

namespace intaglio::job_service {

struct PartComparison {
  struct Made {
    std::string worker;
    std::string checksum;  ///< of one that could not make it: its error
  };
  std::uint32_t part = 0;
  std::vector<Made> made;   ///< the first one's points went to the sorter
  std::string worker;       ///< makes it now; empty: nobody
  std::uint32_t times = 0;  ///< that it was given
  Nanoseconds not_before{0};
  std::size_t suspected_count = 0;  ///< of the makers, the first so many

  bool at_work() const { return !worker.empty(); }
  /// In the numbers of the part's attempts.
  std::uint32_t part_attempt() const { return host::kMaxPartAttempts + times - 1; }
};

}  // namespace intaglio::job_service
