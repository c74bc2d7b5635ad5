#pragma once

#include <string>
#include <vector>

#include "services/cli/flags/accept_flag.h"
#include "services/cli/flags/console_flag.h"
#include "services/cli/flags/customer_picture_flags.h"
#include "services/cli/flags/truth_flags.h"
#include "services/cli/job/job_options.h"
#include "services/platform/bus/bus.h"
#include "services/platform/command_line/program.h"

namespace intaglio::cli {

struct RunOptions {
  JobFlags job;
  std::string out;
  std::string materials_db;
  bool lockstep = false;
  bool events = false;
  AcceptFlag accept;
  double speed = 1;
  TruthFlags truth;
  std::vector<std::string> faults;
  std::vector<std::string> without;
  bool record = true;
  CustomerPictureFlags picture;
  std::string bulk;
  ConsoleFlags console;
  bus::BusOptions bus;
};

/// What `intaglio run` takes.
void AddRunFlags(command_line::Command run, RunOptions& options);

}  // namespace intaglio::cli
