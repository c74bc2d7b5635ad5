#include "services/cli/proofs/proofs_command.h"

#include <array>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <memory>

#include "services/cli/flags/bus_flags.h"
#include "services/cli/flags/customer_picture_flags.h"
#include "services/cli/proofs/cell_proofs.h"
#include "services/cli/terminal/complain.h"
#include "services/cli/terminal/interrupt.h"
#include "services/client/exit_codes.h"
#include "services/client/locks/folder_lock.h"
#include "services/platform/host/process/init_system.h"

namespace intaglio::cli {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

struct ProofsOptions {
  bus::BusOptions bus;
  std::string cell = "els-03";
  std::string folder;
  CustomerPictureFlags picture;
};

int CompleteFolders(const ProofsOptions& options) {
  CatchInterrupts();
  const fs::path folder = fs::absolute(options.folder);
  const auto lock = client::FolderLock::Take(folder);
  if (!lock) return Complain(lock.error(), client::kExitWrongInput);
  bus::Bus bus(options.bus);
  client::JobClient client(bus);
  std::array proofs = {ProofsOf(folder, options.cell, options.picture)};
  host::NotifyInitReady("proofs of " + options.cell);
  std::cerr << "the folders of ended jobs of " << options.cell
            << " get report and pictures; Ctrl-C ends this\n";
  while (Interrupts() == 0) {
    client.Poll(200ms);
    TurnProofs(proofs, client);
    host::NotifyInitAlive();
  }
  host::NotifyInitStopping();
  FinishProofs(proofs, client);
  return client::kExitGood;
}

}  // namespace

void AddProofsCommand(command_line::Command app) {
  auto options = std::make_shared<ProofsOptions>();
  command_line::Command proofs = app.AddCommand(
      "proofs", "make report and pictures of a machine's jobs as they end");
  AddBusFlags(proofs, options->bus);
  proofs
      .AddOption("--cell", options->cell, "machine; its jobs are in folders of this host")
      .ShowDefault();
  proofs
      .AddOption("--folder", options->folder,
                 "for proof.log; that of the glass records of a virtual engraver")
      .Require();
  AddPictureStyleFlags(proofs, options->picture);
  proofs.SetFooter(
      "`intaglio up` does this itself. In a shop whose services are started otherwise:\n"
      "Example: intaglio proofs --cell els-03 --folder proofs --tag shop");
  proofs.SetAction([options] { return CompleteFolders(*options); });
}

}  // namespace intaglio::cli
