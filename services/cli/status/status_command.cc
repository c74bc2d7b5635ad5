#include "services/cli/status/status_command.h"

#include <unistd.h>

#include <chrono>
#include <iostream>
#include <memory>

#include "services/cli/flags/bus_flags.h"
#include "services/cli/status/status_text.h"
#include "services/cli/status/watched_shop.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/exit_codes.h"
#include "services/client/shop/bus_turn.h"
#include "services/client/shop/shop_status.h"
#include "services/job/files/json_text.h"

namespace intaglio::cli {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;

constexpr auto kRefreshPeriod = 1s;

struct StatusOptions {
  bus::BusOptions bus;
  bool json = false;
  bool watch = false;
};

int Print(const ShopStatus& status, const StatusOptions& options) {
  if (options.json) {
    const auto json =
        JsonTextOf(status, options.watch ? JsonLayout::kOneLine : JsonLayout::kLines);
    if (!json) return Complain(json.error(), client::kExitInternal);
    std::cout << *json << (options.watch ? "\n" : "");
  } else {
    // Home, then what is behind the text is erased.
    const bool screen = options.watch && isatty(STDOUT_FILENO) != 0;
    std::cout << (screen ? "\x1b[H\x1b[2J" : "") << TextOf(status)
              << (options.watch && !screen ? "\n" : "");
  }
  std::cout << std::flush;
  return status.needs_person() ? client::kExitMachine : client::kExitGood;
}

int ShowStatus(const StatusOptions& options) {
  client::BusTurn turn;
  CatchInterrupts();
  // The machines themselves are asked where no job service answers for them.
  auto watched = WatchShop(WithoutCells(options.bus));
  const auto meet_cells = [&] {
    watched.reset();
    watched = WatchShop(options.bus);
  };
  if (!watched->shop.IsComplete()) meet_cells();
  if (watched->shop.Take().services.empty()) {
    return Complain({ErrorCode::kTimedOut,
                     "no services found: start them (intaglio up), or check --domain, "
                     "--interface, --tag and --security",
                     ""},
                    client::kExitWrongInput);
  }
  if (options.watch) turn.End();
  for (;;) {
    const auto now = std::chrono::system_clock::now();
    const int exit_code = Print(client::StatusOf(watched->shop.Take(), now), options);
    if (!options.watch || Interrupts() > 0 || !std::cout) return exit_code;
    for (const auto end = Clock::now() + kRefreshPeriod;
         Interrupts() == 0 && Clock::now() < end;)
      watched->shop.Poll(kShopPollPeriod);
    if (Interrupts() > 0) return exit_code;
    if (!watched->bus.options().meets_cells && !watched->shop.IsServed()) meet_cells();
  }
}

}  // namespace

void AddStatusCommand(command_line::Command app) {
  auto options = std::make_shared<StatusOptions>();
  command_line::Command status = app.AddCommand(
      "status", "show machines, jobs, alarms and disks of a shop in one screen");
  AddBusFlags(status, options->bus);
  status.AddFlag("--watch", options->watch, "refresh it every second until Ctrl-C");
  status.AddFlag("--json", options->json,
                 "for programs; with --watch one line every second");
  status.SetFooter(
      "Ends with 0 when all is well, with 4 when something needs a person, with 2 when "
      "there is no shop.\n"
      "Example: intaglio status --watch");
  status.SetAction([options] { return ShowStatus(*options); });
}

}  // namespace intaglio::cli
