#include "services/cli/flags/bus_flags.h"

#include "services/client/shop_flags.h"

namespace intaglio::cli {
namespace {

constexpr char kIdentities[] =
    "folder of the operator's, submitter's or observer's identity, or of all roles; "
    "needed beyond lo";

}  // namespace

void AddPrivateBusFlags(command_line::Command command, bus::BusOptions& options) {
  client::AddPrivateShopFlags(command, options, kIdentities);
  options.roles = {"operator", "submitter", "observer"};
}

void AddBusFlags(command_line::Command command, bus::BusOptions& options) {
  client::AddShopFlags(command, options, kIdentities);
  options.roles = {"operator", "submitter", "observer"};
}

bus::BusOptions WithoutCells(bus::BusOptions options) {
  options.meets_cells = false;
  return options;
}

}  // namespace intaglio::cli
