#pragma once

// A job's stages run at the same time, each feeding the next; people follow the first
// that is not done. A stage that ended keeps its line.

#include <set>
#include <string>

#include "services/cli/progress/progress_bar.h"
#include "services/client/job_client.h"

namespace intaglio::cli {

/// "machining time 2 min 41 s" of a job whose engraving has not begun; empty: it is not
/// known, or the bar has it.
std::string EstimateNote(const client::JobView& job);

class StageBars {
 public:
  /// `speed`: of the machine, as a multiple of real time; 0: as fast as it can.
  explicit StageBars(ProgressBar& bar, double speed = 1) : bar_(bar), speed_(speed) {}

  /// `note` goes behind the stage at work.
  void Show(const client::JobView& job, const std::string& note);

 private:
  ProgressBar& bar_;
  double speed_;
  std::set<intaglio_Stage> ended_;
};

}  // namespace intaglio::cli
