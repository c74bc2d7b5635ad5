#include "services/cli/history_command.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <filesystem>
#include <iostream>
#include <memory>

#include "proto/json_text.h"
#include "services/cli/message_csv.h"
#include "services/cli/progress_bar.h"
#include "services/cli/run_command.h"
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
};

void PrintTable(const std::vector<JobStatistics>& jobs) {
  fmt::print("{:>6}  {:<16}  {:<12} {:<10} {:<10} {:<9} {:>21}  {:>12}  {}\n", "job",
             "ended (UTC)", "machine", "glass", "state", "verdict", "made / planned",
             "time", "name");
  for (const JobStatistics& job : jobs) {
    // Day and minute.
    std::string ended = job.ended_utc().substr(0, 16);
    if (ended.size() > 10) ended[10] = ' ';
    fmt::print(
        "{:>6}  {:<16}  {:<12} {:<10} {:<10} {:<9} {:>21}  {:>12}  {}\n", job.job(),
        ended, job.cell(), job.material(), job.state(), job.verdict(),
        fmt::format("{} / {}", GroupedDigits(job.made()), GroupedDigits(job.planned())),
        ShortDuration(job.duration_s()), job.name());
  }
  if (jobs.empty()) std::cerr << "no job has ended that is asked for\n";
}

int PrintJson(const std::vector<JobStatistics>& jobs) {
  JobHistory all;
  for (const JobStatistics& job : jobs) *all.add_jobs() = job;
  const auto json = JsonTextOf(all);
  if (!json) return Complain(json.error());
  std::cout << *json;
  return kExitGood;
}

int History(const HistoryOptions& options) {
  history::Filter filter = options.filter;
  if (options.job != 0) filter.job = options.job;
  if (auto good = history::CheckFilter(filter); !good) return Complain(good.error());
  const fs::path database = options.database.empty()
                                ? fs::path(options.folder) / "jobs.db"
                                : fs::path(options.database);
  const auto jobs = history::ReadHistory(database, filter);
  if (!jobs) return Complain(jobs.error());
  if (options.json) return PrintJson(*jobs);
  if (options.csv) {
    std::cout << CsvHeader(*JobStatistics::descriptor());
    for (const JobStatistics& job : *jobs) std::cout << CsvLine(job);
    return kExitGood;
  }
  PrintTable(*jobs);
  return kExitGood;
}

}  // namespace

void AddHistoryCommand(CLI::App& app, std::function<int()>& selected) {
  auto options = std::make_shared<HistoryOptions>();
  CLI::App* history = app.add_subcommand("history", "what a shop has made");
  auto* folder =
      history->add_option("--folder", options->folder, "of the shop, as for intaglio up")
          ->capture_default_str();
  history
      ->add_option("--database", options->database,
                   "or the job service's file, as its --database")
      ->excludes(folder);
  history->add_option("--since", options->filter.since,
                      "ended on this day or later, UTC: 2026-11-21, or 2026-11-21T15:30");
  history->add_option("--until", options->filter.until,
                      "ended on this day or earlier, UTC");
  history->add_option("--name", options->filter.piece, "a part of the job's name");
  history->add_option("--glass", options->filter.material, "the material");
  history->add_option("--verdict", options->filter.verdict,
                      "good, not_good, none or unknown");
  history->add_option("--cell", options->filter.cell, "name of the machine");
  history->add_option("--job", options->job, "one job by its number, ended or not");
  auto* json = history->add_flag("--json", options->json, "for programs");
  history->add_flag("--csv", options->csv, "for spreadsheets")->excludes(json);
  history->footer(
      "Example: intaglio history --since 2026-11-01 --verdict not_good\n"
      "Example: intaglio history --folder shop --csv > november.csv\n"
      "The shop may be open or closed: its database is only read.");
  history->callback(
      [options, &selected] { selected = [options] { return History(*options); }; });
}

}  // namespace intaglio::cli
