#include <CLI/CLI.hpp>
#include <exception>
#include <functional>
#include <iostream>

#include "services/cli/batch_command.h"
#include "services/cli/history_command.h"
#include "services/cli/jobs_command.h"
#include "services/cli/materials_command.h"
#include "services/cli/measure_command.h"
#include "services/cli/misspelt.h"
#include "services/cli/offline_command.h"
#include "services/cli/plan_command.h"
#include "services/cli/record_command.h"
#include "services/cli/recording_command.h"
#include "services/cli/replay_command.h"
#include "services/cli/run_command.h"
#include "services/cli/security_command.h"
#include "services/cli/stop_command.h"
#include "services/cli/up_command.h"

namespace {

constexpr const char* kWelcome =
    "Intaglio engraves 3D objects inside glass: a mesh goes in, a proved engraved block "
    "comes "
    "out.";

constexpr const char* kNext = R"(Where to begin:
  intaglio run --mesh FILE --height 40 --lockstep   engrave in the virtual engraver
  intaglio materials list                           the glasses that are known
  intaglio up                                       open a shop; then submit, list, watch
  intaglio COMMAND --help                           all about one command)";

}  // namespace

int main(int argc, char** argv) {
  CLI::App app(kWelcome, "intaglio");
  app.footer(kNext);
  app.set_version_flag("--version", INTAGLIO_VERSION);
  app.require_subcommand(0, 1);
  std::function<int()> selected;
  intaglio::cli::AddRunCommand(app, selected);
  intaglio::cli::AddUpCommand(app, selected);
  intaglio::cli::AddJobsCommands(app, selected);
  intaglio::cli::AddBatchCommand(app, selected);
  intaglio::cli::AddStopCommand(app, selected);
  intaglio::cli::AddHistoryCommand(app, selected);
  intaglio::cli::AddOfflineCommands(app, selected);
  intaglio::cli::AddMeasureCommand(app, selected);
  intaglio::cli::AddPathCommands(app, selected);
  intaglio::cli::AddMaterialsCommand(app, selected);
  intaglio::cli::AddRecordCommand(app, selected);
  intaglio::cli::AddRecordingCommand(app, selected);
  intaglio::cli::AddReplayCommand(app, selected);
  intaglio::cli::AddSecurityCommand(app, selected);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ExtrasError&) {
    std::cerr << intaglio::cli::TextOfUnknownWords(app) << "\n";
    return intaglio::cli::kExitWrongInput;
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : intaglio::cli::kExitWrongInput;
  }
  if (!selected) {
    std::cout << app.help();
    return 0;
  }
  try {
    return selected();
  } catch (const std::exception& error) {
    std::cerr << "intaglio: " << error.what() << "\n";
    return intaglio::cli::kExitInternal;
  }
}
