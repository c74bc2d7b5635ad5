#include "services/cli/status/logs_command.h"

#include <iostream>
#include <memory>
#include <string>

#include "services/cli/json/print_json.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/shop/job_log.h"

namespace intaglio::cli {
namespace {

struct LogsOptions {
  client::LogSelection selection;
  std::string folder = "intaglio-shop";
  bool json = false;
};

int PrintLog(const LogsOptions& options) {
  const auto entries = client::ReadLog(options.folder, options.selection);
  if (!entries) return Complain(entries.error());
  if (options.json) {
    LogList list;
    for (const std::string& entry : *entries)
      *list.add_entries() = client::LogEntryOf(entry);
    return PrintJson(list);
  }
  for (const std::string& entry : *entries) std::cout << entry << "\n";
  if (entries->empty()) {
    std::cerr << (options.selection.job.empty()
                      ? "the logs have no such entries\n"
                      : "the logs have no such entries about job " +
                            options.selection.job + "\n");
  }
  return client::kExitGood;
}

}  // namespace

void AddLogsCommand(command_line::Command app) {
  auto options = std::make_shared<LogsOptions>();
  command_line::Command logs =
      app.AddCommand("logs", "show what the services have logged, of all or of one job");
  logs.AddOption("JOB", options->selection.job, "number or uid (intaglio history)");
  logs.AddOption("--folder", options->folder,
                 "folder of the shop, as for intaglio up, or the session of a run")
      .ShowDefault();
  logs.AddFlag("--warnings", options->selection.warnings_only,
               "only warnings and errors");
  logs.AddOption("--last", options->selection.max_count, "so many of the newest")
      .Within(1, 1'000'000)
      .ShowDefault();
  logs.AddFlag("--json", options->json, "for programs");
  logs.SetFooter(
      "Example: intaglio logs 12\n"
      "Example: intaglio logs --warnings --last 20 --folder shop\n"
      "Exit code: 0 read, also if nothing is about the job, 2 no logs there.");
  logs.SetAction([options] { return PrintLog(*options); });
}

}  // namespace intaglio::cli
