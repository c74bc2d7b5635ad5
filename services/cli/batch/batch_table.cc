#include <fmt/format.h>

#include "services/cli/batch/batch_run.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"

namespace intaglio::cli {
namespace {

/// The first line of a message: the others are in the results.
std::string FirstLine(const std::string& message) {
  const auto end = message.find('\n');
  return end == std::string::npos ? message : message.substr(0, end) + " ...";
}

}  // namespace

int ExitCodeOf(const BatchResults& results, bool interrupted) {
  if (interrupted) return client::kExitCancelled;
  if (results.failed() + results.cancelled() + results.not_made() > 0) {
    return client::kExitMachine;
  }
  return results.not_good() > 0 ? client::kExitNotGood : client::kExitGood;
}

std::string TableOf(const BatchResults& results) {
  std::size_t width = 4;
  for (const BatchJobResult& job : results.jobs()) {
    width = std::max(width, job.id().size());
  }
  std::string table = fmt::format(
      "{:<{}}  {:>6}  {:<12} {:<13} {:<9} {:>17}  {:>12}  {}\n", "id", width, "job",
      "machine", "state", "verdict", "made / planned", "time", "message");
  for (const BatchJobResult& job : results.jobs()) {
    table += fmt::format(
        "{:<{}}  {:>6}  {:<12} {:<13} {:<9} {:>17}  {:>12}  {}\n", job.id(), width,
        job.job() == 0 ? "-" : std::to_string(job.job()), job.cell(), job.state(),
        job.verdict(),
        job.planned() == 0 ? "-"
                           : fmt::format("{} / {}", client::GroupedDigits(job.made()),
                                         client::GroupedDigits(job.planned())),
        job.time_s() > 0 ? client::ShortDuration(job.time_s()) : "-",
        FirstLine(job.message()));
  }
  return table + fmt::format(
                     "{} jobs in {}: {} good, {} not good, {} failed, {} cancelled, {} "
                     "not made\n",
                     results.jobs_size(), client::ShortDuration(results.time_s()),
                     results.good(), results.not_good(), results.failed(),
                     results.cancelled(), results.not_made());
}

}  // namespace intaglio::cli
