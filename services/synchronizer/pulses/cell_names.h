#pragma once

// What the synchronizer shares with the marker (services/cell), by its short names.

namespace intaglio::cell {}

namespace intaglio::synchronizer {
using namespace cell;  // NOLINT(google-build-using-namespace)
}  // namespace intaglio::synchronizer
