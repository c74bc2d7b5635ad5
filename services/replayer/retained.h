#pragma once

// What late readers would have been given at a place of a recording: the newest samples
// of each instance of the retained (transient-local) topics before it, as many as their
// writers keep.

#include <cstdint>
#include <string>
#include <vector>

#include "services/platform/recording/message_cursor.h"
#include "services/platform/recording/retained_state.h"
#include "services/replayer/selection.h"

namespace intaglio::replayer {

class Retained {
 public:
  Retained(const recording::McapReader& reader, const Selection& selection)
      : reader_(reader), selection_(selection) {}
  /// Selects from the messages before this log time, in their order; `stream` is the
  /// channel.
  std::vector<recording::RetainedSample> Before(std::uint64_t log_time_ns);
  /// Instances that could not be distinguished, a sentence each.
  const std::vector<std::string>& complaints() const { return complaints_; }

 private:
  const recording::McapReader& reader_;
  const Selection& selection_;
  std::vector<std::string> complaints_;
};

}  // namespace intaglio::replayer
