#include "services/cli/terminal/complain.h"

#include <iostream>

#include "services/cli/terminal/command_outcome.h"
#include "services/client/warning_text.h"

namespace intaglio::cli {

int Complain(const Error& error, int exit_code) {
  ReportRefusal(error);
  return exit_code;
}

void PrintTextWarnings(const Warnings& warnings) {
  for (const Warning& warning : warnings) {
    std::cerr << WarningWeightName(warning.weight) << ": " << warning.text << "\n";
  }
}

void PrintWarningLines(const Warnings& warnings) {
  for (const Warning& warning : warnings)
    std::cerr << client::WarningLine(warning) << "\n";
}

}  // namespace intaglio::cli
