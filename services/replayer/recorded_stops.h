#pragma once

// The emergency stops of one machine in a recording.
//
// Recordings from before resets named presses hold no list `released`: there a reset
// released every press with a lower number. They are read as if it had named them, each
// press as one of a source of its own.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "services/platform/recording/cdr_value.h"

namespace intaglio::replayer {

struct RecordedPress {
  std::string source;
  std::uint64_t number = 0;
  bool operator==(const RecordedPress&) const = default;
};

/// An EmergencyStop.
struct StopMessage {
  bool pressed = false;
  std::string source;
  std::uint64_t number = 0;
  std::vector<RecordedPress> released;
};

class RecordedStops {
 public:
  explicit RecordedStops(std::string cell) : cell_(std::move(cell)) {}

  struct Sample {
    bool ours = false;  ///< the machine's, or of every machine
    StopMessage stop;
  };
  /// In the order of the recording. Nothing for a value that is no EmergencyStop.
  std::optional<Sample> Read(const recording::Value& value);

 private:
  std::string cell_;
  std::vector<RecordedPress> unnamed_presses_;  // of an old recording
};

}  // namespace intaglio::replayer
