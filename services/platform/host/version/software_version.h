#pragma once

// The version of this software, as each process announces it.

namespace intaglio::host {

/// E.g. "0.1.0": that of the whole build.
const char* SoftwareVersion();

}  // namespace intaglio::host
