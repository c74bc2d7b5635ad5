#include "services/cli/job/run_flags.h"

#include "services/cli/flags/bulk_flag.h"
#include "services/cli/flags/bus_flags.h"
#include "services/cli/flags/console_flag.h"
#include "services/cli/flags/event_flag.h"

namespace intaglio::cli {

void AddRunFlags(command_line::Command run, RunOptions& options) {
  AddJobFlags(run, options.job);
  AddEventsFlag(run, options.events);
  AddAcceptAndAnswers(run, options.accept);
  run.AddOption("--out", options.out,
                "folder of the proof, default intaglio-out/NAME-TIME");
  const auto lockstep = run.AddFlag("--lockstep", options.lockstep,
                                    "the machine runs as fast as the points arrive");
  run.AddOption("--speed", options.speed,
                "speed of the machine as a multiple of real time")
      .Within(0.01, 1000.0)
      .Exclude(lockstep);
  AddCustomerPictureFlags(run, options.picture);
  AddTruthFlags(run, options.truth);
  run.AddOption(
      "--fault", options.faults,
      "inject a fault into the machine: \"AT_TICK COMMAND\" (docs/protocols.md)");
  run.AddFlag("--record,!--no-record", options.record,
              "record the messages in session.mcap; on by default");
  AddBulkFlag(run, options.bulk);
  run.AddOption("--without", options.without,
                "services that run elsewhere, e.g. discretizer");
  run.AddOption("--materials", options.materials_db, "material base, default the user's");
  AddConsoleFlags(run, options.console);
  AddPrivateBusFlags(run, options.bus);
}

}  // namespace intaglio::cli
