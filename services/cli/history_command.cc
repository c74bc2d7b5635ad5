#include "services/cli/history_command.h"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>

#include "engrave/core/counted.h"
#include "services/cli/json/print_json.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/text_table.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/history/history_csv.h"
#include "services/history/job_history.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct HistoryOptions {
  std::string folder = "intaglio-shop";
  std::string database;
  history::Filter filter;
  std::uint32_t job = 0;
  bool json = false;
  bool csv = false;
  bool days = false;
  bool workers = false;
};

constexpr std::size_t kAnySize = std::numeric_limits<std::size_t>::max();

/// "2 min 41 s", or "-" for what is not known.
std::string TimeOrDash(double seconds) {
  return seconds > 0 ? client::ShortDuration(seconds) : "-";
}

void PrintTable(const std::vector<JobStatistics>& jobs) {
  using Align = TextTable::Align;
  TextTable table({{"job", Align::kRight},
                   {"ended (UTC)"},
                   {"machine"},
                   {"glass"},
                   {"state"},
                   {"verdict"},
                   {"made / planned", Align::kRight},
                   {"time", Align::kRight},
                   {"estimate", Align::kRight},
                   {"machining", Align::kRight},
                   {"ratio", Align::kRight},
                   {"name"}});
  for (const JobStatistics& job : jobs) {
    // Day and minute.
    std::string ended = job.ended_utc().substr(0, 16);
    if (ended.size() > 10) ended[10] = ' ';
    const double ratio = job.first_estimate_ratio();
    table.AddRow({std::to_string(job.job()), ended, job.cell(), job.material(),
                  job.state(), job.verdict(),
                  fmt::format("{} / {}", client::GroupedDigits(job.made()),
                              client::GroupedDigits(job.planned())),
                  client::ShortDuration(job.duration_s()),
                  TimeOrDash(job.first_estimated_s()), TimeOrDash(job.machining_s()),
                  ratio > 0 ? fmt::format("{:.2f}", ratio) : "-", job.name()});
  }
  std::cout << table.Text();
  if (jobs.empty()) std::cerr << "no ended job matches these options\n";
  const history::EstimateScore score = history::ScoreOf(jobs);
  if (score.jobs == 0) return;
  fmt::print(std::cout,
             "first estimate by outcome of {}: {:.2f} in the median, {:.2f} to "
             "{:.2f}\n",
             Counted(score.jobs, "undisturbed job"), score.median_ratio, score.min_ratio,
             score.max_ratio);
}

int PrintHistory(const std::vector<JobStatistics>& jobs) {
  JobHistory all;
  for (const JobStatistics& job : jobs) *all.add_jobs() = job;
  return PrintJson(all);
}

void PrintWorkers(const WorkerHistory& history) {
  TextTable table({{"time (UTC)"}, {"worker"}, {"event"}, {"by"}, {"why"}});
  for (const WorkerEvent& event : history.events()) {
    table.AddRow({event.time_utc(), event.worker(), event.event(), event.operator_name(),
                  event.why()});
  }
  std::cout << table.Text();
  if (history.events().empty()) std::cerr << "no worker was ever left out\n";
}

int HistoryOfWorkers(const std::string& database, bool json) {
  const auto history = history::ReadWorkerHistory(database);
  if (!history) return Complain(history.error());
  if (json) return PrintJson(*history);
  PrintWorkers(*history);
  return client::kExitGood;
}

int History(const HistoryOptions& options) {
  history::Filter filter = options.filter;
  if (options.job != 0) filter.job = options.job;
  if (auto good = history::CheckFilter(filter); !good) return Complain(good.error());
  const std::string database =
      options.database.empty() ? options.folder + "/jobs.db" : options.database;
  if (options.workers) return HistoryOfWorkers(database, options.json);
  if (options.csv || options.days) {
    const auto rows = options.days ? history::CsvRows::kDays : history::CsvRows::kJobs;
    const auto table = history::HistoryCsv(database, filter, rows, kAnySize);
    if (!table) return Complain(table.error());
    std::cout << *table << std::flush;
    return client::kExitGood;
  }
  const auto jobs = history::ReadHistory(database, filter);
  if (!jobs) return Complain(jobs.error());
  if (options.json) return PrintHistory(*jobs);
  PrintTable(*jobs);
  return client::kExitGood;
}

}  // namespace

void AddHistoryCommand(command_line::Command app) {
  auto options = std::make_shared<HistoryOptions>();
  command_line::Command history =
      app.AddCommand("history", "list the jobs that a shop has made");
  const auto folder = history
                          .AddOption("--folder", options->folder,
                                     "folder of the shop, as for intaglio up")
                          .ShowDefault();
  history
      .AddOption(
          "--database", options->database,
          "or the database of the job service, as for its --database: a file or a server")
      .Exclude(folder);
  history.AddOption(
      "--since", options->filter.since,
      "only jobs that ended on this day or later, UTC: 2026-11-21, or 2026-11-21T15:30");
  history.AddOption("--until", options->filter.until,
                    "only jobs that ended on this day or earlier, UTC");
  history.AddOption("--name", options->filter.piece, "a part of the job's name");
  history.AddOption("--glass", options->filter.material, "the material");
  history.AddOption("--verdict", options->filter.verdict,
                    "good, good_with_warnings, not_good, none or unknown");
  history.AddOption("--cell", options->filter.cell, "name of the machine");
  history.AddOption("--job", options->job, "one job by its number, ended or not");
  const auto json = history.AddFlag("--json", options->json, "for programs");
  history.AddFlag("--csv", options->csv, "for spreadsheets").Exclude(json);
  history
      .AddFlag("--days", options->days,
               "for spreadsheets: a row for each day and machine, with its pieces by "
               "verdict and its times")
      .Exclude(json);
  history.AddFlag("--workers", options->workers,
                  "in place of the jobs: which discretizers and sorters were left out, "
                  "why, and who admitted them again");
  history.SetFooter(
      "Example: intaglio history --since 2026-11-01 --verdict not_good\n"
      "Example: intaglio history --folder shop --csv > november.csv\n"
      "The shop may be open or closed: its database is only read.");
  history.SetAction([options] { return History(*options); });
}

}  // namespace intaglio::cli
