#pragma once

// What a page shows to whoever teaches a machine: lenses, channels and zeros of its
// profile, and what was taught last.

#include "engrave/core/result.h"
#include "proto/console.pb.h"
#include "services/client/teach_client.h"

namespace intaglio::console {

/// Reads the machine's profile. A machine that keeps its zero in the controller has none,
/// and nothing but its name. kNotFound: the profile is on another computer; kUnreadable,
/// kInvalidValue: it is damaged.
Result<MachineTeaching> TeachingOf(const client::MachineView& machine);

}  // namespace intaglio::console
