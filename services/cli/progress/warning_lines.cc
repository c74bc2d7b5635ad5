#include "services/cli/progress/warning_lines.h"

#include <algorithm>
#include <iostream>

#include "services/client/warning_text.h"

namespace intaglio::cli {

void WarningLines::Show(const Warnings& warnings) {
  if (warnings == shown_) return;
  bar_.Finish();
  for (const Warning& warning : warnings) {
    if (std::find(shown_.begin(), shown_.end(), warning) != shown_.end()) continue;
    std::cerr << client::WarningLine(warning) << "\n";
  }
  shown_ = warnings;
}

}  // namespace intaglio::cli
