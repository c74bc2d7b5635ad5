#pragma once

#include <string>
#include <vector>

#include "services/platform/bus/bus.h"
#include "services/platform/command_line/program.h"

namespace intaglio::client {

/// --domain, --interface, --tag, --security: where a client finds its shop; without them,
/// what INTAGLIO_DOMAIN, _INTERFACE, _TAG and _SECURITY have. `identities`: the help of
/// --security.
void AddShopFlags(command_line::Command command, bus::BusOptions& options,
                  const std::string& identities);

/// The same of a session with services of its own, which has a private tag: a shop that
/// the environment names is not joined.
void AddPrivateShopFlags(command_line::Command command, bus::BusOptions& options,
                         const std::string& identities);

/// The same options as words, for another program.
std::vector<std::string> ShopArguments(const bus::BusOptions& options);

}  // namespace intaglio::client
