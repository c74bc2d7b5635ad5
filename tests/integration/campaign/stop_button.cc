#include "tests/integration/campaign/stop_button.h"

#include <unistd.h>

#include <stdexcept>
#include <vector>

#include "services/platform/bus/samples.h"
#include "tests/integration/run_program.h"

namespace intaglio::campaign {
namespace {

// Job service, synchronizer and motion bridge.
constexpr int kHearers = 3;

bus::BusOptions OfCell(bus::BusOptions options, const std::string& cell) {
  options.cell = cell;
  return options;
}

}  // namespace

StopButton::StopButton(const bus::BusOptions& options, std::string cell)
    : cell_(std::move(cell)),
      bus_(OfCell(options, cell_)),
      stops_(bus_, bus::kEmergencyStop, cell_),
      source_(
          "campaign-" + std::to_string(getpid()) + "-" +
          std::to_string(std::chrono::system_clock::now().time_since_epoch().count())) {}

bool StopButton::AwaitReceived(std::chrono::milliseconds bound) const {
  return testing::Eventually([this] { return stops_.matched_count() >= kHearers; },
                             bound);
}

void StopButton::Write(bool pressed) {
  const std::string operator_name = "campaign", reason = "a hand in the machine";
  std::vector<intaglio_StopPress> released;
  if (!pressed) released.push_back({bus::Borrow(source_), number_});
  intaglio_EmergencyStop sample{};
  sample.cell = bus::Borrow(cell_);
  sample.source = bus::Borrow(source_);
  sample.number = ++number_;
  sample.pressed = pressed;
  sample.operator_name = bus::Borrow(operator_name);
  sample.reason = bus::Borrow(reason);
  bus::Borrow(sample.released, released);
  if (auto written = stops_.Write(sample); !written) {
    throw std::runtime_error(written.error().message);
  }
}

}  // namespace intaglio::campaign
