#include "services/platform/host/peers/machine_reporter.h"

#include "services/platform/bus/samples.h"

namespace intaglio::host {

void MachineReporter::Turn(std::chrono::nanoseconds now) {
  if (now < (facts_ == published_ ? next_unchanged_ : next_)) return;
  const WireFacts facts(facts_);
  intaglio_MachineReport sample{};
  sample.instance = bus::Borrow(instance_);
  sample.facts = facts.sample();
  if (!writer_.Write(sample)) return;  // again at the next turn
  published_ = facts_;
  next_ = now + kShortestPeriod;
  next_unchanged_ = now + kUnchangedPeriod;
}

}  // namespace intaglio::host
