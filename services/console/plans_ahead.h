#pragma once

// Has the plan of a job read when the job gets its machine: the first page that shows it
// has its picture at once.

#include <map>
#include <set>
#include <string>

#include "services/client/job_view.h"
#include "services/console/cloud_reader.h"

namespace intaglio::console {

class PlansAhead {
 public:
  /// `files` reads the plans, and keeps the last one.
  explicit PlansAhead(CloudReader& files) : files_(files) {}

  /// From one thread, at each look at the shop. A job is asked for once.
  void Follow(const std::map<std::string, client::JobView>& jobs);

 private:
  CloudReader& files_;
  std::set<std::string> asked_;  // uids of jobs that have not left the bus
};

}  // namespace intaglio::console
