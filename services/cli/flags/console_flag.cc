#include "services/cli/flags/console_flag.h"

namespace intaglio::cli {

void AddConsoleFlags(command_line::Command command, ConsoleFlags& flags) {
  const auto console =
      command
          .AddFlag("--console{0}", flags.port,
                   "open a web console of this computer and print its address; =PORT: on "
                   "that TCP port (docs/console.md)")
          .Within(0, 65535);
  client::ConsoleSetting& setting = flags.setting;
  command
      .AddOption("--console-address", setting.address,
                 "address that the console serves; one of a network, e.g. 0.0.0.0, needs "
                 "a certificate, users and --security")
      .Need(console);
  const auto certificate =
      command
          .AddOption("--console-certificate", setting.certificate,
                     "PEM file of the names by which this computer is opened")
          .Need(console);
  certificate.Need(command
                       .AddOption("--console-private-key", setting.private_key,
                                  "PEM file, of the certificate")
                       .Need(certificate));
  command
      .AddOption("--console-users", setting.users,
                 "file of who may log in, default console.users in the folder")
      .Need(console);
  command
      .AddOption("--console-webhooks", setting.webhooks,
                 "file of the receivers that get the events of jobs by HTTP")
      .Need(console);
}

client::ConsoleSetting SettingOf(const ConsoleFlags& flags) {
  client::ConsoleSetting setting = flags.setting;
  setting.port = flags.port.empty() ? -1 : std::stoi(flags.port);
  return setting;
}

}  // namespace intaglio::cli
