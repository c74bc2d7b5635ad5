#include "services/console/shop_history.h"

#include <fmt/format.h>

#include "services/console/answers/json_response.h"
#include "services/history/history_csv.h"
#include "services/history/job_history.h"

namespace intaglio::console {
namespace {

/// Empty: the query has no such filter.
std::string ValueIn(const std::map<std::string, std::string>& query, const char* name) {
  const auto found = query.find(name);
  return found == query.end() ? std::string() : found->second;
}

// Some 30 000 jobs; a console needs less than 100 MB.
constexpr std::size_t kMaxCsvBytes = 16 << 20;

web::Response Failed(const Error& error) {
  return ErrorResponse(StatusOf(error.code), error);
}

}  // namespace

std::optional<HistoryForm> HistoryFormOf(std::string_view path) {
  if (path == "history") return HistoryForm::kJson;
  if (path == "history.csv") return HistoryForm::kCsv;
  if (path == "days.csv") return HistoryForm::kDays;
  return std::nullopt;
}

web::Response HistoryResponse(HistoryForm form, const std::filesystem::path& database,
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
    return ErrorResponse(400, good.error());
  if (form != HistoryForm::kJson) {
    const auto rows =
        form == HistoryForm::kDays ? history::CsvRows::kDays : history::CsvRows::kJobs;
    auto table = history::HistoryCsv(database.string(), filter, rows, kMaxCsvBytes);
    if (!table) return Failed(table.error());
    return web::TextResponse(200, "text/csv; charset=utf-8", std::move(*table));
  }
  auto jobs = history::ReadHistory(database.string(), filter);
  if (!jobs) return Failed(jobs.error());
  JobHistory all;
  for (JobStatistics& job : *jobs) *all.add_jobs() = std::move(job);
  return JsonResponse(200, all);
}

}  // namespace intaglio::console
