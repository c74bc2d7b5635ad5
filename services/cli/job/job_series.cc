#include "services/cli/job/job_series.h"

#include <fmt/format.h>

#include <sstream>

#include "engrave/core/try.h"
#include "engrave/io/csv.h"
#include "services/cli/job/job_glass.h"
#include "services/job/checks/job_check.h"
#include "services/job/files/freeze.h"
#include "services/job/files/series.h"

namespace intaglio::cli {

namespace fs = std::filesystem;

Error Prefixed(Error error, const std::string& prefix) {
  std::istringstream in(error.message);
  std::string message;
  for (std::string line; std::getline(in, line);) {
    message += (message.empty() ? "" : "\n") + prefix + line;
  }
  error.message = std::move(message);
  return error;
}

Result<JobAndMachine> CheckedAsInShop(Result<JobAndMachine> built,
                                      const materials_db::MaterialStore& materials) {
  if (!built) return built;
  const auto material = INTAGLIO_TRY(FindGlass(*built, materials));
  INTAGLIO_TRY(FreezeJob(built->job, built->machine, material, {}));
  return built;
}

Result<std::vector<JobAndMachine>> BuildSeries(const JobFlags& flags,
                                               const fs::path& table,
                                               const std::string& materials_db) {
  const auto pattern = INTAGLIO_TRY(ReadPattern(flags));
  const auto rows = INTAGLIO_TRY(io::ReadCsv(table));
  auto jobs = MakeSeries(pattern, rows, fs::absolute(table).parent_path());
  if (!jobs) return tl::unexpected(Prefixed(jobs.error(), table.string() + ", "));
  const auto materials = INTAGLIO_TRY(
      materials_db::MaterialStore::Open(materials_db::DatabasePathOf(materials_db)));
  std::vector<JobAndMachine> series;
  std::vector<Error> errors;
  for (std::size_t i = 0; i < jobs->size(); ++i) {
    const std::string line =
        fmt::format("{}, line {}: ", table.string(), rows.rows[i].line_number);
    auto built = CheckedAsInShop(CompleteJob(flags, std::move((*jobs)[i])), materials);
    if (!built) {
      errors.push_back(Prefixed(built.error(), line));
      continue;
    }
    for (Warning& warning : built->warnings) warning.text = line + warning.text;
    series.push_back(std::move(*built));
  }
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  return series;
}

}  // namespace intaglio::cli
