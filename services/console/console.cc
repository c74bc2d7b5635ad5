#include "services/console/console.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "engrave/core/try.h"
#include "services/client/shop_flags.h"
#include "services/console/answers/json_response.h"
#include "services/console/api.h"
#include "services/console/console_address.h"
#include "services/console/focus_places.h"
#include "services/console/job_finder.h"
#include "services/console/page_files.h"
#include "services/console/plans_ahead.h"
#include "services/console/submit/about_times.h"
#include "services/console/webhooks/webhooks.h"
#include "services/platform/access/new_key.h"
#include "services/platform/access/users.h"
#include "services/platform/command_line/other_programs.h"
#include "services/platform/host/process/health_writer.h"
#include "services/platform/host/process/log.h"
#include "services/platform/web/server.h"

namespace intaglio::console {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kStatePeriod = 100ms;
/// Longer than a submission takes (submissions.cc).
constexpr auto kAnswerTime = 120s;
// At 30 ms each; then a log-in is asked to come again.
constexpr std::size_t kMaxLogIns = 16;

/// Ends the server's thread before anything that it uses goes.
class RunningServer {
 public:
  explicit RunningServer(web::Server& server)
      : server_(server), thread_([this] { server_.Run(); }) {}
  RunningServer(const RunningServer&) = delete;
  RunningServer& operator=(const RunningServer&) = delete;
  ~RunningServer() {
    server_.Stop();
    thread_.join();
  }

 private:
  web::Server& server_;
  std::thread thread_;
};

bool IsOfThisComputer(const std::string& address) {
  return address.starts_with("127.") || address == "::1";
}

/// What a console of a network lacks. kInvalidValue with the remedy.
Status CheckExposure(const ConsoleOptions& options) {
  if (IsOfThisComputer(options.address)) return {};
  std::string missing;
  if (options.certificate_file.empty()) {
    missing +=
        " an encrypted connection (--certificate FILE --private-key FILE, for the names "
        "by which this computer is opened);";
  }
  const auto users = access::ReadUsers(options.users_file);
  if (!users || users->empty()) {
    missing += fmt::format(
        " a log-in (intaglio console user add NAME --role operator --users FILE, and "
        "--users FILE: {});",
        users ? "it has no user" : users.error().message);
  }
  if (options.bus.security.empty())
    missing += " an identity of an operator (--security FOLDER);";
  if (missing.empty()) return {};
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("address {}: a network needs{} or use 127.0.0.1 and a tunnel "
                          "(ssh -L)",
                          options.address, missing),
              options.address);
}

/// The one of the file where there is one, so that an open page finds a console that was
/// started again.
ConsoleAddress AddressBefore(const ConsoleOptions& options) {
  ConsoleAddress address;
  address.port = static_cast<std::uint16_t>(options.port);
  if (IsOfThisComputer(options.address)) address.key = access::NewKey();
  if (options.address_file.empty()) return address;
  const auto before = ReadAddressFile(options.address_file);
  if (!before) return address;
  if (!address.key.empty() && !before->key.empty()) address.key = before->key;
  if (options.port == 0) address.port = before->port;
  return address;
}

web::ServerOptions ServerOptionsOf(const ConsoleOptions& options,
                                   const ConsoleAddress& address) {
  web::ServerOptions server;
  server.address = options.address;
  server.port = address.port;
  server.key = address.key;
  server.certificate_file = options.certificate_file;
  server.key_file = options.key_file;
  server.pages = PageFiles();
  for (const Route& route : Routes()) {
    if (route.right == Right::kOpen) server.open_paths.emplace_back(route.path);
  }
  server.event_paths = {kEventsPath};
  server.socket_paths = {kControlPath};
  server.long_paths = {kSubmissionsPath, kPhotosPath};
  server.limits.answer_time = kAnswerTime;
  return server;
}

Result<std::vector<Receiver>> ReceiversOf(const ConsoleOptions& options) {
  if (options.webhooks.empty()) return std::vector<Receiver>();
  return ReadReceivers(options.webhooks);
}

/// Says on the bus where the console serves, so that others link to it. Nothing with an
/// identity that was made before operators had that right.
class Announcement {
 public:
  Announcement(bus::Bus& bus, const std::string& link) {
    try {
      health_.emplace(bus, intaglio_ROLE_CONSOLE, "console");
    } catch (const bus::BusError& error) {
      host::LogWarning("other consoles do not link to this one: {}", error.what());
      return;
    }
    health_->Set(intaglio_HEALTH_READY, {}, link);
  }
  Announcement(const Announcement&) = delete;
  Announcement& operator=(const Announcement&) = delete;
  ~Announcement() {
    if (health_) health_->Set(intaglio_HEALTH_STOPPING, {}, {});
  }
  void Turn() {
    if (health_) health_->Turn(Clock::now());
  }

 private:
  std::optional<host::HealthWriter> health_;
};

std::vector<ShopMachine> ProfilesOf(const std::vector<client::MachineView>& machines) {
  std::vector<ShopMachine> profiles;
  for (const client::MachineView& machine : machines)
    profiles.push_back({machine.cell, machine.profile});
  return profiles;
}

void Turn(ShopDesk& desk, JogDesk& jogs, AboutTimes& about, FocusPlaces& focus,
          PlansAhead& plans, ConsoleAccess& access, Webhooks& webhooks,
          web::Server& server, Clock::time_point& next_state) {
  desk.Turn(jogs.IsAtWork(Clock::now()));
  for (const auto& [page, view] : jogs.TakeNew(Clock::now()))
    server.Send(page, LineOf(view));
  for (std::string& line : desk.TakeEvents()) {
    webhooks.Publish(line);
    server.Publish(kEventsPath, std::move(line));
  }
  // What a person waits for comes at once.
  if (Clock::now() < next_state && !desk.IsConfirmedAnew()) return;
  next_state = Clock::now() + kStatePeriod;
  for (std::string& session : access.TakeEnded(Clock::now()))
    server.EndSession(std::move(session));
  ConsoleState state = desk.State();
  state.set_in_charge(access.InCharge());
  focus.Add(desk.client().jobs(), state);
  plans.Follow(desk.client().jobs());
  about.Follow(desk.client().jobs(), Clock::now());
  for (AboutTime& time : about.Known()) *state.add_about() = std::move(time);
  if (std::string line = LineOf(state); !line.empty())
    server.Publish(kControlPath, std::move(line));
}

}  // namespace

Status Serve(const ConsoleOptions& options, const std::function<bool()>& stopping,
             const std::function<void(const std::string& address)>& opened) {
  INTAGLIO_TRY(CheckExposure(options));
  auto receivers = INTAGLIO_TRY(ReceiversOf(options));
  Webhooks webhooks(std::move(receivers));
  bus::Bus bus(options.bus);
  ShopDesk desk(bus);
  ConsoleAccess access(options.users_file);
  AuditLog audit(options.audit_file);
  std::unique_ptr<web::Server> server;
  CloudReader clouds;  // its answers go to the server, which lives longer
  WorkQueue log_ins(kMaxLogIns);
  JogDesk jogs(bus);
  SubmitApi submit(
      {options.uploads, client::ShopArguments(options.bus), options.materials.string(),
       [&jogs] { return ProfilesOf(jogs.Machines(JogDesk::Clock::now())); }});
  const FindJob find_job = JobFinder(desk, clouds, options.database.string());
  TeachApi teach(jogs, submit, find_job, options.materials.string());
  PhotoApi photos(find_job, clouds,
                  {command_line::ProgramFolder() / "intaglio-picture-reader"});
  Api api(desk, clouds, access, audit, log_ins, submit, jogs, teach, photos, webhooks,
          find_job, options.database);
  web::Handlers handlers;
  handlers.request = [&](const web::Request& request, web::Reply reply) {
    api.Answer(request, std::move(reply));
  };
  handlers.body = [&](const web::Request& request, std::uint64_t body_bytes,
                      web::Reply reply) {
    return api.Receive(request, body_bytes, std::move(reply));
  };
  handlers.greeting = [](const std::string&) { return std::string(); };
  handlers.message = [&](web::PeerId peer, const web::Caller& caller,
                         const std::string& text) {
    server->Send(peer, api.AnswerMessage(peer, caller, text));
  };
  handlers.refusal = [](int status, const std::string& sentence) {
    return ErrorResponse(status, sentence);
  };
  handlers.session = [&](const std::string& token) {
    const auto session = access.log_ins().Find(token, Clock::now());
    return session ? session->id : std::string();
  };
  ConsoleAddress address = AddressBefore(options);
  auto made = web::Server::Open(ServerOptionsOf(options, address), handlers);
  if (!made && options.port == 0 && address.port != 0) {
    address.port = 0;  // that of the file is another program's by now
    made = web::Server::Open(ServerOptionsOf(options, address), handlers);
  }
  if (!made) return tl::unexpected(made.error());
  server = std::move(*made);
  address.origin = server->origin();
  address.port = server->port();
  const RunningServer running(*server);
  if (!options.address_file.empty())
    INTAGLIO_TRY(WriteAddressFile(options.address_file, address));
  opened(TextOf(address));
  auto next_state = Clock::now();
  AboutTimes about(options.database, options.materials.string());
  FocusPlaces focus(clouds);
  PlansAhead plans(clouds);
  Announcement announcement(bus, fmt::format("{}:{}", server->origin(), server->port()));
  while (!stopping()) {
    Turn(desk, jogs, about, focus, plans, access, webhooks, *server, next_state);
    announcement.Turn();
  }
  return {};
}

Result<PingAnswer> PingReceiver(const ConsoleOptions& options, const std::string& name) {
  const auto receivers = INTAGLIO_TRY(ReceiversOf(options));
  const auto receiver = std::ranges::find(receivers, name, &Receiver::name);
  if (receiver == receivers.end()) {
    std::string names;
    for (const Receiver& one : receivers) names += (names.empty() ? "" : ", ") + one.name;
    return Fail(ErrorCode::kNotFound,
                fmt::format("--ping-webhook: {} has no receiver {:?}; give one of {}",
                            options.webhooks.string(), name, names),
                name);
  }
  const WebhookAnswer answer = Ping(*receiver);
  PingAnswer ping;
  ping.is_accepted = answer.outcome() == DeliveryOutcome::kDelivered;
  ping.sentence =
      fmt::format("{} ({}): {}", receiver->name, receiver->place, answer.Sentence());
  if (!answer.body.empty()) ping.sentence += fmt::format(": {:?}", answer.body);
  if (!ping.is_accepted) ping.sentence += "; accepted is an answer of 200 to 299";
  return ping;
}

}  // namespace intaglio::console
