#pragma once

#include <string>

namespace intaglio::job_service {

/// A worker that is given nothing more (queue/comparing.h).
struct LeftOut {
  std::string worker;     ///< instance
  std::string why;        ///< for people; empty: it is not left out any more
  bool for_good = false;  ///< as long as its process lives; else it is suspected

  bool operator==(const LeftOut&) const = default;
};

}  // namespace intaglio::job_service
