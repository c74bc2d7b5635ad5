#include "services/cli/intaglio_program.h"

#include "services/cli/backup/backup_command.h"
#include "services/cli/batch/batch_command.h"
#include "services/cli/console/console_command.h"
#include "services/cli/contour/contour_command.h"
#include "services/cli/course/course_command.h"
#include "services/cli/drive/drive_command.h"
#include "services/cli/fonts_command.h"
#include "services/cli/galvo/galvo_command.h"
#include "services/cli/history_command.h"
#include "services/cli/jobs_command.h"
#include "services/cli/machine/machine_command.h"
#include "services/cli/marks/marks_command.h"
#include "services/cli/materials/materials_command.h"
#include "services/cli/materials/test_grid_command.h"
#include "services/cli/offline/measure_command.h"
#include "services/cli/offline/offline_command.h"
#include "services/cli/offline/plan_command.h"
#include "services/cli/offline/post_command.h"
#include "services/cli/offline/tiles_command.h"
#include "services/cli/preview/preview_command.h"
#include "services/cli/proofs/proofs_command.h"
#include "services/cli/recordings/record_command.h"
#include "services/cli/recordings/recording_command.h"
#include "services/cli/recordings/replay_command.h"
#include "services/cli/run_command.h"
#include "services/cli/security_command.h"
#include "services/cli/sheet/sheet_command.h"
#include "services/cli/status/logs_command.h"
#include "services/cli/status/status_command.h"
#include "services/cli/stop_command.h"
#include "services/cli/teach/mount_command.h"
#include "services/cli/teach/teach_command.h"
#include "services/cli/terminal/command_outcome.h"
#include "services/cli/up_command.h"
#include "services/cli/workers_command.h"
#include "services/platform/host/version/software_version.h"

namespace intaglio::cli {
namespace {

constexpr const char* kWelcome =
    "Intaglio engraves 3D objects inside glass and proves from the glass what was made.";

constexpr const char* kNext = R"(Where to begin:
  intaglio preview FILE --height 40                 picture, time, size and warnings
  intaglio run FILE --height 40 --lockstep          engrave in the virtual engraver
  intaglio materials list                           list the known glasses
  intaglio up                                       open a shop; then submit, list, watch
  intaglio contour FILE --page page.html            a mill's or cutter's work, played
  intaglio help COMMAND                             all about one command)";

}  // namespace

std::unique_ptr<command_line::Program> IntaglioProgram() {
  auto program = std::make_unique<command_line::Program>("intaglio", kWelcome);
  program->SetVersion(host::SoftwareVersion());
  const command_line::Command root = program->root();
  root.SetFooter(kNext);
  AddRunCommand(root);
  AddUpCommand(root);
  AddJobsCommands(root);
  AddMountCommand(root);
  AddBatchCommand(root);
  AddStopCommand(root);
  AddStatusCommand(root);
  AddWorkersCommand(root);
  AddTeachCommand(root, &SubmitJobFile);
  AddHistoryCommand(root);
  AddLogsCommand(root);
  AddBackupCommands(root);
  AddProofsCommand(root);
  AddPreviewCommand(root);
  AddOfflineCommands(root);
  AddMeasureCommand(root);
  AddPathCommands(root);
  AddTilesCommand(root);
  AddPostCommand(root);
  AddContourCommand(root);
  AddSheetCommand(root);
  AddCourseCommand(root);
  AddMachineCommand(root);
  AddDriveCommand(root);
  AddGalvoCommand(root);
  AddMarksCommand(root);
  AddMaterialsCommand(root);
  AddTestGridCommand(root);
  AddFontsCommand(root);
  AddRecordCommand(root);
  AddRecordingCommand(root);
  AddReplayCommand(root);
  AddSecurityCommand(root);
  AddConsoleCommand(root);
  AnswerInJson(*program);
  program->AddHelpCommand();
  return program;
}

}  // namespace intaglio::cli
