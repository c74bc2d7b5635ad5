#include "services/job_service/cells/interlock_watch.h"

#include "services/platform/bus/samples.h"

namespace intaglio::job_service {

void InterlockWatch::OpenCell(const std::string& cell) {
  if (readers_.contains(cell)) return;
  readers_.emplace(cell, bus::Reader<intaglio_Interlock>(bus_, bus::kInterlock, cell));
}

std::vector<InterlockReport> InterlockWatch::Take() {
  std::vector<InterlockReport> taken;
  for (auto& [cell, reader] : readers_) {
    reader.TakeAll([&taken, &cell = cell](const intaglio_Interlock& sample,
                                          const bus::SampleOrigin& origin) {
      InterlockReport& report = taken.emplace_back();
      report.cell = cell;
      if (!origin.alive) return;
      if (sample.laser_link_up) {
        const bool closed = sample.key_on && sample.door_closed;
        report.door = closed ? DoorState::kClosed : DoorState::kOpen;
      }
      for (const intaglio_StopPress& press : bus::View(sample.bus_stops))
        report.stops_held.push_back({std::string(bus::View(press.source)), press.number});
    });
  }
  return taken;
}

}  // namespace intaglio::job_service
