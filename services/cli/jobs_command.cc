#include "services/cli/jobs_command.h"

#include <fmt/format.h>

#include <charconv>
#include <iostream>
#include <map>
#include <memory>
#include <optional>

#include "services/cli/complain.h"
#include "services/cli/flags/bus_flags.h"
#include "services/cli/flags/event_flag.h"
#include "services/cli/job_options.h"
#include "services/cli/job_series.h"
#include "services/cli/watch_job.h"
#include "services/client/arm_once.h"
#include "services/client/event_lines.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/client/job_client.h"
#include "services/history/job_history.h"

namespace intaglio::cli {
namespace {

using namespace std::chrono_literals;

constexpr auto kMachineTime = 2s;

struct JobsOptions {
  bus::BusOptions bus;
  JobFlags job;
  std::string uid;
  std::string percent;
  std::string series;
  std::string folder = "intaglio-shop";
  std::string database;
  std::uint32_t from_point = 0;
  bool fire_uncertain = false;
  bool arm = false;
  bool watch = false;
  bool events = false;

  /// Where text for people goes.
  std::ostream& human() const { return events ? std::cerr : std::cout; }
};

std::string TimeOf(const client::JobView& job) {
  if (job.estimate_ticks == 0 || job.rate_hz <= 0) return "-";
  return client::ShortDuration(static_cast<double>(job.estimate_ticks) / job.rate_hz);
}

std::string ProgressOf(const client::JobView& job) {
  const client::JobView::Progress* p = client::StageAtWork(job);
  if (p == nullptr) return "-";
  return fmt::format("{} {} / {}", client::NameOf(p->stage),
                     client::GroupedDigits(p->done_count),
                     client::GroupedDigits(p->total_count));
}

void PrintState(const client::JobView& job, std::ostream& out) {
  out << "job " << job.number << " is " << client::StateOf(job)
      << (job.message.empty() ? "" : ": " + job.message) << "\n";
}

/// Where a command leads when nothing is in its way.
bool Reached(const client::JobView& job, intaglio_JobCommandKind kind) {
  switch (kind) {
    case intaglio_COMMAND_PAUSE:
      return !job.armed && job.state != intaglio_JOB_ENGRAVING;
    case intaglio_COMMAND_CANCEL:
      return job.ended();
    case intaglio_COMMAND_ARM:
    case intaglio_COMMAND_RESUME:
      return job.ended() || (job.armed && job.state != intaglio_JOB_PAUSED &&
                             job.state != intaglio_JOB_WAITING_FOR_ARM);
    case intaglio_COMMAND_SPEED:
      break;
  }
  return true;
}

/// Exit codes of a command that got no answer, or not the one that was asked for.
int ComplainOf(const Error& error) { return Complain(error, client::kExitMachine); }

/// Nothing, or what there is to complain of a job that takes no command any more.
std::optional<Error> WhyEnded(const client::JobView& job) {
  if (!job.ended()) return std::nullopt;
  return Error{ErrorCode::kRefused,
               fmt::format("job {} is already {}", job.number, client::NameOf(job.state)),
               ""};
}

/// The machine may take a moment, or wait for a person: then its message is printed.
int AwaitEffect(client::JobClient& client, const client::JobView& job,
                intaglio_JobCommandKind kind, std::ostream& out) {
  client.PollUntil([&] { return Reached(client.jobs().at(job.uid), kind); },
                   kMachineTime);
  PrintState(client.jobs().at(job.uid), out);
  return client::kExitGood;
}

int CommandJob(client::JobClient& client, const client::JobView& job,
               const client::JobOrder& order) {
  if (const auto ended = WhyEnded(job)) return Complain(*ended, client::kExitWrongInput);
  if (auto taken = client.Command(job, order); !taken) return ComplainOf(taken.error());
  return AwaitEffect(client, job, order.kind, std::cout);
}

/// Gives the job to the job service.
Result<client::JobView> SubmitOne(client::JobClient& client, const JobSpec& job,
                                  const JobsOptions& options) {
  auto submitted = client.Submit(job, 15s);
  if (submitted) {
    if (options.events) client::EventLines(std::cout).Submitted(*submitted);
    options.human() << "job " << submitted->number << " (" << submitted->uid << ") is "
                    << client::NameOf(submitted->state) << "\n";
  }
  return submitted;
}

int Watch(client::JobClient& client, const std::string& uid, const JobsOptions& options) {
  client::EventLines events(std::cout);
  return WatchJob(client, uid, options.events ? &events : nullptr);
}

int SubmitSeries(const JobsOptions& options) {
  if (options.arm || options.watch) {
    return Complain({ErrorCode::kInvalidValue,
                     "--arm and --watch apply to one job: arm every piece of a series "
                     "when its block is in the machine (intaglio arm JOB)",
                     ""},
                    client::kExitWrongInput);
  }
  const auto series = BuildSeries(options.job, options.series);
  if (!series) return Complain(series.error(), client::kExitWrongInput);
  bus::Bus bus(options.bus);
  client::JobClient client(bus);
  client.PollUntil([&] { return !client.services().empty(); }, bus.discovery_time());
  for (const JobAndMachine& piece : *series) {
    const auto submitted = SubmitOne(client, piece.job, options);
    if (!submitted) return Complain(submitted.error(), client::kExitWrongInput);
  }
  options.human() << series->size() << " jobs submitted; list them with intaglio list\n";
  client.Poll(500ms);
  return client::kExitGood;
}

int SubmitJob(const JobSpec& spec, const JobsOptions& options) {
  bus::Bus bus(options.bus);
  client::JobClient client(bus);
  client.PollUntil([&] { return !client.services().empty(); }, bus.discovery_time());
  const auto submitted = SubmitOne(client, spec, options);
  if (!submitted) return Complain(submitted.error(), client::kExitWrongInput);
  if (options.arm) {
    auto armed = client::ArmWhenTaken(client, *submitted);
    if (!armed) return ComplainOf(armed.error());
    AwaitEffect(client, *submitted, intaglio_COMMAND_ARM, options.human());
  }
  if (options.watch) return Watch(client, submitted->uid, options);
  if (!options.arm)
    options.human() << "intaglio arm " << submitted->number << " arms it\n";
  client.Poll(500ms);
  const client::JobView& job = client.jobs().at(submitted->uid);
  return job.ended() && job.state != intaglio_JOB_DONE ? client::kExitMachine
                                                       : client::kExitGood;
}

int Submit(const JobsOptions& options) {
  if (!options.series.empty()) return SubmitSeries(options);
  const auto job = BuildJob(options.job);
  if (!job) return Complain(job.error(), client::kExitWrongInput);
  return SubmitJob(job->job, options);
}

/// The next piece of a job: the same once more, on a new block.
int Again(const JobsOptions& options) {
  const auto job = history::ReadJob(
      options.database.empty() ? options.folder + "/jobs.db" : options.database,
      options.uid);
  if (!job) return Complain(job.error(), client::kExitWrongInput);
  return SubmitJob(*job, options);
}

int List(const JobsOptions& options) {
  bus::Bus bus(options.bus);
  client::JobClient client(bus);
  client.PollUntil([] { return false; }, bus.discovery_time());
  if (client.services().empty()) {
    std::cerr << "intaglio: no services found: start them (intaglio up), or check "
                 "--domain, --interface and --tag\n";
    return client::kExitWrongInput;
  }
  fmt::print("{:>6}  {:<19} {:<12} {:<10} {:<34} {}\n", "job", "state", "machine", "time",
             "progress", "name");
  std::map<std::uint32_t, const client::JobView*> by_number;
  for (const auto& [uid, job] : client.jobs()) by_number[job.number] = &job;
  for (const auto& [number, job] : by_number) {
    fmt::print("{:>6}  {:<19} {:<12} {:<10} {:<34} {}\n", number,
               client::NameOf(job->state), job->cell, TimeOf(*job), ProgressOf(*job),
               job->name);
  }
  return client::kExitGood;
}

/// Runs `act` on the job the options name.
int WithJob(const JobsOptions& options,
            const std::function<int(client::JobClient&, const client::JobView&)>& act) {
  bus::Bus bus(options.bus);
  client::JobClient client(bus);
  client.PollUntil([&] { return client.Find(options.uid).has_value(); },
                   bus.discovery_time());
  const auto job = client.Find(options.uid);
  return job ? act(client, *job) : Complain(job.error(), client::kExitWrongInput);
}

int SetSpeed(client::JobClient& client, const client::JobView& job,
             std::uint32_t percent) {
  if (const auto ended = WhyEnded(job)) return Complain(*ended, client::kExitWrongInput);
  if (auto taken =
          client.Command(job, {.kind = intaglio_COMMAND_SPEED, .speed_percent = percent});
      !taken) {
    return ComplainOf(taken.error());
  }
  std::cout << "job " << job.number << " goes on at " << percent
            << " % speed, from the next planned motion on\n";
  return client::kExitGood;
}

/// 10..100.
Result<std::uint32_t> PercentOf(const std::string& text) {
  std::uint32_t percent = 0;
  const char* end = text.data() + text.size();
  const auto [read, error] = std::from_chars(text.data(), end, percent);
  if (error == std::errc() && read == end && percent >= 10 && percent <= 100) {
    return percent;
  }
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("PERCENT '{}': give a whole number from 10 to 100; to stop the "
                          "job, intaglio pause JOB",
                          text),
              text);
}

int ShowJob(const client::JobView& job) {
  fmt::print(
      "job        {} ({})\nname       {}\nstate      {}\nmachine    {}\nattempt    {}\n",
      job.number, job.uid, job.name, client::StateOf(job), job.cell, job.attempt);
  for (const client::JobView::Progress& p : job.progress) {
    if (p.total_count == 0) continue;
    fmt::print("{:<10} {} / {} points, {}\n", client::NameOf(p.stage),
               client::GroupedDigits(p.done_count), client::GroupedDigits(p.total_count),
               client::ShortDuration(p.elapsed_s));
  }
  fmt::print("estimate   {}\nspeed      {} %\nfolder     {}\n", TimeOf(job),
             job.speed_percent, job.result_directory);
  if (!job.message.empty()) fmt::print("message    {}\n", job.message);
  if (!job.armed && !job.ended() && !job.disarm_reason.empty()) {
    fmt::print("disarmed   {}\n", job.disarm_reason);
  }
  return client::kExitGood;
}

void AddArmAndWatch(command_line::Command command, JobsOptions& options) {
  command.AddFlag(
      "--arm", options.arm,
      "you are at the machine: the job is armed once, as soon as it has its machine");
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
      .AddOption("--database", options->database,
                 "or the database file of the job service, as for its --database")
      .Exclude(folder);
  AddArmAndWatch(again, *options);
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
  submit.AddOption("--series", options->series,
                   "CSV file: a job for each row; {column} in texts and file names of "
                   "the job file becomes the row's field");
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
  list.SetFooter("Example: intaglio list; then intaglio show 1");
  list.SetAction([options] { return List(*options); });

  const auto add =
      [&](const char* name, const char* purpose,
          const std::function<int(client::JobClient&, const client::JobView&)>& act) {
        command_line::Command command = app.AddCommand(name, purpose);
        command.AddOption("JOB", options->uid, "number or uid (intaglio list)").Require();
        AddBusFlags(command, options->bus);
        command.SetFooter(fmt::format("Example: intaglio {} 1", name));
        command.SetAction([options, act] { return WithJob(*options, act); });
        return command;
      };
  add("show", "show all about one job",
      [](client::JobClient&, const client::JobView& job) { return ShowJob(job); });
  AddEventsFlag(add("watch", "follow a job to its end",
                    [options](client::JobClient& client, const client::JobView& job) {
                      return Watch(client, job.uid, *options);
                    }),
                options->events);
  const auto command = [options](intaglio_JobCommandKind kind) {
    return [kind, options](client::JobClient& client, const client::JobView& job) {
      return CommandJob(client, job,
                        {.kind = kind,
                         .from_point = options->from_point,
                         .fire_uncertain = options->fire_uncertain});
    };
  };
  add("arm", "you are at the machine, and the job's block is in it: the job may fire",
      command(intaglio_COMMAND_ARM));
  add("pause", "stop firing, bring the stage to rest", command(intaglio_COMMAND_PAUSE));
  command_line::Command resume = add("resume", "continue at the first point not made",
                                     command(intaglio_COMMAND_RESUME));
  resume.AddOption(
      "--from", options->from_point,
      "leave out permanently what is not made before this place in the order, from 0");
  resume.AddFlag("--fire-uncertain", options->fire_uncertain,
                 "you checked the block: fire again, once, the points of which nobody "
                 "knows whether they were fired");
  add("cancel", "end the job", command(intaglio_COMMAND_CANCEL));

  command_line::Command speed =
      app.AddCommand("speed", "set the speed of a job in percent");
  speed.AddOption("JOB", options->uid, "number or uid (intaglio list)").Require();
  speed
      .AddOption("PERCENT", options->percent,
                 "percent of the job's speed limits, 10..100")
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
}

}  // namespace intaglio::cli
