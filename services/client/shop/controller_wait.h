#pragma once

// Waiting for the controller that watches key and door of a machine, before an arm.

#include <chrono>
#include <functional>
#include <string>

#include "services/client/job_client.h"

namespace intaglio::client {

/// On a computer that is not busy (patience.h).
inline constexpr std::chrono::seconds kControllerAnswersWithin{3};

/// Polls while the job service knows of the machine that its controller does not answer,
/// as just after a start: an arm that is given before is spent by the first answer,
/// because nobody watched key and door until then. `waits` is called once when there is
/// something to wait for. False when the controller does not answer in time; true also
/// when nothing is known of it.
bool AwaitController(bus::Bus& bus, JobClient& client, const std::string& cell,
                     const std::function<void()>& waits);

}  // namespace intaglio::client
