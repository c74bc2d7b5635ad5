#include <signal.h>
#include <unistd.h>

#include <csignal>
#include <iostream>

#include "services/client/exit_codes.h"
#include "services/client/shop_flags.h"
#include "services/console/console.h"
#include "services/platform/command_line/parent_death.h"
#include "services/platform/command_line/program.h"
#include "services/platform/host/process/service_host.h"
#include "services/platform/host/version/software_version.h"

namespace {

using namespace intaglio;

/// A receiver has not accepted --ping-webhook.
constexpr int kExitNotAccepted = 1;

volatile std::sig_atomic_t g_stopping = 0;

void CatchSignals() {
  struct sigaction action {};
  action.sa_handler = [](int) { g_stopping = 1; };
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  signal(SIGPIPE, SIG_IGN);
}

int Ping(const console::ConsoleOptions& options, const std::string& receiver) {
  const auto answer = console::PingReceiver(options, receiver);
  if (!answer) {
    std::cerr << "intaglio-console: " << answer.error().message << "\n";
    return client::kExitWrongInput;
  }
  (answer->is_accepted ? std::cout : std::cerr) << answer->sentence << "\n";
  return answer->is_accepted ? client::kExitGood : kExitNotAccepted;
}

int Run(const console::ConsoleOptions& options, const std::string& ping) {
  CatchSignals();
  try {
    if (!ping.empty()) return Ping(options, ping);
    const Status served = console::Serve(
        options, [] { return g_stopping != 0; },
        [](const std::string& address) {
          std::cout << "the console is open: " << address << std::endl;
        });
    if (served) return client::kExitGood;
    std::cerr << "intaglio-console: " << served.error().message << "\n";
    return client::kExitWrongInput;
  } catch (const std::exception& error) {
    std::cerr << "intaglio-console: " << error.what() << "\n";
    return client::kExitInternal;
  }
}

}  // namespace

int main(int argc, char** argv) {
  const pid_t parent = getppid();
  command_line::Program program("intaglio-console",
                                "shows a shop in a browser, with a button that stops it");
  program.SetVersion(host::SoftwareVersion());
  command_line::Command root = program.root();
  console::ConsoleOptions options;
  std::string ping;
  int starter = 0;
  client::AddShopFlags(root, options.bus,
                       "folder of the operator's identity, or of all roles; needed "
                       "beyond lo");
  options.bus.roles = {"operator"};
  root.AddOption("--port", options.port,
                 "TCP port; 0: that of --address-file, or a free one")
      .Within(0, 65535)
      .ShowDefault();
  root.AddOption("--address", options.address,
                 "address to serve; one of a network, e.g. 0.0.0.0, needs --certificate, "
                 "--users and --security")
      .ShowDefault();
  const auto certificate =
      root.AddOption("--certificate", options.certificate_file,
                     "PEM file of the names by which this computer is opened; "
                     "connections are encrypted then");
  certificate.Need(
      root.AddOption("--private-key", options.key_file, "PEM file, of the certificate")
          .Need(certificate));
  root.AddOption("--address-file", options.address_file,
                 "file for the printed address; a console that is started again keeps "
                 "its port and key");
  root.AddOption("--users", options.users_file,
                 "file of who may log in, as `intaglio console user add` writes it");
  root.AddOption("--audit", options.audit_file,
                 "file that gets a line of each press and each log-in");
  root.AddOption("--database", options.database,
                 "database file of the job service, for the history");
  root.AddOption("--materials", options.materials,
                 "material base of previews, default the user's");
  root.AddOption("--uploads", options.uploads,
                 "folder for the files of jobs that are submitted here; without it none "
                 "are");
  const auto webhooks = root.AddOption(
      "--webhooks", options.webhooks,
      "file of the receivers that get the events of jobs by HTTP; docs/console.md");
  root.AddOption("--ping-webhook", ping,
                 "name of a receiver: send it the event ping, print its answer, and end "
                 "with 0 when it has accepted it, else 1")
      .Need(webhooks);
  command_line::AddParentFlag(root, starter);
  root.SetFooter(
      "Usually started by `intaglio up --console`; see docs/console.md.\n"
      "It is not the emergency stop of the machine: at a machine, use its button.");
  if (const auto exit_code = program.Parse(argc, argv)) return *exit_code;
  if (!command_line::EndWithParent(starter, parent)) return 1;  // it was quicker
  return Run(options, ping);
}
