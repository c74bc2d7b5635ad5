#include "services/reference_controller/recorded_outputs.h"

#include <utility>

namespace intaglio::reference_controller {

RecordedOutputs::RecordedOutputs(link::SteadyClock clock,
                                 std::function<void(const Edge&)> recorded)
    : clock_(std::move(clock)), recorded_(std::move(recorded)) {}

bool RecordedOutputs::Change(Output output, bool on) {
  bool& now = on_[static_cast<std::size_t>(output)];
  if (now == on) return false;
  now = on;
  if (output == Output::kAlive) {
    ++alive_count_;
    return false;
  }
  recorded_({output, on, clock_()});
  return true;
}

}  // namespace intaglio::reference_controller
