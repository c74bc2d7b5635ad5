#include "services/cli/run_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <iostream>

#include "engrave/core/try.h"
#include "materials_db/material_store.h"
#include "services/cli/flags/console_flag.h"
#include "services/cli/flags/size_limits_flag.h"
#include "services/cli/job/job_glass.h"
#include "services/cli/job/job_options.h"
#include "services/cli/job/run_flags.h"
#include "services/cli/marks/virtual_web.h"
#include "services/cli/progress/progress_bar.h"
#include "services/cli/progress/stage_bars.h"
#include "services/cli/progress/warning_lines.h"
#include "services/cli/run_folder.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/arm_once.h"
#include "services/client/event_lines.h"
#include "services/client/exit_codes.h"
#include "services/client/figure_text.h"
#include "services/client/folder_name.h"
#include "services/client/job_client.h"
#include "services/client/proof/evidence/verdict_text.h"
#include "services/client/proof/proof_folder.h"
#include "services/client/shop/service_set.h"
#include "services/client/shop/virtual_truth.h"
#include "services/job/checks/job_check.h"
#include "services/job/fields/job_kind.h"
#include "services/job/fields/shapes.h"
#include "services/platform/bus/bus_option_error.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kPatience = 10s;  // with a loss
constexpr auto kCancelTimeout = 10s;

/// One `intaglio run`, from the checked job to the verdict.
class RunSession {
 public:
  /// `optics`: of a job that engraves.
  RunSession(RunOptions options, JobAndMachine job,
             std::optional<materials_db::OpticalValues> optics)
      : options_(std::move(options)),
        job_(std::move(job)),
        optics_(optics),
        bar_(std::cerr, isatty(STDERR_FILENO) != 0) {}

  int Run();

 private:
  Status MakeFolders();
  MountedParts PartsOfJob() const;
  Result<client::VirtualMachine> MachineOf() const;
  Result<client::ServiceSet> StartServices(const client::VirtualMachine& machine);
  int Engrave(client::ServiceSet& services);
  int Follow(client::ServiceSet& services, client::JobClient& client,
             client::JobView job);
  void Show(const client::JobView& job);
  void WriteEnd(client::JobEnd end, const client::JobView& job);
  void Print(const std::vector<std::string>& sentences);
  void Arm(client::JobClient& client, const client::JobView& job);
  bool GoesOn(const client::JobView& job);
  void Cancel(client::JobClient& client, const client::JobView& job,
              const std::string& why);
  int Prove(const client::JobView& job, const client::JobClient& client,
            const client::ServiceSet& services);

  RunOptions options_;
  JobAndMachine job_;
  std::optional<materials_db::OpticalValues> optics_;
  ProgressBar bar_;
  StageBars bars_{bar_, options_.lockstep ? 0 : options_.speed};
  WarningLines warnings_{bar_};
  client::EventLines events_{std::cout};
  std::optional<ShopVerdict> proved_;  // by the glass; none: nothing to prove
  fs::path out_, session_;
  std::string started_utc_ = client::UtcNow();
  Clock::time_point started_ = Clock::now();
  bool cancelled_ = false;
  std::optional<client::ArmOnce> arm_;
  std::uint32_t armed_attempt_ = 0;
  bool arm_holds_ = true;
  std::optional<Clock::time_point> paused_since_;
  Clock::time_point give_up_ = Clock::time_point::max();
};

Status RunSession::MakeFolders() {
  out_ = options_.out.empty()
             ? fs::path("intaglio-out") /
                   fmt::format("{}-{}", client::FolderNameOf(job_.job.name()),
                               client::FolderTimeOf(client::UtcNow()))
             : fs::path(options_.out);
  out_ = fs::absolute(out_).lexically_normal();
  session_ = out_ / "session";
  return PrepareRunFolder(out_, session_);
}

MountedParts RunSession::PartsOfJob() const {
  if (!optics_) return {.piece = "virtual piece"};
  return {BlockSizeOf(job_.job), optics_->refractive_index, LensOf(job_.job),
          job_.job.glass()};
}

Result<client::VirtualMachine> RunSession::MachineOf() const {
  client::VirtualMachine machine;
  machine.truth = job_.job.has_course()
                      ? client::TruthOfMill(job_.machine, job_.job.course())
                      : client::TruthOf(job_.machine, PartsOfJob());
  const double web_mm_s =
      INTAGLIO_TRY(VirtualWebSpeed(job_.job, job_.machine, options_.job.size_limits));
  if (web_mm_s > 0) machine.truth.mutable_head()->set_web_mm_s(web_mm_s);
  if (job_.job.marks().web().has_eye()) {
    machine.truth.mutable_head()->set_print_pitch_mm(
        job_.job.marks().repeats().pitch_mm());
  }
  INTAGLIO_TRY(options_.truth.Change(machine.truth));
  machine.speed = options_.lockstep ? "lockstep" : fmt::format("{}", options_.speed);
  machine.faults = options_.faults;
  return machine;
}

Result<client::ServiceSet> RunSession::StartServices(
    const client::VirtualMachine& machine) {
  client::ServiceSetOptions set;
  set.folder = session_;
  set.results = session_ / "jobs";
  set.materials_db = options_.materials_db;
  set.machine = job_.machine;
  if (options_.bus.tag.empty()) options_.bus.tag = PrivateTag();
  options_.bus.cell = job_.machine.name();
  set.bus = options_.bus;
  set.without = {options_.without.begin(), options_.without.end()};
  if (options_.record) set.recording = out_ / "session.mcap";
  set.recording_bulk = options_.bulk;
  set.console = SettingOf(options_.console);
  HandOnSizeLimits(options_.job.size_limits);
  return client::ServiceSet::Start(set, &machine);
}

int RunSession::Run() {
  if (MakesMarks(job_.job)) bar_.CountIn("marks");
  for (const std::string& note : job_.notes) std::cerr << note << "\n";
  if (auto made = MakeFolders(); !made)
    return Complain(made.error(), client::kExitWrongInput);
  const auto machine = MachineOf();
  if (!machine) return Complain(machine.error(), client::kExitWrongInput);
  auto services = StartServices(*machine);
  if (!services) {
    return Complain(services.error(), services.error().code == ErrorCode::kUnsupported
                                          ? client::kExitWrongInput
                                          : client::kExitInternal);
  }
  try {
    return Engrave(*services);
  } catch (const bus::BusOptionError& error) {
    return Complain(error.error(), client::kExitWrongInput);
  } catch (const bus::BusError& error) {
    return Complain({ErrorCode::kFault, error.what(), ""}, client::kExitInternal);
  }
}

int RunSession::Engrave(client::ServiceSet& services) {
  bus::Bus bus(options_.bus);
  client::JobClient client(bus);
  if (auto ready = services.AwaitReady(client); !ready) {
    return Complain(ready.error(), client::kExitInternal);
  }
  const auto reported =
      client.Mount(job_.machine.name(), PartsOfJob(), intaglio_ARM_BY_PERSON);
  if (!reported) return Complain(reported.error(), client::kExitInternal);
  std::cerr << fmt::format("processes   {}, logs in {}\n",
                           fmt::join(services.Processes(), ", "), session_.string());
  if (!options_.console.port.empty()) {
    const auto address = services.AwaitConsole();
    if (!address) return Complain(address.error(), client::kExitWrongInput);
    std::cerr << "web console " << *address << "\n";
  }
  JobSpec job = job_.job;
  job.set_machine_file(services.machine_file().string());
  auto submitted = client.Submit(job, 20s);
  if (!submitted) return Complain(submitted.error(), client::kExitWrongInput);
  if (options_.events) events_.Submitted(*submitted);
  return Follow(services, client, *submitted);
}

void RunSession::Show(const client::JobView& job) {
  if (options_.events && !job.ended()) events_.Show(job);
  warnings_.Show(job.warnings);
  std::string note = EstimateNote(job);
  if (!job.message.empty()) note += (note.empty() ? "" : ", ") + job.message;
  bars_.Show(job, note);
}

// The person who types `run` is beside the machine: that is the operator's arm. The
// machine is this session's alone, so no other block was in it when a lost process costs
// an attempt, and the arm is given once more, unless a person has taken it back.
void RunSession::Arm(client::JobClient& client, const client::JobView& job) {
  if (job.state == intaglio_JOB_QUEUED || job.ended()) return;
  if (!arm_ || (job.attempt != armed_attempt_ && arm_holds_)) {
    arm_.emplace(client, job,
                 client::ArmTerms{options_.accept.breakage(), intaglio_ARM_BY_PERSON});
  }
  armed_attempt_ = job.attempt;
  const client::ArmOnce::State state = arm_->Follow(job);
  if (arm_holds_ && state == client::ArmOnce::State::kLeft) {
    Print({fmt::format("waits for a person: {}; then intaglio arm {} --tag {}",
                       arm_->reason(), job.number, options_.bus.tag)});
  }
  arm_holds_ = state != client::ArmOnce::State::kLeft &&
               (state != client::ArmOnce::State::kArmed || job.armed);
}

// What was lost is resumed by the job service. Everything else that pauses a machine is
// for a person to check, and so is a loss that lasts.
bool RunSession::GoesOn(const client::JobView& job) {
  if (job.state != intaglio_JOB_PAUSED) {
    paused_since_.reset();
    return true;
  }
  // A pause by a person ends when a person ends it.
  if (job.paused_by_operator()) return true;
  if (!paused_since_) {
    paused_since_ = Clock::now();
    bar_.Finish();
    std::cerr << "paused: " << job.message << "\n";
  }
  return job.armed && Clock::now() - *paused_since_ < kPatience;
}

void RunSession::Print(const std::vector<std::string>& sentences) {
  if (!sentences.empty()) bar_.Finish();
  for (const std::string& sentence : sentences) std::cerr << sentence << "\n";
}

void RunSession::Cancel(client::JobClient& client, const client::JobView& job,
                        const std::string& why) {
  if (cancelled_) return;
  cancelled_ = true;
  bar_.Finish();
  std::cerr << why << "\n";
  (void)client.Send(job, {.kind = intaglio_COMMAND_CANCEL});
  give_up_ = Clock::now() + kCancelTimeout;
}

int RunSession::Follow(client::ServiceSet& services, client::JobClient& client,
                       client::JobView job) {
  std::optional<Error> fault;
  while (!job.ended() && Clock::now() < give_up_) {
    client.Poll(50ms);
    job = client.jobs().at(job.uid);
    if (!cancelled_) Show(job);
    if (auto refused = WhyRefused(job, options_.accept); refused && !fault) {
      fault = std::move(refused);
      Cancel(client, job, "a warning is not accepted: the job is cancelled");
    }
    if (!cancelled_) Arm(client, job);
    if (Interrupts() > 0) Cancel(client, job, "interrupted: the job is cancelled");
    const auto revived = services.Revive();
    if (!revived && !fault) {
      fault = revived.error();
      Cancel(client, job, "a process has died: the job is cancelled");
    }
    if (revived) Print(*revived);
    if (!fault && !cancelled_ && !GoesOn(job)) {
      fault = Error{ErrorCode::kFault, job.message, ""};
      Cancel(client, job, "the machine has paused: the job is cancelled");
    }
  }
  bar_.Finish();
  // Give the outcome of every stage time to arrive.
  client.PollUntil(
      [&] { return client.OutcomeOf(job.uid, intaglio_STAGE_ENGRAVE).has_value(); },
      job.state == intaglio_JOB_FAILED ? 200ms : 2000ms);
  const client::JobEnd end = EndOf(client, job);
  services.EndMaking();
  const int proved = Prove(job, client, services);
  services.Stop();
  if (options_.events) WriteEnd(end, job);
  if (fault) return Complain(*fault, client::kExitMachine);
  if (cancelled_) return client::kExitCancelled;
  if (job.state != intaglio_JOB_DONE) {
    return Complain({ErrorCode::kFault, job.message, ""}, client::kExitMachine);
  }
  return proved;
}

void RunSession::WriteEnd(client::JobEnd end, const client::JobView& job) {
  if (proved_) end.verdict = *proved_;
  client::JobView proof = job;
  proof.result_directory = out_.string();
  events_.Ended(proof, end);
}

int RunSession::Prove(const client::JobView& job, const client::JobClient& client,
                      const client::ServiceSet& services) {
  client::ProofInputs inputs;
  inputs.folder = out_;
  inputs.job_folder = job.result_directory;
  inputs.glass_record = services.glass_record();
  inputs.discretize = client.OutcomeOf(job.uid, intaglio_STAGE_DISCRETIZE);
  inputs.sort = client.OutcomeOf(job.uid, intaglio_STAGE_SORT);
  inputs.engrave = client.OutcomeOf(job.uid, intaglio_STAGE_ENGRAVE);
  for (const std::string& note : job_.notes)
    inputs.warnings.push_back(MakeWarning(WarningCode::kChosen, note));
  inputs.warnings.insert(inputs.warnings.end(), job.warnings.begin(), job.warnings.end());
  inputs.breakage_accepted_by = job.breakage_accepted_by;
  inputs.started_utc = started_utc_;
  inputs.ended_utc = client::UtcNow();
  inputs.wall_time_s = std::chrono::duration<double>(Clock::now() - started_).count();
  inputs.job_number = job.number;
  // A job that ended before its engraving began left nothing to prove.
  if (job.open_consent() != nullptr || !client::HasPlan(inputs.job_folder))
    return client::kExitMachine;
  const auto report = client::MakeProof(inputs);
  if (!report) return Complain(report.error(), client::kExitWrongInput);
  std::ostream& human = options_.events ? std::cerr : std::cout;
  const auto drawn =
      PresentProof(human, *report, out_, options_.record, options_.picture);
  if (!drawn) return Complain(drawn.error(), client::kExitWrongInput);
  proved_ = {client::KindOf(report->verdict()),
             fmt::format("{}", fmt::join(report->verdict().reasons(), "; "))};
  return client::ExitCodeOf(proved_->verdict);
}

int RunJob(const RunOptions& given) {
  CatchInterrupts();
  RunOptions options = given;
  if (const auto taken = TakeAnswers(options.accept, options.job); !taken)
    return Complain(taken.error(), client::kExitWrongInput);
  auto job = BuildJobToEngrave(options.job);
  if (!job) return Complain(job.error(), client::kExitWrongInput);
  options.materials_db = materials_db::DatabasePathOf(options.materials_db).string();
  if (MakesMarks(job->job))
    return RunSession(std::move(options), std::move(*job), std::nullopt).Run();
  const auto optics = FindOptics(*job, options.materials_db);
  if (!optics) return Complain(optics.error(), client::kExitWrongInput);
  return RunSession(std::move(options), std::move(*job), *optics).Run();
}

}  // namespace

void AddRunCommand(command_line::Command app) {
  auto options = std::make_shared<RunOptions>();
  command_line::Command run = app.AddCommand(
      "run",
      "make one job in the virtual engraver, scan head or mill, with a separate "
      "set of processes, and prove the result");
  run.SetFooter(
      "Example: intaglio run bunny.obj --height 40 --lockstep --out DIR\n"
      "Example: intaglio run label.textproto --lockstep --out DIR\n"
      "Exit code: 0 good, 1 internal fault, 2 wrong input, 3 engraved but not good, "
      "4 machine fault, 5 cancelled.");
  AddRunFlags(run, *options);
  run.SetAction([options] { return RunJob(*options); });
}

}  // namespace intaglio::cli
