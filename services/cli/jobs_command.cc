#include "services/cli/jobs_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <functional>
#include <iostream>
#include <memory>
#include <optional>

#include "services/cli/flags/bus_flags.h"
#include "services/cli/flags/event_flag.h"
#include "services/cli/flags/same_block_flag.h"
#include "services/cli/json/print_json.h"
#include "services/cli/status/command_effect.h"
#include "services/cli/status/job_text.h"
#include "services/cli/submit_jobs.h"
#include "services/cli/teach/mount_command.h"
#include "services/cli/terminal/command_outcome.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/job_client.h"
#include "services/client/known_jobs.h"
#include "services/client/shop/bus_turn.h"
#include "services/client/shop/job_record.h"
#include "services/client/warning_text.h"

namespace intaglio::cli {
namespace {

using namespace std::chrono_literals;

using Act = std::function<int(client::JobClient&, const client::JobView&)>;
using ActOnBus =
    std::function<int(bus::Bus&, client::JobClient&, const client::JobView&)>;

void PrintWarnings(const client::JobView& job, std::ostream& out) {
  for (const Warning& warning : job.warnings) out << client::WarningLine(warning) << "\n";
}

/// Nothing, or what there is to complain of a job that takes no command any more.
std::optional<Error> WhyEnded(const client::JobView& job) {
  if (!job.ended()) return std::nullopt;
  return Error{ErrorCode::kRefused,
               fmt::format("job {} is already {}", job.number, client::NameOf(job.state)),
               client::NameOf(intaglio_ANSWER_ENDED_JOB)};
}

int CommandJob(bus::Bus& bus, client::JobClient& client, const client::JobView& job,
               const client::JobOrder& order) {
  if (const auto ended = WhyEnded(job)) return Complain(*ended, client::kExitWrongInput);
  if (order.kind == intaglio_COMMAND_ARM) PrintWarnings(job, std::cerr);
  if (order.kind == intaglio_COMMAND_ARM || order.kind == intaglio_COMMAND_RESUME)
    WaitForController(bus, client, job.cell);
  if (auto taken = client.Command(job, order); !taken) return ComplainOf(taken.error());
  if (order.kind == intaglio_COMMAND_ARM || order.kind == intaglio_COMMAND_RESUME)
    PrintMounted(client, job.cell, std::cout);
  return AwaitEffect(client, job, order.kind, std::cout);
}

/// What was printed is what the job service has published last; a fault of it may hide
/// the rest.
int ExitWithFault(const client::JobClient& client) {
  if (const auto fault = client.JobServiceFault())
    return Complain(*fault, client::kExitMachine);
  return client::kExitGood;
}

int PrintJobs(const client::JobClient& client, bool json) {
  if (json) {
    if (const int printed =
            PrintJson(client::JobListOf(client.jobs(), std::chrono::system_clock::now()));
        printed != 0)
      return printed;
  } else {
    std::vector<client::JobView> jobs;
    for (const auto& [uid, job] : client.jobs()) jobs.push_back(job);
    std::cout << ListText(std::move(jobs)) << std::flush;
  }
  return ExitWithFault(client);
}

/// All jobs, or none and the reason.
int List(const JobsOptions& options) {
  const client::BusTurn turn;
  bus::Bus bus(WithoutCells(options.bus));
  client::JobClient client(bus);
  const auto known = client::PollUntilJobsAreKnown(client, bus.discovery_time());
  if (known) return PrintJobs(client, options.json);
  if (known.error().code != ErrorCode::kTimedOut)
    return Complain(known.error(), client::kExitMachine);
  if (client.services().empty()) {
    return Complain({ErrorCode::kTimedOut,
                     "no services found: start them (intaglio up), or check --domain, "
                     "--interface, --tag and --security",
                     ""},
                    client::kExitWrongInput);
  }
  return Complain({ErrorCode::kTimedOut,
                   "other services run, but no job service: nothing is known of the jobs "
                   "(intaglio history reads their database)",
                   ""},
                  client::kExitMachine);
}

/// Runs `act` on the job the options name.
int WithJobOn(const bus::BusOptions& shop, const JobsOptions& options,
              const ActOnBus& act) {
  bus::Bus bus(shop);
  client::JobClient client(bus);
  const auto job = client::AwaitJob(client, options.uid, bus.discovery_time());
  if (!job) return ComplainOfShop(job.error());
  ReportJob(job->number);
  return act(bus, client, *job);
}

/// The same of what the job service alone answers.
int WithJob(const JobsOptions& options, const Act& act) {
  return WithJobOn(WithoutCells(options.bus), options,
                   [&act](bus::Bus&, client::JobClient& client,
                          const client::JobView& job) { return act(client, job); });
}

/// The job's machine is received as well: it reports what it made before the job service
/// has settled it.
int FollowJob(const JobsOptions& options) {
  return WithJobOn(options.bus, options,
                   [&](bus::Bus&, client::JobClient& client, const client::JobView& job) {
                     return Watch(client, job.uid, options);
                   });
}

int SetSpeed(client::JobClient& client, const client::JobView& job,
             std::uint32_t percent) {
  if (const auto ended = WhyEnded(job)) return Complain(*ended, client::kExitWrongInput);
  if (auto taken =
          client.Command(job, {.kind = intaglio_COMMAND_SPEED, .speed_percent = percent});
      !taken) {
    return ComplainOf(taken.error());
  }
  std::cout << "job " << job.number << " is made at " << percent
            << " % speed, from its next planned motion on\n";
  return client::kExitGood;
}

/// The job that `job` is to precede; empty: none.
Result<std::string> BeforeWhom(client::JobClient& client, const client::JobView& job,
                               const JobsOptions& options,
                               std::chrono::milliseconds discovery_time) {
  if (options.last) return std::string();
  if (!options.before.empty())
    return INTAGLIO_TRY(client::AwaitJob(client, options.before, discovery_time)).uid;
  const auto is_next = [&](const auto& entry) {
    return entry.second.cell == job.cell && entry.second.queue_place == 1;
  };
  const auto next = std::find_if(client.jobs().begin(), client.jobs().end(), is_next);
  return next == client.jobs().end() ? std::string() : next->first;
}

int Move(client::JobClient& client, const client::JobView& job,
         const JobsOptions& options) {
  if (const auto ended = WhyEnded(job)) return Complain(*ended, client::kExitWrongInput);
  const auto discovery_time = client::JobClient::kAnswerTime;
  if (const auto all = client::PollUntilJobsAreKnown(client, discovery_time); !all)
    return ComplainOfShop(all.error());
  const auto before = BeforeWhom(client, job, options, discovery_time);
  if (!before) return ComplainOfShop(before.error());
  if (*before != job.uid) {
    const client::JobOrder order{.kind = intaglio_COMMAND_MOVE,
                                 .before_job_uid = *before};
    if (auto taken = client.Command(job, order); !taken) return ComplainOf(taken.error());
  }
  const auto now = [&]() -> const client::JobView& { return client.jobs().at(job.uid); };
  client.PollUntil(
      [&] { return *before == job.uid || now().queue_place != job.queue_place; }, 1s);
  if (now().queue_place == 0)
    std::cout << "job " << job.number << " is " << client::StateOf(now()) << "\n";
  else
    std::cout << fmt::format("job {} has place {} of those that wait for {}\n",
                             job.number, now().queue_place, job.cell);
  return client::kExitGood;
}

/// 1..140.
Result<std::uint32_t> PercentOf(const std::string& text) {
  std::uint32_t percent = 0;
  const char* end = text.data() + text.size();
  const auto [read, error] = std::from_chars(text.data(), end, percent);
  if (error == std::errc() && read == end && percent >= 1 && percent <= 140) {
    return percent;
  }
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("PERCENT '{}': give a whole number from 1 to 140; to stop the "
                          "job, intaglio pause JOB",
                          text),
              text);
}

int ShowJob(const client::JobClient& client, const client::JobView& job, bool json) {
  if (!json) {
    std::cout << ShowText(job);
  } else if (const int printed = PrintJson(client::JobRecordOf(job)); printed != 0) {
    return printed;
  }
  return ExitWithFault(client);
}

void AddArmAndWatch(command_line::Command command, JobsOptions& options) {
  command.AddFlag(
      "--arm", options.arm,
      "you are at the machine: the job is armed once, as soon as it has its machine");
  AddSameBlockFlag(command, options.same_block);
  command.AddFlag("--watch", options.watch, "follow it to its end");
  AddEventsFlag(command, options.events);
}

void AddAgain(command_line::Command app, const std::shared_ptr<JobsOptions>& options) {
  command_line::Command again =
      app.AddCommand("again", "make a job again on a new block");
  again.AddOption("JOB", options->uid, "number or uid (intaglio history)").Require();
  const auto folder = again
                          .AddOption("--folder", options->folder,
                                     "folder of the shop, as for intaglio up")
                          .ShowDefault();
  again
      .AddOption(
          "--database", options->database,
          "or the database of the job service, as for its --database: a file or a server")
      .Exclude(folder);
  AddArmAndWatch(again, *options);
  AddAcceptFlag(again, options->accept);
  AddBusFlags(again, options->bus);
  again.SetFooter(
      "Example: intaglio again 12 --arm --watch\n"
      "It gets a new number, and is made from the present contents of its files.");
  again.SetAction([options] { return Again(*options); });
}

}  // namespace

void AddJobsCommands(command_line::Command app) {
  auto options = std::make_shared<JobsOptions>();
  command_line::Command submit =
      app.AddCommand("submit", "submit a job to the running job service");
  AddJobFlags(submit, options->job);
  AddBusFlags(submit, options->bus);
  AddArmAndWatch(submit, *options);
  AddAcceptAndAnswers(submit, options->accept);
  const auto series = submit.AddOption(
      "--series", options->series,
      "CSV file: a job for each row; {column} in texts and file names of "
      "the job file becomes the row's field");
  submit
      .AddOption("--stations", options->stations,
                 "1,2,4: a job for each of these blocks on the machine's table")
      .Exclude(series);
  submit.AddOption("--id", options->id,
                   "id of the submission: the same command with the same id again "
                   "submits nothing twice; of several jobs ID.1, ID.2, ...");
  submit.AddOption("--materials", options->materials_db,
                   "material base for the checks of a series, default the user's");
  submit.SetFooter(
      "Example: intaglio submit job.textproto --arm --watch\n"
      "Example: intaglio submit badge.textproto --series names.csv\n"
      "Without --arm the job waits until somebody at the machine types "
      "intaglio arm JOB.");
  submit.SetAction([options] { return Submit(*options); });

  AddAgain(app, options);

  command_line::Command list =
      app.AddCommand("list", "list the jobs of the running job service");
  AddBusFlags(list, options->bus);
  list.AddFlag("--json", options->json, "for programs");
  list.SetFooter("Example: intaglio list; then intaglio show 1");
  list.SetAction([options] { return List(*options); });

  const auto describe = [&](const char* name, const char* purpose) {
    command_line::Command command = app.AddCommand(name, purpose);
    command.AddOption("JOB", options->uid, "number or uid (intaglio list)").Require();
    AddBusFlags(command, options->bus);
    command.SetFooter(fmt::format("Example: intaglio {} 1", name));
    return command;
  };
  const auto add = [&](const char* name, const char* purpose, const Act& act) {
    command_line::Command command = describe(name, purpose);
    command.SetAction([options, act] { return WithJob(*options, act); });
    return command;
  };
  const auto order = [&](const char* name, const char* purpose, const ActOnBus& act) {
    command_line::Command command = describe(name, purpose);
    command.SetAction(
        [options, act] { return WithJobOn(WithoutCells(options->bus), *options, act); });
    return command;
  };
  add("show", "show all about one job",
      [options](client::JobClient& client, const client::JobView& job) {
        return ShowJob(client, job, options->json);
      })
      .AddFlag("--json", options->json, "for programs");
  command_line::Command watch = describe("watch", "follow a job to its end");
  AddEventsFlag(watch, options->events);
  watch.SetAction([options] { return FollowJob(*options); });
  const auto command = [options](intaglio_JobCommandKind kind) {
    return [kind, options](bus::Bus& bus, client::JobClient& client,
                           const client::JobView& job) {
      return CommandJob(bus, client, job,
                        {.kind = kind,
                         .from_point = options->from_point,
                         .fire_uncertain = options->fire_uncertain,
                         .accept_breakage = options->accept.breakage(),
                         .basis = options->block_id.empty() ? intaglio_ARM_BY_PERSON
                                                            : intaglio_ARM_BY_LOADER,
                         .block_id = options->block_id});
    };
  };
  command_line::Command arm = order(
      "arm", "you are at the machine, and the job's block is in it: the job may fire",
      command(intaglio_COMMAND_ARM));
  AddAcceptFlag(arm, options->accept);
  arm.AddOption("--loaded", options->block_id,
                "of a loader: the identity of the block that it has put in for this job; "
                "no other job of the machine had it");
  order("pause", "stop firing, bring the stage to rest", command(intaglio_COMMAND_PAUSE));
  command_line::Command resume = order("resume", "continue at the first point not made",
                                       command(intaglio_COMMAND_RESUME));
  resume.AddOption(
      "--from", options->from_point,
      "leave out permanently what is not made before this place in the order, from 0");
  resume.AddFlag("--fire-uncertain", options->fire_uncertain,
                 "you checked the block: fire again, once, the points of which nobody "
                 "knows whether they were fired");
  order("cancel", "end the job", command(intaglio_COMMAND_CANCEL));

  command_line::Command speed =
      app.AddCommand("speed", "set the speed of a job in percent");
  speed.AddOption("JOB", options->uid, "number or uid (intaglio list)").Require();
  speed
      .AddOption("PERCENT", options->percent,
                 "percent of the job's speed limits, 1..140, never above the machine's")
      .Require();
  AddBusFlags(speed, options->bus);
  speed.SetFooter("Example: intaglio speed 1 30; then intaglio speed 1 100");
  speed.SetAction([options] {
    const auto percent = PercentOf(options->percent);
    if (!percent) return Complain(percent.error(), client::kExitWrongInput);
    return WithJob(*options, [&](client::JobClient& client, const client::JobView& job) {
      return SetSpeed(client, job, *percent);
    });
  });

  command_line::Command move =
      add("move", "change the place of a job that waits for its machine",
          [options](client::JobClient& client, const client::JobView& job) {
            return Move(client, job, *options);
          });
  const auto before = move.AddOption(
      "--before", options->before,
      "the waiting job that it is to precede; default the next one of its machine");
  move.AddFlag("--last", options->last, "behind all that wait for its machine")
      .Exclude(before);
  move.SetFooter(
      "Example: intaglio move 7; intaglio move 7 --before 5; intaglio move 7 --last\n"
      "It gets the priority of its new neighbour. Nothing is armed by it.");
}

int SubmitJobFile(const bus::BusOptions& bus, const std::string& file) {
  JobsOptions options;
  options.bus = bus;
  options.job.job_file = file;
  return Submit(options);
}

}  // namespace intaglio::cli
