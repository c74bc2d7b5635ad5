#include "services/cli/workers_command.h"

#include <fmt/format.h>

#include <iostream>
#include <memory>
#include <string>

#include "services/cli/flags/bus_flags.h"
#include "services/cli/json/print_json.h"
#include "services/cli/status/watched_shop.h"
#include "services/cli/submit_jobs.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/cli/terminal/text_table.h"
#include "services/client/exit_codes.h"
#include "services/client/known_jobs.h"
#include "services/client/shop/shop_status.h"

namespace intaglio::cli {
namespace {

struct WorkersOptions {
  bus::BusOptions bus;
  std::string name;
  bool json = false;
};

Error NoJobService() { return {ErrorCode::kTimedOut, client::kNoJobService, ""}; }

WorkerList WorkersOf(const ShopStatus& status) {
  WorkerList list;
  for (const char* role : {"discretizer", "sorter"}) {
    for (const ServiceStatus& service : status.services())
      if (service.role() == role) *list.add_workers() = service;
  }
  return list;
}

std::string WorkersText(const WorkerList& list) {
  TextTable table({{"worker"}, {"role"}, {"host"}, {"state"}});
  for (const ServiceStatus& worker : list.workers()) {
    const bool is_left_out = !worker.left_out().empty();
    table.AddRow({worker.instance(), worker.role(), worker.host(),
                  is_left_out ? "left out" : worker.state()});
    if (is_left_out) table.AddBelow(worker.left_out());
  }
  return table.Text();
}

int ListWorkers(const WorkersOptions& options) {
  CatchInterrupts();
  const auto watched = WatchShop(WithoutCells(options.bus));
  if (!watched->shop.IsServed()) return Complain(NoJobService(), client::kExitWrongInput);
  const WorkerList list =
      WorkersOf(client::StatusOf(watched->shop.Take(), std::chrono::system_clock::now()));
  if (options.json) return PrintJson(list);
  std::cout << WorkersText(list) << std::flush;
  return client::kExitGood;
}

int AdmitWorker(const WorkersOptions& options) {
  bus::Bus bus(WithoutCells(options.bus));
  client::JobClient client(bus);
  if (!client::PollUntilServed(client, bus.discovery_time()))
    return Complain(NoJobService(), client::kExitWrongInput);
  if (const auto admitted = client.Admit(options.name); !admitted)
    return ComplainOf(admitted.error());
  std::cout << options.name << " is given tasks again\n";
  return client::kExitGood;
}

}  // namespace

void AddWorkersCommand(command_line::Command app) {
  auto options = std::make_shared<WorkersOptions>();
  command_line::Command workers = app.AddCommand(
      "workers", "list the discretizers and sorters, and why one is left out");
  AddBusFlags(workers, options->bus);
  workers.AddFlag("--json", options->json, "for programs");
  workers.SetFooter(
      "Example: intaglio workers; then intaglio workers admit NAME\n"
      "One whose results were wrong or slow is left out: it is given nothing more.");
  workers.SetAction([options] { return ListWorkers(*options); });

  auto admitted = std::make_shared<WorkersOptions>();
  command_line::Command admit = workers.AddCommand(
      "admit", "give a worker tasks again whose computer was checked and mended");
  admit.AddOption("NAME", admitted->name, "the worker, as intaglio workers lists it")
      .Require();
  AddBusFlags(admit, admitted->bus);
  admit.SetFooter(
      "Example: intaglio workers admit intaglio-discretizer-shop-2-4711\n"
      "It is recorded who did it: intaglio history --workers. What it made while it was "
      "suspected, and is not engraved yet, is made anew.");
  admit.SetAction([admitted] { return AdmitWorker(*admitted); });
}

}  // namespace intaglio::cli
