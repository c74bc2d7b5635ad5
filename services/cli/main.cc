#include <exception>
#include <iostream>

#include "services/cli/batch/batch_command.h"
#include "services/cli/complain.h"
#include "services/cli/history_command.h"
#include "services/cli/jobs_command.h"
#include "services/cli/materials/materials_command.h"
#include "services/cli/offline/measure_command.h"
#include "services/cli/offline/offline_command.h"
#include "services/cli/offline/plan_command.h"
#include "services/cli/recordings/record_command.h"
#include "services/cli/recordings/recording_command.h"
#include "services/cli/recordings/replay_command.h"
#include "services/cli/run_command.h"
#include "services/cli/security_command.h"
#include "services/cli/stop_command.h"
#include "services/cli/up_command.h"
#include "services/client/exit_codes.h"

namespace {

constexpr const char* kWelcome =
    "Intaglio engraves 3D objects inside glass and proves from the glass what was made.";

constexpr const char* kNext = R"(Where to begin:
  intaglio run --mesh FILE --height 40 --lockstep   engrave in the virtual engraver
  intaglio materials list                           list the known glasses
  intaglio up                                       open a shop; then submit, list, watch
  intaglio COMMAND --help                           all about one command)";

}  // namespace

int main(int argc, char** argv) {
  using namespace intaglio::cli;
  intaglio::command_line::Program program("intaglio", kWelcome);
  program.SetVersion(INTAGLIO_VERSION);
  const intaglio::command_line::Command root = program.root();
  root.SetFooter(kNext);
  AddRunCommand(root);
  AddUpCommand(root);
  AddJobsCommands(root);
  AddBatchCommand(root);
  AddStopCommand(root);
  AddHistoryCommand(root);
  AddOfflineCommands(root);
  AddMeasureCommand(root);
  AddPathCommands(root);
  AddMaterialsCommand(root);
  AddRecordCommand(root);
  AddRecordingCommand(root);
  AddReplayCommand(root);
  AddSecurityCommand(root);
  if (const auto exit_code = program.Parse(argc, argv)) return *exit_code;
  try {
    return program.Run();
  } catch (const std::exception& error) {
    std::cerr << "intaglio: " << error.what() << "\n";
    return intaglio::client::kExitInternal;
  }
}
