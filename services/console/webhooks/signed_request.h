#pragma once

// What a receiver of events gets in one attempt.

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "services/console/webhooks/delivery_queue.h"

namespace intaglio::console {

/// Headers as "Name: value". `dropped`: events that this receiver did not get since the
/// console was started. `now` is that of the attempt, signed with the body, so that a
/// receiver can refuse what somebody sends again later.
std::vector<std::string> HeadersOf(const Delivery& delivery, std::string_view secret,
                                   std::uint64_t dropped,
                                   std::chrono::system_clock::time_point now);

}  // namespace intaglio::console
