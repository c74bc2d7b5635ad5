#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "services/platform/web/server.h"

namespace intaglio::console {

enum class HistoryForm { kJson, kCsv, kDays };

/// By the path behind /api/v1/; nullopt: it is no history.
std::optional<HistoryForm> HistoryFormOf(std::string_view path);

/// JobHistory of the job service's database, as `intaglio history --json` prints it. The
/// query has its filters: since, until, name, glass, verdict, cell. 400: a wrong one.
/// 404: no database. Or a table, as --csv and --days print it; 413: it is too large. It
/// reads a disk.
web::Response HistoryResponse(HistoryForm form, const std::filesystem::path& database,
                              const std::map<std::string, std::string>& query);

}  // namespace intaglio::console
