#pragma once

// A job's stages run at the same time, each feeding the next; people follow the first
// that is not done. A stage that ended keeps its line.

#include <set>
#include <string>

#include "services/cli/progress_bar.h"
#include "services/client/job_client.h"

namespace intaglio::cli {

class StageBars {
 public:
  explicit StageBars(ProgressBar& bar) : bar_(bar) {}

  /// `note` goes behind the stage at work.
  void Show(const client::JobView& job, const std::string& note);

 private:
  ProgressBar& bar_;
  std::set<intaglio_Stage> ended_;
};

}  // namespace intaglio::cli
