#include "services/platform/host/peers/presence.h"

#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"

namespace intaglio::host {

Presence::Presence(bus::Bus& bus, std::string instance) : instance_(std::move(instance)) {
  if (bus.options().security.empty()) return;
  const std::string& role = bus.role();
  const bool of_cell = role.starts_with(bus::kCellPrefix);
  const bool of_job_service = role == bus::kJobServiceRole;
  if (!of_cell && !of_job_service && role != bus::kStageWorkerRole) return;
  writer_ = std::make_unique<bus::Writer<intaglio_Presence>>(bus, bus::kPresence);
  if (role == bus::kStageWorkerRole) return;
  peers_ = std::make_unique<bus::Reader<intaglio_Presence>>(
      bus, bus::kPresence, of_cell ? bus::RolePartition(bus::kJobServiceRole) : "");
}

bool Presence::Turn(OneSidedLoss::Time now) {
  if (!writer_) return false;
  // A taken sample is removed; untaken, one would be kept for every peer that ever
  // existed.
  if (peers_) peers_->Take([](const intaglio_Presence&) {});
  // Before the next sample, so that the last one had its time.
  const bool all_acknowledged =
      writer_->WaitForAcknowledgements(std::chrono::milliseconds(0)).has_value();
  intaglio_Presence sample{};
  sample.instance = bus::Borrow(instance_);
  sample.number = ++number_;
  (void)writer_->Write(sample);
  return loss_.Turn(all_acknowledged, now);
}

}  // namespace intaglio::host
