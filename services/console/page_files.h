#pragma once

#include <map>
#include <string>

#include "services/platform/web/server.h"

namespace intaglio::console {

/// The files of the page, by path, as they were bundled at build time. They are part of
/// the program: no path of a request is ever one of the disk.
std::map<std::string, web::Response> PageFiles();

}  // namespace intaglio::console
