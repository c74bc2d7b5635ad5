#include "services/cli/submit_jobs.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "engrave/core/counted.h"
#include "services/cli/batch/station_jobs.h"
#include "services/cli/flags/bus_flags.h"
#include "services/cli/job/job_series.h"
#include "services/cli/status/command_effect.h"
#include "services/cli/teach/mount_command.h"
#include "services/cli/terminal/command_outcome.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/watch_job.h"
#include "services/client/arm_once.h"
#include "services/client/event_lines.h"
#include "services/client/exit_codes.h"
#include "services/client/job_need.h"
#include "services/client/known_jobs.h"
#include "services/client/shop/bus_turn.h"
#include "services/client/warning_text.h"
#include "services/history/job_history.h"

namespace intaglio::cli {
namespace {

using namespace std::chrono_literals;

constexpr auto kSubmitTime = 15s;

/// Gives the job to the job service. `key`: of the submission; empty: a new one.
Result<client::JobView> SubmitOne(client::JobClient& client, const JobSpec& job,
                                  const JobsOptions& options, const std::string& key) {
  auto submitted = client.Submit(job, kSubmitTime, key);
  if (submitted) {
    ReportJob(submitted->number);
    if (options.events) client::EventLines(std::cout).Submitted(*submitted);
    options.human() << "job " << submitted->number << " (" << submitted->uid << ") is "
                    << client::NameOf(submitted->state) << "\n";
  }
  return submitted;
}

/// All of them, in this order.
Result<std::vector<client::JobView>> SubmitAll(client::JobClient& client, bus::Bus& bus,
                                               const std::vector<JobAndMachine>& jobs,
                                               const JobsOptions& options) {
  for (const JobAndMachine& piece : jobs) PrintTextWarnings(piece.warnings);
  client::PollUntilServed(client, bus.discovery_time());
  std::vector<client::JobView> submitted;
  for (const JobAndMachine& piece : jobs) {
    const std::string key =
        options.id.empty() ? "" : fmt::format("{}.{}", options.id, submitted.size() + 1);
    auto job = SubmitOne(client, piece.job, options, key);
    if (!job) return tl::unexpected(job.error());
    submitted.push_back(std::move(*job));
  }
  options.human() << Counted(jobs.size(), "job")
                  << " submitted; list them with intaglio list\n";
  client.Poll(500ms);
  return submitted;
}

int SubmitSeries(const JobsOptions& options) {
  if (options.arm || options.watch) {
    return Complain({ErrorCode::kInvalidValue,
                     "--arm and --watch apply to one job: arm every piece of a series "
                     "when its block is in the machine (intaglio arm JOB)",
                     ""},
                    client::kExitWrongInput);
  }
  const auto series = BuildSeries(options.job, options.series, options.materials_db);
  if (!series) return Complain(series.error(), client::kExitWrongInput);
  client::BusTurn turn;
  bus::Bus bus(WithoutCells(options.bus));
  client::JobClient client(bus);
  const auto submitted = SubmitAll(client, bus, *series, options);
  return submitted ? client::kExitGood : ComplainOfShop(submitted.error());
}

/// No job of others has the machine of these, or waits for it.
bool MachineWasFree(const client::JobClient& client,
                    const std::vector<client::JobView>& jobs) {
  for (const auto& [uid, other] : client.jobs()) {
    if (other.cell == jobs.front().cell && !other.ended() &&
        other.number < jobs.front().number)
      return false;
  }
  return true;
}

/// The job is in the queue, and a program reads why it is not armed.
int ComplainOfArm(const Error& error, const client::JobView& job,
                  const JobsOptions& options) {
  if (options.events) {
    JobEvent event = RefusedEventOf(error);
    event.set_job(job.number);
    event.set_uid(job.uid);
    client::EventLines(std::cout).Write(std::move(event));
  }
  return ComplainOf(error);
}

/// One after the other, each armed when it has the machine. The first that is not good
/// ends it, and those behind it stay in the queue, not armed.
int ArmAndWatchAll(bus::Bus& bus, client::JobClient& client,
                   const std::vector<client::JobView>& jobs, const JobsOptions& options) {
  const intaglio_ArmBasis other_basis =
      options.same_block ? intaglio_ARM_SAME_BLOCK : intaglio_ARM_BY_PROGRAM;
  const intaglio_ArmBasis first_basis =
      MachineWasFree(client, jobs) ? intaglio_ARM_BY_PERSON : other_basis;
  for (const client::JobView& job : jobs) {
    // The person who types it is at the machine, whose table has the first block.
    const bool is_first = job.uid == jobs.front().uid;
    if (is_first) WaitForController(bus, client, job.cell);
    const auto armed = client::ArmWhenTaken(
        client, job, {options.accept.breakage(), is_first ? first_basis : other_basis});
    if (!armed) return ComplainOfArm(armed.error(), job, options);
    const int end = Watch(client, job.uid, options);
    if (end != client::kExitGood) return end;
  }
  return client::kExitGood;
}

int SubmitAtStations(const JobsOptions& options) {
  if (options.arm != options.watch) {
    return Complain({ErrorCode::kInvalidValue,
                     "--stations: give --arm and --watch both, for each job is armed "
                     "when the one before has ended, or neither",
                     ""},
                    client::kExitWrongInput);
  }
  const auto stations = ParseStations(options.stations);
  if (!stations) return Complain(stations.error(), client::kExitWrongInput);
  const auto jobs = BuildStationJobs(options.job, *stations);
  if (!jobs) return Complain(jobs.error(), client::kExitWrongInput);
  for (const std::string& note : jobs->front().notes) std::cerr << note << "\n";
  client::BusTurn turn;
  bus::Bus bus(options.bus);
  client::JobClient client(bus);
  const auto submitted = SubmitAll(client, bus, *jobs, options);
  if (!submitted) return ComplainOfShop(submitted.error());
  turn.End();
  return options.arm ? ArmAndWatchAll(bus, client, *submitted, options)
                     : client::kExitGood;
}

int SubmitJob(const JobSpec& spec, const JobsOptions& options) {
  client::BusTurn turn;
  // Who follows a job receives from its machine what it made, before the job service has
  // settled it.
  bus::Bus bus(options.watch ? options.bus : WithoutCells(options.bus));
  client::JobClient client(bus);
  client::PollUntilServed(client, bus.discovery_time());
  const auto submitted = SubmitOne(client, spec, options, options.id);
  if (!submitted) return ComplainOfShop(submitted.error());
  if (options.arm || options.watch) turn.End();
  if (options.arm) {
    WaitForController(bus, client, submitted->cell);
    const auto basis = client::BasisFor(client, *submitted, options.same_block);
    auto armed =
        client::ArmWhenTaken(client, *submitted, {options.accept.breakage(), basis});
    if (!armed) return ComplainOfArm(armed.error(), *submitted, options);
    PrintMounted(client, submitted->cell, options.human());
    const int effect =
        AwaitEffect(client, *submitted, intaglio_COMMAND_ARM, options.human());
    if (effect != client::kExitGood && !options.watch) return effect;
  }
  if (options.watch) return Watch(client, submitted->uid, options);
  client.Poll(500ms);
  const client::JobView& job = client.jobs().at(submitted->uid);
  if (job.ended() && job.state != intaglio_JOB_DONE) {
    return ComplainOf(
        {ErrorCode::kFault,
         fmt::format("job {} {}: {}", job.number, client::NameOf(job.state), job.message),
         job.uid});
  }
  if (!options.arm) options.human() << client::StateAndNextOf(job) << "\n";
  const bool asks = options.arm && job.open_consent() != nullptr;
  if (!asks) return client::kExitGood;
  // Its sentence is the job's message, which is printed already.
  ReportRefusal({ErrorCode::kRefused, "", client::NameOf(intaglio_ANSWER_NEEDS_CONSENT)});
  return client::kExitMachine;
}

}  // namespace

int Watch(client::JobClient& client, const std::string& uid, const JobsOptions& options) {
  client::EventLines events(std::cout);
  return WatchJob(client, uid, options.events ? &events : nullptr);
}

int ComplainOfShop(const Error& error) {
  const bool is_there =
      error.code == ErrorCode::kFault || error.code == ErrorCode::kLinkLost;
  return Complain(error, is_there ? client::kExitMachine : client::kExitWrongInput);
}

int ComplainOf(const Error& error) { return Complain(error, client::kExitMachine); }

int Submit(const JobsOptions& given) {
  JobsOptions options = given;
  if (const auto taken = TakeAnswers(options.accept, options.job); !taken)
    return Complain(taken.error(), client::kExitWrongInput);
  if (!options.series.empty()) return SubmitSeries(options);
  if (!options.stations.empty()) return SubmitAtStations(options);
  const auto job = BuildJobToEngrave(options.job);
  if (!job) return Complain(job.error(), client::kExitWrongInput);
  for (const std::string& note : job->notes) std::cerr << note << "\n";
  PrintTextWarnings(job->warnings);
  return SubmitJob(job->job, options);
}

int Again(const JobsOptions& options) {
  const auto job = history::ReadJob(
      options.database.empty() ? options.folder + "/jobs.db" : options.database,
      options.uid);
  if (!job) return Complain(job.error(), client::kExitWrongInput);
  return SubmitJob(*job, options);
}

}  // namespace intaglio::cli
