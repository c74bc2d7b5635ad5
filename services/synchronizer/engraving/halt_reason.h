#pragma once

// Why a run is halted, or a job waits.

#include <string>

#include "services/cell/permission_chain.h"
#include "services/synchronizer/pulses/cell_names.h"

namespace intaglio::synchronizer {

struct HaltReason {
  Missing missing = Missing::kNothing;  ///< the link of the chain that was lost, if any
  std::string text;                     ///< what is wrong and what to do
  bool fault = false;                   ///< it costs the grant

  /// Nothing is lost: the run begins again by itself.
  bool starts_again() const { return missing == Missing::kNothing && !fault; }
};

}  // namespace intaglio::synchronizer
