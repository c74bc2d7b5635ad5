#include <fmt/format.h>

#include "engrave/core/counted.h"
#include "services/cli/batch/batch_run.h"
#include "services/cli/terminal/text_table.h"
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

/// In one line; the end of a long one is in the results.
std::string ShownName(const BatchJobResult& job) {
  std::string shown;
  for (const char c : job.name()) {
    const bool begins = (c & 0xC0) != 0x80;
    if (begins && ColumnsOf(shown) >= kMaxNameColumns) return shown + "...";
    shown += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return shown;
}

/// "2 good, 1 failed": how many came to which end, without those that none came to.
std::string EndsOf(const BatchResults& results) {
  std::string text;
  const auto add = [&text](std::uint64_t count, const char* end) {
    if (count > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ",
                          client::GroupedDigits(count), end);
  };
  add(results.good(), "good");
  add(results.good_with_warnings(), "good with warnings");
  add(results.not_good(), "not good");
  add(results.failed(), "failed");
  add(results.cancelled(), "cancelled");
  add(results.not_made(), "not made");
  return text.empty() ? "none" : text;
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
  using Align = TextTable::Align;
  TextTable table({{"id"},
                   {"name"},
                   {"job", Align::kRight},
                   {"machine"},
                   {"state"},
                   {"verdict"},
                   {"made / planned", Align::kRight},
                   {"time", Align::kRight}});
  for (const BatchJobResult& job : results.jobs()) {
    table.AddRow(
        {job.id(), ShownName(job), job.job() == 0 ? "-" : std::to_string(job.job()),
         job.cell(), job.state(), job.verdict(),
         job.planned() == 0 ? "-"
                            : fmt::format("{} / {}", client::GroupedDigits(job.made()),
                                          client::GroupedDigits(job.planned())),
         job.time_s() > 0 ? client::ShortDuration(job.time_s()) : "-"});
    if (!job.message().empty()) table.AddBelow(FirstLine(job.message()));
  }
  return table.Text() +
         fmt::format("{} in {}: {}\n",
                     Counted(static_cast<std::uint64_t>(results.jobs_size()), "job"),
                     client::ShortDuration(results.time_s()), EndsOf(results));
}

}  // namespace intaglio::cli
