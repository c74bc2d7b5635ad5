#include "services/cli/job_series.h"

#include <fmt/format.h>

#include <sstream>

#include "engrave/core/try.h"
#include "engrave/io/csv.h"
#include "services/job/job_check.h"
#include "services/job/series.h"

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

Result<std::vector<JobAndMachine>> BuildSeries(const JobFlags& flags,
                                               const fs::path& table) {
  const auto pattern = INTAGLIO_TRY(ReadPattern(flags));
  const auto rows = INTAGLIO_TRY(io::ReadCsv(table));
  auto jobs = MakeSeries(pattern, rows, fs::absolute(table).parent_path());
  if (!jobs) return tl::unexpected(Prefixed(jobs.error(), table.string() + ", "));
  std::vector<JobAndMachine> series;
  std::vector<Error> errors;
  for (std::size_t i = 0; i < jobs->size(); ++i) {
    auto built = CompleteJob(flags, std::move((*jobs)[i]));
    if (built) {
      series.push_back(std::move(*built));
    } else {
      errors.push_back(Prefixed(
          built.error(),
          fmt::format("{}, line {}: ", table.string(), rows.rows[i].line_number)));
    }
  }
  if (!errors.empty()) return tl::unexpected(JoinErrors(errors));
  return series;
}

}  // namespace intaglio::cli
