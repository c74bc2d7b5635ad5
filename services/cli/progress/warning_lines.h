#pragma once

#include "engrave/core/warning.h"
#include "services/cli/progress/progress_bar.h"

namespace intaglio::cli {

/// Prints every warning of a job that is followed, once, below the progress bar.
class WarningLines {
 public:
  explicit WarningLines(ProgressBar& bar) : bar_(bar) {}

  /// Those that are new since the last call, to the standard error stream.
  void Show(const Warnings& warnings);

 private:
  ProgressBar& bar_;
  Warnings shown_;
};

}  // namespace intaglio::cli
