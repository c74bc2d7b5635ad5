#include "services/platform/host/version/software_version.h"

namespace intaglio::host {

const char* SoftwareVersion() { return INTAGLIO_VERSION; }

}  // namespace intaglio::host
