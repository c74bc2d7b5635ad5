#include "services/job_service/cells/interlock_watch.h"

namespace intaglio::job_service {

void InterlockWatch::OpenCell(const std::string& cell) {
  if (readers_.contains(cell)) return;
  readers_.emplace(cell, bus::Reader<intaglio_Interlock>(bus_, bus::kInterlock, cell));
}

std::vector<std::pair<std::string, DoorState>> InterlockWatch::Take() {
  std::vector<std::pair<std::string, DoorState>> taken;
  for (auto& [cell, reader] : readers_) {
    reader.TakeAll([&taken, &cell = cell](const intaglio_Interlock& sample,
                                          const bus::SampleOrigin& origin) {
      DoorState door = DoorState::kUnknown;
      if (origin.alive && sample.laser_link_up) {
        const bool closed = sample.key_on && sample.door_closed;
        door = closed ? DoorState::kClosed : DoorState::kOpen;
      }
      taken.emplace_back(cell, door);
    });
  }
  return taken;
}

}  // namespace intaglio::job_service
