#include "services/cli/bus_flags.h"

#include <CLI/App.hpp>

namespace intaglio::cli {

void AddBusFlags(CLI::App& command, bus::BusOptions& options) {
  command
      .add_option("--domain", options.control_domain,
                  "DDS domain of the control topics; bulk takes the next one")
      ->check(CLI::Range(0, 99))
      ->capture_default_str();
  command
      .add_option("--interface", options.interface,
                  "network interface; lo stays on this machine")
      ->capture_default_str();
  command.add_option("--tag", options.tag, "only participants of the same tag are seen");
  command
      .add_option("--security", options.security,
                  "folder of the operator's or observer's identity, or of all roles; "
                  "needed beyond lo")
      ->envname("INTAGLIO_SECURITY");
  options.roles = {"operator", "observer"};
}

}  // namespace intaglio::cli
