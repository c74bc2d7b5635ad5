#include "services/console/shop_history.h"

#include <fmt/format.h>

#include "services/console/answers/json_response.h"
#include "services/history/job_history.h"

namespace intaglio::console {
namespace {

/// Empty: the query has no such filter.
std::string ValueIn(const std::map<std::string, std::string>& query, const char* name) {
  const auto found = query.find(name);
  return found == query.end() ? std::string() : found->second;
}

}  // namespace

web::Response HistoryResponse(const std::filesystem::path& database,
                              const std::map<std::string, std::string>& query) {
  if (database.empty()) {
    return ErrorResponse(404,
                         "this console knows no history: start it with --database FILE");
  }
  history::Filter filter;
  filter.since = ValueIn(query, "since");
  filter.until = ValueIn(query, "until");
  filter.piece = ValueIn(query, "name");
  filter.material = ValueIn(query, "glass");
  filter.verdict = ValueIn(query, "verdict");
  filter.cell = ValueIn(query, "cell");
  if (const auto good = history::CheckFilter(filter); !good)
    return ErrorResponse(400, good.error().message);
  auto jobs = history::ReadHistory(database.string(), filter);
  if (!jobs) {
    return ErrorResponse(jobs.error().code == ErrorCode::kNotFound ? 404 : 500,
                         jobs.error().message);
  }
  JobHistory all;
  for (JobStatistics& job : *jobs) *all.add_jobs() = std::move(job);
  return JsonResponse(200, all);
}

}  // namespace intaglio::console
