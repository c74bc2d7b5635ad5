#include <fmt/format.h>

#include <algorithm>

#include "engrave/core/counted.h"
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

constexpr std::size_t kMaxNameColumns = 32;

/// Characters, not bytes, of UTF-8.
std::size_t Columns(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

/// In one line; the end of a long one is in the results.
std::string ShownName(const BatchJobResult& job) {
  std::string shown;
  for (const char c : job.name()) {
    const bool begins = (c & 0xC0) != 0x80;
    if (begins && Columns(shown) == kMaxNameColumns) return shown + "...";
    shown += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return shown;
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
  std::size_t name_width = 4;
  for (const BatchJobResult& job : results.jobs()) {
    width = std::max(width, job.id().size());
    name_width = std::max(name_width, Columns(ShownName(job)));
  }
  std::string table =
      fmt::format("{:<{}}  {:<{}}  {:>6}  {:<12} {:<13} {:<18} {:>17}  {:>12}  {}\n",
                  "id", width, "name", name_width, "job", "machine", "state", "verdict",
                  "made / planned", "time", "message");
  for (const BatchJobResult& job : results.jobs()) {
    const std::string name = ShownName(job);
    table += fmt::format(
        "{:<{}}  {}{:<{}}  {:>6}  {:<12} {:<13} {:<18} {:>17}  {:>12}  {}\n", job.id(),
        width, name, "", name_width - Columns(name),
        job.job() == 0 ? "-" : std::to_string(job.job()), job.cell(), job.state(),
        job.verdict(),
        job.planned() == 0 ? "-"
                           : fmt::format("{} / {}", client::GroupedDigits(job.made()),
                                         client::GroupedDigits(job.planned())),
        job.time_s() > 0 ? client::ShortDuration(job.time_s()) : "-",
        FirstLine(job.message()));
  }
  return table + fmt::format(
                     "{} in {}: {} good, {} good with warnings, {} not good, {} "
                     "failed, {} cancelled, {} not made\n",
                     Counted(static_cast<std::uint64_t>(results.jobs_size()), "job"),
                     client::ShortDuration(results.time_s()), results.good(),
                     results.good_with_warnings(), results.not_good(), results.failed(),
                     results.cancelled(), results.not_made());
}

}  // namespace intaglio::cli
