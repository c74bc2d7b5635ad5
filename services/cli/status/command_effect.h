#pragma once

#include <iosfwd>
#include <string>

#include "services/client/job_client.h"

namespace intaglio::cli {

/// Before an arm: a machine that was just started is waited for, on stderr with what is
/// waited for (controller_wait.h).
void WaitForController(bus::Bus& bus, client::JobClient& client, const std::string& cell);

/// The machine may take a moment, or wait for a person: then its message is printed.
/// `job`: as it was before the command. What is disarmed again at once (by a stop or an
/// interlock of the machine, by the fault that is still there) has not obeyed.
int AwaitEffect(client::JobClient& client, const client::JobView& job,
                intaglio_JobCommandKind kind, std::ostream& out);

}  // namespace intaglio::cli
