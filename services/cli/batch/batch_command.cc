#include "services/cli/batch/batch_command.h"

#include <fmt/format.h>

#include <filesystem>
#include <iostream>
#include <memory>

#include "engrave/core/counted.h"
#include "engrave/core/try.h"
#include "engrave/io/atomic_file.h"
#include "materials_db/material_store.h"
#include "services/cli/batch/batch_continue.h"
#include "services/cli/batch/batch_run.h"
#include "services/cli/flags/accept_flag.h"
#include "services/cli/flags/bus_flags.h"
#include "services/cli/flags/event_flag.h"
#include "services/cli/flags/same_block_flag.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/exit_codes.h"
#include "services/client/known_jobs.h"
#include "services/client/shop/bus_turn.h"
#include "services/job/files/json_text.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;

struct BatchOptions {
  bus::BusOptions bus;
  BatchSource source;
  BatchRunOptions run;
  std::string materials_db;
  std::string results;
  std::string earlier;  // of an earlier run
  bool events = false;
  bool check = false;
  AcceptFlag accept;
};

/// Before anything is made: a folder that is not there would be found after hours.
Status CheckResultsFile(const std::string& file) {
  if (file.empty()) return {};
  const fs::path folder = fs::absolute(file).parent_path();
  std::error_code ignored;
  if (fs::is_directory(folder, ignored)) return {};
  return Fail(
      ErrorCode::kNotFound,
      fmt::format("--results {}: the folder {} does not exist", file, folder.string()),
      file);
}

Status WriteResults(const BatchResults& results, const std::string& file) {
  const auto json = INTAGLIO_TRY(JsonTextOf(results));
  return io::WriteFileAtomically(file, json);
}

int Finish(const BatchOptions& options, const BatchResults& results, bool interrupted,
           client::EventLines* events) {
  (options.events ? std::cerr : std::cout) << TableOf(results);
  if (events != nullptr) {
    JobEvent summary;
    summary.set_event("summary");
    summary.set_done(results.good() + results.good_with_warnings());
    summary.set_total(static_cast<std::uint32_t>(results.jobs_size()));
    summary.set_elapsed_s(results.time_s());
    summary.set_message(fmt::format(
        "{} good, {} good with warnings, {} not good, {} failed, {} cancelled, {} not "
        "made",
        results.good(), results.good_with_warnings(), results.not_good(),
        results.failed(), results.cancelled(), results.not_made()));
    events->Write(summary);
  }
  if (!options.results.empty()) {
    if (auto written = WriteResults(results, options.results); !written) {
      return Complain(written.error(), client::kExitWrongInput);
    }
  }
  return ExitCodeOf(results, interrupted);
}

int Batch(const BatchOptions& given) {
  BatchOptions options = given;
  options.source.materials_db = materials_db::DatabasePathOf(options.materials_db);
  if (auto good = CheckResultsFile(options.results); !good) {
    return Complain(good.error(), client::kExitWrongInput);
  }
  auto jobs = BuildBatch(options.source);
  if (!jobs) return Complain(jobs.error(), client::kExitWrongInput);
  BatchResults earlier;
  if (!options.earlier.empty()) {
    auto read = ReadBatchResults(options.earlier);
    if (!read) return Complain(read.error(), client::kExitWrongInput);
    earlier = std::move(*read);
  }
  const std::vector<BatchJob> all = *jobs;
  jobs = LeaveOutDone(all, earlier);
  for (const BatchJob& job : *jobs) PrintTextWarnings(job.warnings);
  if (options.check) {
    (options.events ? std::cerr : std::cout)
        << Counted(jobs->size(), "job") << ", all without mistakes\n";
    return client::kExitGood;
  }
  client::BusTurn turn;
  CatchInterrupts();
  bus::Bus bus(options.bus);
  client::JobClient client(bus);
  if (!client::PollUntilServed(client, bus.discovery_time())) {
    return Complain({ErrorCode::kTimedOut, client::kNoJobService, ""},
                    client::kExitWrongInput);
  }
  turn.End();
  if (!options.run.arm) {
    std::cerr << "without --arm every job waits for intaglio arm JOB\n";
  }
  options.run.file = options.source.file.string();
  options.run.accept_breakage = options.accept.breakage();
  client::EventLines lines(std::cout);
  client::EventLines* events = options.events ? &lines : nullptr;
  BatchRun run(client, std::move(*jobs), options.run, events);
  const BatchResults results = JoinResults(all, earlier, run.Run());
  return Finish(options, results, run.interrupted(), events);
}

}  // namespace

void AddBatchCommand(command_line::Command app) {
  auto options = std::make_shared<BatchOptions>();
  command_line::Command batch =
      app.AddCommand("batch", "make a list of jobs on the machines of a shop");
  batch.AddOption("FILE", options->source.file, "list of jobs: .jsonl or .csv").Require();
  batch.AddOption("--job", options->source.job_file, "job file of those that name none");
  batch.AddOption("--cells", options->source.cells,
                  "machine profiles, by name or file, that share the jobs which name "
                  "no cell");
  batch
      .AddOption("--parallel", options->run.parallel,
                 "jobs at a time over all machines, default one for each machine")
      .Within(1, 1000);
  batch.AddFlag(
      "--keep-going", options->run.keep_going,
      "continue after a job that is not good; only jobs that come after it are skipped");
  batch.AddFlag("--arm", options->run.arm,
                "you are at the machines and change the blocks: each job is armed once, "
                "when it has its machine and the door or the key was opened since the "
                "piece before it");
  AddSameBlockFlag(batch, options->run.same_block);
  AddAcceptFlag(batch, options->accept);
  batch
      .AddOption("--pause-limit", options->run.pause_limit_s,
                 "seconds after which a job that waits for a person is cancelled; "
                 "default: never")
      .Within(0.0, 1e6);
  batch.AddOption("--results", options->results, "write the result of every job as JSON");
  batch.AddOption("--continue", options->earlier,
                  "what --results has written of an earlier run: its good jobs are left "
                  "out, what had not ended is followed");
  batch.AddFlag("--check", options->check, "only check; submit nothing");
  batch.AddOption("--materials", options->materials_db,
                  "material base, default the user's");
  AddEventsFlag(batch, options->events);
  AddBusFlags(batch, options->bus);
  batch.SetFooter(
      "Example: intaglio batch cups.csv --job cup.textproto --arm --keep-going\n"
      "Example: intaglio batch jobs.jsonl --cells left.textproto right.textproto --arm "
      "--results made.json\n"
      "Everything is checked before the first job is submitted. Ctrl-C cancels waiting "
      "jobs; a job that is being engraved continues.");
  batch.SetAction([options] { return Batch(*options); });
}

}  // namespace intaglio::cli
