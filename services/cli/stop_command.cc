#include "services/cli/stop_command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <ranges>
#include <set>
#include <string>
#include <thread>
#include <vector>

#include "services/cli/flags/bus_flags.h"
#include "services/cli/terminal/complain.h"
#include "services/client/exit_codes.h"
#include "services/client/shop/shop_stops.h"
#include "services/client/shop/stop_reset.h"
#include "services/platform/host/peers/role_refusal.h"

namespace intaglio::cli {
namespace {

using client::kEveryMachine;
using client::MachineReports;
using client::MachineStops;
using client::Names;
using client::StopSource;
using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

// A machine answers within a turn of its loop; discovery comes before that.
constexpr auto kAnswerTime = 5s;
constexpr auto kPollPeriod = 2ms;
constexpr char kProgram[] = "intaglio-stop";  // the beginning of its name as a source

struct StopOptions {
  bus::BusOptions bus;
  std::string cell;
  std::string reason = "pressed on the command line";
  bool reset = false;
};

template <typename Condition>
bool Until(Condition condition, std::chrono::milliseconds bound) {
  for (const auto end = Clock::now() + bound; Clock::now() < end;) {
    if (condition()) return true;
    std::this_thread::sleep_for(kPollPeriod);
  }
  return condition();
}

int ComplainWith(const std::string& text, int exit_code) {
  return Complain(Error{ErrorCode::kTimedOut, text, {}}, exit_code);
}

int ComplainOfNoMachine() {
  return ComplainWith(
      "no machine found: press the machine's own button; then check --domain, "
      "--interface, --tag and --security",
      client::kExitWrongInput);
}

using Machines = std::map<std::string, MachineStops>;

/// Those of the machines, or the named one, that do not hold the press.
std::vector<std::string> Unconfirmed(const Machines& machines, const std::string& named,
                                     const std::string& source, std::uint64_t number,
                                     std::set<std::string>& confirmed) {
  std::vector<std::string> missing;
  if (!named.empty() && !machines.contains(named)) missing.push_back(named);
  for (const auto& [cell, stops] : machines) {
    if (!named.empty() && cell != named) continue;
    if (Names(stops.held, source, number) && confirmed.insert(cell).second)
      std::cout << cell << ": stopped" << std::endl;
    if (!confirmed.contains(cell)) missing.push_back(cell);
  }
  return missing;
}

/// The machines that are there, where none has this name.
std::string OthersThan(const Machines& machines, const std::string& cell) {
  if (machines.contains(cell) || machines.empty()) return "";
  return fmt::format("; no machine of this name is there, but {}",
                     fmt::join(std::views::keys(machines), ", "));
}

// The press is on the bus before anything is waited for.
int Press(bus::Bus& bus, const StopOptions& options) {
  const bool every = options.cell.empty();
  StopSource source(bus, kProgram, every ? kEveryMachine : options.cell);
  const auto number = source.Press(options.reason);
  if (!number) return Complain(number.error(), client::kExitMachine);
  MachineReports reports(bus, "");
  std::set<std::string> confirmed;
  std::vector<std::string> missing;
  const auto all_confirmed = [&] {
    missing =
        Unconfirmed(reports.Poll(), options.cell, source.name(), *number, confirmed);
    return missing.empty();
  };
  // It lives that long: the press reaches machines, and their job service, that are
  // discovered late.
  Until([&] { return all_confirmed() && false; }, bus.discovery_time());
  if (every && reports.Poll().empty()) return ComplainOfNoMachine();
  Until(all_confirmed, kAnswerTime);
  for (const std::string& cell : missing) {
    ComplainWith(
        fmt::format("{} has not confirmed the stop within {} s: press the machine's "
                    "own button{}",
                    cell, kAnswerTime.count(), OthersThan(reports.Poll(), cell)),
        client::kExitMachine);
  }
  return missing.empty() ? client::kExitGood : client::kExitMachine;
}

/// The machine to reset: the named one, or the only one that is found.
Result<std::string> MachineToReset(MachineReports& reports, const StopOptions& options,
                                   std::chrono::milliseconds discovery_time) {
  if (!options.cell.empty()) return options.cell;
  Until([&] { return !reports.Poll().empty() && reports.KnowsAllMachines(); },
        discovery_time);
  const auto& machines = reports.Poll();
  if (machines.size() == 1) return machines.begin()->first;
  std::vector<std::string> cells;
  cells.reserve(machines.size());
  for (const auto& [cell, stops] : machines) cells.push_back(cell);
  if (cells.empty()) {
    return Fail(ErrorCode::kInvalidValue,
                "no machine found: check --domain, --interface, --tag and --security");
  }
  return Fail(ErrorCode::kInvalidValue,
              fmt::format("several machines found ({}): name the one to reset",
                          fmt::join(cells, ", ")));
}

int ReportReset(const std::string& cell, const MachineStops& stops) {
  if (const auto held = client::WhyStillHeld(cell, stops); !held.empty())
    return ComplainWith(held, client::kExitMachine);
  std::cout << cell << ": reset; a job continues when it is armed or resumed\n";
  return client::kExitGood;
}

// Names the presses that the machine's synchronizer reports, and no other.
int Reset(bus::Bus& bus, const StopOptions& options) {
  MachineReports reports(bus, options.cell);
  const auto cell = MachineToReset(reports, options, bus.discovery_time());
  if (!cell) return Complain(cell.error());
  if (!Until([&] { return reports.Of(*cell).reported; }, kAnswerTime)) {
    return ComplainWith(
        fmt::format(
            "{} has not reported its stops within {} s: check that its synchronizer runs",
            *cell, kAnswerTime.count()),
        client::kExitMachine);
  }
  client::StopReset reset(bus, kProgram, *cell, reports.Of(*cell).held,
                          "reset on the command line");
  Status sent;
  const auto is_over = [&] {
    sent = reset.Turn(reports.Of(*cell), std::chrono::steady_clock::now());
    return !sent || reset.is_over();
  };
  const bool is_confirmed = Until(is_over, kAnswerTime);
  if (!sent) return Complain(sent.error(), client::kExitMachine);
  // As a press does. A job service that missed it would report the press to the machine.
  if (is_confirmed) Until([] { return false; }, bus.discovery_time());
  const auto is_released = [&] { return reset.IsReleased(reports.Of(*cell)); };
  if (!is_confirmed || !Until(is_released, kAnswerTime)) {
    return ComplainWith(
        fmt::format("{} has not confirmed the reset within {} s: check that its "
                    "synchronizer, its motion bridge and the job service run",
                    *cell, kAnswerTime.count()),
        client::kExitMachine);
  }
  return ReportReset(*cell, reports.Of(*cell));
}

int Stop(const StopOptions& options) {
  bus::Bus bus(options.bus);
  try {
    return options.reset ? Reset(bus, options) : Press(bus, options);
  } catch (const bus::NotAllowedError& error) {
    return Complain(
        {ErrorCode::kRefused,
         host::RoleRefusal(bus.role(), "stop machines, so press the machine's own button",
                           "operator or a submitter", error.what()),
         ""},
        client::kExitMachine);
  }
}

}  // namespace

void AddStopCommand(command_line::Command app) {
  command_line::Command command = app.AddCommand(
      "stop", "emergency stop: no more pulses, the stage comes to rest, latched");
  auto options = std::make_shared<StopOptions>();
  AddBusFlags(command, options->bus);
  command.AddOption("machine", options->cell,
                    "name of the machine; default every machine");
  command.AddFlag("--reset", options->reset,
                  "release the stop, and the one that the machine keeps latched; nothing "
                  "starts before an arm or a resume");
  command.AddOption("--reason", options->reason, "reason for the log").ShowDefault();
  command.SetFooter(
      "It depends on the network and on programs: at a machine, use its button.\n"
      "Ends with 0 when every machine has confirmed it, with 4 when one has not.\n"
      "A reset releases the presses that the machine reports, and no other; it ends\n"
      "with 4 when another press, the key or the door holds the machine afterwards.\n"
      "Example: intaglio stop           every machine\n"
      "  intaglio stop els-03 --reset   then: intaglio resume JOB");
  command.SetAction([options] { return Stop(*options); });
}

}  // namespace intaglio::cli
