#pragma once

// What each machine has made on each day, by the jobs that ended on it, UTC.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "proto/listing.pb.h"
#include "proto/shop.pb.h"

namespace intaglio::history {

/// Grows by the days and the machines, not by the jobs.
class DaySums {
 public:
  /// A job that has not ended counts for nothing.
  void Add(const JobStatistics& job);
  /// By day and machine. Days on which nothing ended have no row.
  std::vector<DayStatistics> Rows() const;

 private:
  std::map<std::pair<std::string, std::string>, DayStatistics> rows_;  // day, cell
};

}  // namespace intaglio::history
