#pragma once

// What a cell is given by the job service and by people, at one turn.

#include <chrono>
#include <cstdint>
#include <string>

#include "services/cell/permission_chain.h"

namespace intaglio::cell {

struct GrantInputs {
  std::chrono::nanoseconds now{0};  ///< monotonic
  bool permission_fresh = false;
  bool permission_granted = false;
  Grant grant;  ///< of this job; granted or withdrawn
  bool stop_pressed = false;
  std::uint32_t speed_percent = 100;  ///< override, 1..140
  std::uint32_t first_point = 0;      ///< open points before it are left out
  /// With the grant: a person's consent to make uncertain points again (consent.h).
  bool fire_uncertain = false;
  /// Why the zero of the machine refuses every arm; empty: it does not.
  std::string zero_refusal = {};
};

}  // namespace intaglio::cell
