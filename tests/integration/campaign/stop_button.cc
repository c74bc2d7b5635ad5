#include "tests/integration/campaign/stop_button.h"

#include <stdexcept>

#include "services/bus/samples.h"
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
      // Above every one before, as `intaglio stop` numbers them.
      number_(static_cast<std::uint64_t>(
          std::chrono::duration_cast<std::chrono::microseconds>(
              std::chrono::system_clock::now().time_since_epoch())
              .count())) {}

bool StopButton::AwaitHeard(std::chrono::milliseconds bound) const {
  return testing::Eventually([this] { return stops_.matched_count() >= kHearers; },
                             bound);
}

void StopButton::Write(bool pressed) {
  const std::string source = "campaign", reason = "a hand in the machine";
  intaglio_EmergencyStop sample{};
  sample.cell = bus::Borrow(cell_);
  sample.pressed = pressed;
  sample.source = bus::Borrow(source);
  sample.reason = bus::Borrow(reason);
  sample.number = ++number_;
  if (auto written = stops_.Write(sample); !written) {
    throw std::runtime_error(written.error().message);
  }
}

}  // namespace intaglio::campaign
