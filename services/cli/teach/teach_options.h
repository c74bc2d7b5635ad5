#pragma once

// What the commands of `intaglio teach` share.

#include <chrono>
#include <functional>
#include <iosfwd>
#include <optional>
#include <string>

#include "services/client/teach_client.h"
#include "services/platform/command_line/program.h"
#include "services/platform/host/process/patience.h"

namespace intaglio::cli {

struct TeachOptions {
  bus::BusOptions bus;
  std::string cell;
  bool json = false;
};

/// --cell and the flags of the bus.
void AddTeachFlags(command_line::Command command, TeachOptions& options);

/// Connects, and runs `action`; its exit code, or that of the error.
int WithMachine(const TeachOptions& options,
                const std::function<int(client::TeachClient&)>& action);

/// A machine whose services have just started has no report of key, door and permission
/// for a moment: an order that is refused for that is given again, for kTime, while its
/// command runs.
class ReportWait {
 public:
  /// On a computer that is not busy (patience.h).
  static constexpr std::chrono::seconds kTime{3};

  explicit ReportWait(client::TeachClient& client) : client_(client) {}
  /// The order that was answered last may be given again; the first time this is printed.
  bool MayGiveAgain();
  /// Gives `order` again when it may be; `number` is then that of the new one.
  bool GivesAgain(const client::TeachOrder& order, std::uint64_t& number);

 private:
  client::TeachClient& client_;
  std::optional<host::Patience> patience_;
};

/// Executes one order, prints the answer; the exit code. Ctrl-C lets go.
int ExecuteOrder(client::TeachClient& client, const client::TeachOrder& order,
                 std::chrono::milliseconds timeout = std::chrono::seconds(10));

/// The same for an order that moves to a place; prints where the machine is then.
int ExecuteMove(client::TeachClient& client, const client::TeachOrder& order,
                std::chrono::milliseconds timeout);

/// The question of `intaglio teach home`: true when a line of `in` says y or yes. The
/// axes drive to where they count from, on a way that no limit of the profile bounds.
bool AllowsHome(std::istream& in, std::ostream& out, const std::string& machine);

/// "x 1.5000 mm, y 0.0000 mm, c 0.2500 rad".
std::string PlaceText(const client::MachineView& view);

/// The number of the axis with this name; kNotFound lists them.
Result<int> AxisByName(const client::MachineView& view, const std::string& name);

/// Positions, limits and interlocks, for people.
std::string TextOf(const client::MachineView& view);

/// The screen of `intaglio teach`, until q or Ctrl-C; the exit code.
int ShowTeachScreen(client::TeachClient& client);

}  // namespace intaglio::cli
