#include "services/cli/teach/teach_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <iostream>

#include "services/cli/flags/bus_flags.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/exit_codes.h"
#include "services/platform/host/peers/role_refusal.h"
#include "services/platform/link/real_time.h"

namespace intaglio::cli {

void AddTeachFlags(command_line::Command command, TeachOptions& options) {
  AddBusFlags(command, options.bus);
  command.AddOption("--cell", options.cell,
                    "name of the machine; default the only one that is found");
}

int WithMachine(const TeachOptions& options,
                const std::function<int(client::TeachClient&)>& action) {
  CatchInterrupts();
  // What is held by hand is let go when its repetitions are late.
  (void)link::RaisePriority();
  bus::Bus bus(options.bus);
  const auto cell = client::TeachClient::FindMachine(bus, options.cell);
  if (!cell) return Complain(cell.error());
  try {
    client::TeachClient client(bus, *cell);
    if (auto connected = client.Connect(); !connected)
      return Complain(connected.error(), client::kExitWrongInput);
    return action(client);
  } catch (const bus::NotAllowedError& error) {
    return Complain({ErrorCode::kRefused,
                     host::RoleRefusal(bus.role(), "move or light a machine", "operator",
                                       error.what()),
                     ""},
                    client::kExitWrongInput);
  }
}

bool ReportWait::MayGiveAgain() {
  if (!client_.view().reports_missing || Interrupts() > 0) return false;
  if (!patience_) {
    patience_.emplace(kTime);
    std::cerr << client_.view().cell << ": " << client_.view().message
              << "; it is tried again for " << kTime.count() << " s\n";
  }
  return !patience_->IsUp();
}

bool ReportWait::GivesAgain(const client::TeachOrder& order, std::uint64_t& number) {
  if (!MayGiveAgain()) return false;
  number = client_.Hold(order);
  return true;
}

int ExecuteOrder(client::TeachClient& client, const client::TeachOrder& order,
                 std::chrono::milliseconds timeout) {
  ReportWait wait(client);
  auto done = client.Execute(order, timeout, [] { return Interrupts() > 0; });
  while (!done && wait.MayGiveAgain())
    done = client.Execute(order, timeout, [] { return Interrupts() > 0; });
  if (!done) return Complain(done.error(), client::kExitMachine);
  if (!done->empty()) std::cout << *done << "\n";
  return client::kExitGood;
}

// The state that has the answer has the place at rest.
int ExecuteMove(client::TeachClient& client, const client::TeachOrder& order,
                std::chrono::milliseconds timeout) {
  const int exit_code = ExecuteOrder(client, order, timeout);
  if (exit_code == client::kExitGood) std::cout << PlaceText(client.view()) << "\n";
  return exit_code;
}

bool AllowsHome(std::istream& in, std::ostream& out, const std::string& machine) {
  out << machine << " drives its axes to where they count from: is the way free? [y/N] "
      << std::flush;
  std::string answer;
  return std::getline(in, answer) && (answer == "y" || answer == "yes");
}

std::string PlaceText(const client::MachineView& view) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    text += fmt::format("{}{} {:.4f} {}", i == 0 ? "" : ", ", view.axes[at],
                        view.position[i], view.rotary[at] ? "rad" : "mm");
  }
  return text;
}

Result<int> AxisByName(const client::MachineView& view, const std::string& name) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (view.axes[i] == name || (name.size() == 1 && name[0] == "XYZ"[i] &&
                                 view.axes[i] == std::string(1, "xyz"[i])))
      return static_cast<int>(i);
  }
  return Fail(ErrorCode::kNotFound,
              fmt::format("\"{}\" is no axis of {}: give one of {}", name, view.cell,
                          fmt::join(view.axes, ", ")),
              name);
}

std::string TextOf(const client::MachineView& view) {
  std::string text = view.cell + "\n";
  for (int i = 0; i < 3; ++i) {
    const auto at = static_cast<std::size_t>(i);
    text += fmt::format("  {:<6}{:>11.4f} {:<4} limits {:g} to {:g}\n", view.axes[at],
                        view.position[i], view.rotary[at] ? "rad" : "mm",
                        view.limit_min[i], view.limit_max[i]);
  }
  if (!view.homed) text += "  not homed: `intaglio teach home`\n";
  const auto closed = [](bool yes, const char* good, const char* bad) {
    return yes ? good : bad;
  };
  if (!view.interlocks_known) {
    text += "  key, door and stop: not known\n";
  } else {
    text += fmt::format(
        "  key {}, door {}, stop {}, lamp {}, shutters {}\n",
        closed(view.key_on, "on", "OFF"),
        closed(view.door_closed, view.door_locked ? "locked" : "closed", "OPEN"),
        closed(view.stop_released, "released", "PRESSED"),
        view.lamp_on ? (view.lamp_warm ? "warm" : "warming up") : "off",
        view.shutters_open == 0 ? "closed" : "OPEN");
  }
  text +=
      fmt::format("  by hand: {}\n", !view.held_by.empty()  ? "moved by " + view.held_by
                                     : view.refusal.empty() ? "allowed"
                                                            : view.refusal);
  text += view.profile.empty() ? "  taught: the work zero, which the controller keeps\n"
                               : fmt::format("  taught: version {} of {}\n",
                                             view.taught_number, view.profile);
  return text;
}

}  // namespace intaglio::cli
