#include "services/cli/flags/bus_flags.h"

namespace intaglio::cli {

void AddPrivateBusFlags(command_line::Command command, bus::BusOptions& options) {
  command
      .AddOption("--domain", options.control_domain,
                 "DDS domain of the control topics; bulk takes the next one")
      .Within(0, 99)
      .ShowDefault();
  command
      .AddOption("--interface", options.interface,
                 "network interface; lo: this computer only")
      .ShowDefault();
  command.AddOption("--tag", options.tag, "DDS tag, default a private one");
  command
      .AddOption("--security", options.security,
                 "folder of the operator's, submitter's or observer's identity, or of "
                 "all roles; needed beyond lo")
      .FromEnvironment("INTAGLIO_SECURITY");
  options.roles = {"operator", "submitter", "observer"};
}

void AddBusFlags(command_line::Command command, bus::BusOptions& options) {
  AddPrivateBusFlags(command, options);
  command.OptionOf("--domain").FromEnvironment("INTAGLIO_DOMAIN");
  command.OptionOf("--interface").FromEnvironment("INTAGLIO_INTERFACE");
  command.OptionOf("--tag")
      .Describe("only participants with the same tag communicate")
      .FromEnvironment("INTAGLIO_TAG");
}

}  // namespace intaglio::cli
