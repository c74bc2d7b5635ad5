#pragma once

#include <string>

#include "services/client/shop/service_set.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

struct ConsoleFlags {
  /// The value of --console[=PORT]: a port, "0" a free one, empty no console. A text,
  /// because a flag that is a number is counted: it begins at 0, and 0 counts as "no".
  std::string port;
  client::ConsoleSetting setting;  ///< its port is filled in by SettingOf
};

/// --console[=PORT], and where it serves: --console-address, --console-certificate,
/// --console-private-key, --console-users; --console-webhooks.
void AddConsoleFlags(command_line::Command command, ConsoleFlags& flags);

/// Port -1 without a console.
client::ConsoleSetting SettingOf(const ConsoleFlags& flags);

}  // namespace intaglio::cli
