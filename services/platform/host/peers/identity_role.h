#pragma once

// The identity that a service has, and whether a sample was written by the process that
// it names.

#include <string>
#include <string_view>

#include "idl/job.h"
#include "idl/service.h"
#include "services/platform/bus/bus.h"

namespace intaglio::host {

/// The identity that a service of this kind takes: services/platform/security/roles.h.
std::string IdentityRole(intaglio_ServiceRole role, const std::string& cell);

/// `<service>-<host>-<pid>-<participant>`: only the process with that DDS participant can
/// write a sample that IsOwn accepts for this name.
std::string InstanceName(const std::string& service, const std::string& host, int pid,
                         const std::string& participant);

/// Whether a sample about `instance` (ServiceHealth, TaskStatus) was written by that very
/// process. Of an instance that has ended: by a lost lease, or by that process.
bool IsOwn(std::string_view instance, const bus::SampleOrigin& origin);

/// The same for a ServiceHealth; besides, the identity of its writer has to be that of
/// the service that it names, for the cell that it names.
bool IsOwnHealth(const intaglio_ServiceHealth& health, const bus::SampleOrigin& origin);

/// The same for a TaskStatus: cells report about engraving, stage workers about the rest.
bool IsOwnTask(const intaglio_TaskStatus& status, const bus::SampleOrigin& origin);

/// For displays, which show a replay of an older recording as well: its samples have no
/// partition. On a secured bus these topics cannot be written without a partition.
bool HasNoRole(const bus::SampleOrigin& origin);

}  // namespace intaglio::host
