#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "services/platform/web/server.h"

namespace intaglio::console {

/// JobHistory of the job service's database, as `intaglio history --json` prints it. The
/// query has its filters: since, until, name, glass, verdict, cell. 400: a wrong one.
/// 404: no database. It reads a disk.
web::Response HistoryResponse(const std::filesystem::path& database,
                              const std::map<std::string, std::string>& query);

}  // namespace intaglio::console
