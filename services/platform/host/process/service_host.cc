#include "services/platform/host/process/service_host.h"

#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <iostream>

#include "engrave/core/counted.h"
#include "services/platform/bus/samples.h"
#include "services/platform/command_line/parent_death.h"
#include "services/platform/host/peers/identity_role.h"
#include "services/platform/host/peers/presence.h"
#include "services/platform/host/process/bounded_end.h"
#include "services/platform/host/process/health_writer.h"
#include "services/platform/host/process/init_system.h"
#include "services/platform/host/process/log.h"
#include "services/platform/host/version/software_version.h"
#include "services/platform/link/real_time.h"

namespace intaglio::host {
namespace {

using bus::Borrow;
using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kTurnPeriod{200};
constexpr std::chrono::days kExpiryWarning{30};
constexpr std::chrono::hours kExpiryPeriod{24};
// From the last health to the end of the process; on a busy computer DDS needs seconds.
constexpr std::chrono::seconds kEndTime{20};

// Set by the signal handler; everything else about a stop happens outside of it.
std::atomic<bool> stop_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free, "used in a signal handler");

void CatchSignals() {
  struct sigaction action = {};
  action.sa_handler = [](int) { stop_asked = true; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  signal(SIGPIPE, SIG_IGN);
}

struct CommonOptions {
  bus::BusOptions bus;
  std::string log_file;
  std::string log_level = "info";
  int die_with_parent = 0;
  bool real_time = false;
  bool allow_root = false;
};

void AddCommonOptions(command_line::Command app, CommonOptions& options) {
  app.AddOption("--domain", options.bus.control_domain,
                "DDS domain of the control topics; the bulk topics take the next one")
      .Within(0, 99)
      .ShowDefault();
  app.AddOption("--interface", options.bus.interface,
                "network interface; lo: this computer only")
      .ShowDefault();
  app.AddOption("--tag", options.bus.tag,
                "only participants with the same tag communicate");
  app.AddOption("--cell", options.bus.cell, "machine cell that this service belongs to");
  app.AddOption("--security", options.bus.security,
                "folder of this service's identity, or of all roles; needed beyond lo")
      .FromEnvironment("INTAGLIO_SECURITY");
  app.AddFlag("--allow-root", options.allow_root, "serve a network even as root")
      .FromEnvironment("INTAGLIO_ALLOW_ROOT");
  app.AddOption("--log-file", options.log_file, "log file, in addition to stderr");
  app.AddOption("--log-level", options.log_level, "trace, debug, info, warning or error")
      .OneOf({"trace", "debug", "info", "warning", "error"})
      .ShowDefault();
  command_line::AddParentFlag(app, options.die_with_parent);
  app.AddFlag("--real-time", options.real_time,
              "request real-time scheduling and locked memory from the system");
}

/// A service that others can reach must not have the rights of root.
void CheckUser(const CommonOptions& options) {
  if (geteuid() != 0 || options.allow_root || options.bus.interface == "lo") return;
  throw bus::BusError(
      fmt::format("--interface {}: not as root; run it as a separate user "
                  "(deploy/systemd has units for that), or use --allow-root",
                  options.bus.interface));
}

/// The identity of a cell is that of one machine.
void CheckCell(const ServiceDescription& description, const bus::BusOptions& options) {
  const bool of_cell = description.role == intaglio_ROLE_SYNCHRONIZER ||
                       description.role == intaglio_ROLE_MOTION_BRIDGE;
  if (!of_cell || options.security.empty() || !options.cell.empty()) return;
  throw bus::BusError(
      "--security also needs --cell: the identity is that of one machine");
}

int EndByFault(ServiceHost& host, const char* code, const std::string& why) {
  host.SetHealth(intaglio_HEALTH_FAULT, {}, why);
  host.RaiseAlarm(intaglio_ALARM_FAULT, code, why);
  EndWithin(kEndTime, 1);
  return 1;
}

}  // namespace

struct ServiceHost::Impl {
  Impl(const ServiceDescription& service, const bus::BusOptions& options)
      : description(service),
        bus(options),
        health(bus, service.role, service.name),
        alarms(bus, bus::kAlarm),
        presence(bus, health.instance()) {}

  void Turn(Clock::time_point now) {
    next_turn = now + kTurnPeriod;
    LeaveWhoLostUs();
    NotifyInitAlive();
    health.Turn(now);
  }

  void LeaveWhoLostUs() {
    if (!presence.Turn(Clock::now())) return;
    LogWarning(
        "a peer does not acknowledge the samples of this service: this service leaves "
        "the domain for {} ms and rejoins",
        OneSidedLoss::kAway.count());
    bus.Leave(OneSidedLoss::kAway);
  }

  ServiceDescription description;
  bus::Bus bus;
  HealthWriter health;
  bus::Writer<intaglio_Alarm> alarms;
  Presence presence;
  Clock::time_point next_turn{}, next_expiry_check{};
  std::uint64_t alarm_number = 0;
  std::stop_source stop;
};

ServiceHost::ServiceHost(const ServiceDescription& description,
                         const bus::BusOptions& options)
    : impl_(std::make_unique<Impl>(description, options)) {
  impl_->health.Publish();
}

ServiceHost::~ServiceHost() = default;

bus::Bus& ServiceHost::bus() { return impl_->bus; }
const std::string& ServiceHost::instance() const { return impl_->health.instance(); }

std::stop_token ServiceHost::stop() const {
  if (stop_asked) impl_->stop.request_stop();
  return impl_->stop.get_token();
}

void ServiceHost::SetHealth(intaglio_HealthState state, const std::string& job_uid,
                            const std::string& message) {
  const bool began = impl_->health.state() == intaglio_HEALTH_STARTING &&
                     state != intaglio_HEALTH_STOPPING;
  if (!impl_->health.Set(state, job_uid, message)) return;
  if (began) NotifyInitReady(instance());
}

// What ends with the process cannot be sent again: a host that was too busy for this one
// sample would take an orderly end for a crash, which an arm survives.
void ServiceHost::AwaitHealthReceived() {
  constexpr std::chrono::milliseconds kPatience{500};
  if (auto received = impl_->health.WaitForAcknowledgements(kPatience); !received)
    LogWarning("the end of this service: {}", received.error().message);
}

void ServiceHost::KeepAlive() {
  (void)stop();  // hands a signal on to the code that waits on the stop token
  const Clock::time_point now = Clock::now();
  if (now >= impl_->next_turn) impl_->Turn(now);
  if (now >= impl_->next_expiry_check) WarnOfExpiry();
}

// The person who can renew it should know before the machine stops, without reading logs.
void ServiceHost::WarnOfExpiry() {
  impl_->next_expiry_check = Clock::now() + kExpiryPeriod;
  // In seconds: without an identity the end is farther than nanoseconds count.
  const auto left = bus().identity_end() - std::chrono::floor<std::chrono::seconds>(
                                               std::chrono::system_clock::now());
  if (left > kExpiryWarning) return;
  RaiseAlarm(
      intaglio_ALARM_WARNING, "identity_expires",
      fmt::format("the identity in {} expires in {}; after that other processes "
                  "drop the samples of this service: run intaglio security renew",
                  bus().options().security,
                  Counted(static_cast<std::uint64_t>(std::max<std::int64_t>(
                              0, std::chrono::floor<std::chrono::days>(left).count())),
                          "day")));
}

void ServiceHost::RaiseAlarm(intaglio_AlarmSeverity severity, const std::string& code,
                             const std::string& message, const std::string& job_uid) {
  const LogLevel level = severity == intaglio_ALARM_FAULT     ? LogLevel::kError
                         : severity == intaglio_ALARM_WARNING ? LogLevel::kWarning
                                                              : LogLevel::kInfo;
  Log(level, fmt::format("{}: {}", code, message));
  intaglio_Alarm sample{};
  sample.instance = Borrow(instance());
  sample.sequence_number = impl_->alarm_number++;
  sample.severity = severity;
  sample.cell = Borrow(impl_->bus.options().cell);
  sample.job_uid = Borrow(job_uid);
  sample.code = Borrow(code);
  sample.message = Borrow(message);
  (void)impl_->alarms.Write(sample);
}

int RunService(const ServiceDescription& description, int argc, char** argv,
               const std::function<int(ServiceHost&)>& body) {
  const pid_t parent = getppid();
  command_line::Program program("intaglio-" + description.name, description.purpose);
  program.SetVersion(SoftwareVersion());
  command_line::Command root = program.root();
  root.SetFooter(
      "Usually started by `intaglio run` or `intaglio up`; see docs/services.md.");
  CommonOptions options;
  AddCommonOptions(root, options);
  if (description.add_options) description.add_options(root);
  if (const auto exit_code = program.Parse(argc, argv)) return *exit_code;
  CatchSignals();
  if (!command_line::EndWithParent(options.die_with_parent, parent))
    return 1;  // it was quicker
  try {
    OpenLog(description.name, options.log_level, options.log_file);
    if (options.real_time) {
      const link::RealTimeGrant grant = link::AskForRealTime();
      if (!grant.granted.empty()) LogInfo("granted: {}", grant.granted);
      if (!grant.refused.empty()) LogWarning("not granted: {}", grant.refused);
    }
    CheckUser(options);
    CheckCell(description, options.bus);
    options.bus.roles = {IdentityRole(description.role, options.bus.cell)};
    ServiceHost host(description, options.bus);
    LogInfo("{} starts", host.instance());
    try {
      const int code = body(host);
      NotifyInitStopping();
      host.SetHealth(intaglio_HEALTH_STOPPING);
      host.AwaitHealthReceived();
      LogInfo("ends with exit code {}", code);
      EndWithin(kEndTime, code);
      return code;
    } catch (const std::bad_alloc&) {
      return EndByFault(host, "no_memory",
                        "the system has no more memory: remove a limit, or make the job "
                        "smaller; this service ends and may be started again");
    } catch (const std::exception& error) {
      return EndByFault(host, "internal", error.what());
    }
  } catch (const std::exception& error) {
    std::cerr << "intaglio-" << description.name << ": " << error.what() << "\n";
    return 1;
  }
}

}  // namespace intaglio::host
