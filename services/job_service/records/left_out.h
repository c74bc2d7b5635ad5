#pragma once

#include <string>

namespace intaglio::job_service {

/// A worker that is given nothing more (queue/comparing.h).
struct LeftOut {
  std::string worker;     ///< instance
  std::string why;        ///< for people; empty: it is not left out any more
  bool for_good = false;  ///< until it is restarted or admitted; else it is suspected
  std::string admitted_by = {};  ///< who has taken it back; empty: a comparison has

  bool operator==(const LeftOut&) const = default;
};

}  // namespace intaglio::job_service
