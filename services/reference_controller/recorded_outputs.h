#pragma once

// Simulated outputs that are recorded, each change with its time.

#include <array>
#include <functional>

#include "services/platform/link/steady_clock.h"
#include "services/reference_controller/pins.h"

namespace intaglio::reference_controller {

struct Edge {
  Output output = Output::kQSwitch;
  bool on = false;
  std::chrono::nanoseconds at{0};
};

/// All are off at first.
class RecordedOutputs {
 public:
  /// `recorded` is called with each change of an output but Output::kAlive.
  RecordedOutputs(link::SteadyClock clock, std::function<void(const Edge&)> recorded);

  /// True if it has changed and was recorded.
  bool Change(Output output, bool on);
  bool is_on(Output output) const { return on_[static_cast<std::size_t>(output)]; }
  /// Changes of Output::kAlive.
  std::uint64_t alive_count() const { return alive_count_; }

 private:
  link::SteadyClock clock_;
  std::function<void(const Edge&)> recorded_;
  std::array<bool, kOutputCount> on_{};
  std::uint64_t alive_count_ = 0;
};

}  // namespace intaglio::reference_controller
