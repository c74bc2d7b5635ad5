#include "services/client/shop/shop_snapshot.h"

#include <algorithm>
#include <thread>

#include "services/client/shop/stop_reset.h"
#include "services/platform/bus/samples.h"

namespace intaglio::client {
namespace {

using bus::View;

void TakeInterlock(const intaglio_Interlock& sample, CellSnapshot& cell) {
  cell.has_interlock = true;
  cell.laser_line_up = sample.laser_link_up;
  cell.key_on = sample.key_on;
  cell.door_closed = sample.door_closed;
  cell.door_locked = sample.door_locked;
  cell.stop_released = sample.emergency_stop_released;
  cell.lamp_on = sample.lamp_on;
  cell.lamp_warm = sample.lamp_warm;
  cell.safe_state = sample.safe_state;
  cell.shutters_open = sample.shutters_open;
  cell.stop_pressed = sample.bus_stop_pressed;
  cell.stops_held.clear();
  for (const intaglio_StopPress& press : View(sample.bus_stops)) {
    cell.stops_held.push_back(TextOf({std::string(View(press.source)), press.number}));
  }
}

}  // namespace

ShopWatcher::ShopWatcher(bus::Bus& bus)
    : client_(bus),
      interlocks_(bus, bus::kInterlock, ""),
      lamps_(bus, bus::kLampSync, ""),
      motion_(bus, bus::kMotionState, "") {}

void ShopWatcher::Poll(std::chrono::milliseconds time) {
  client_.Poll(time);
  TakeCells();
}

void ShopWatcher::TakeCells() {
  interlocks_.TakeAll(
      [this](const intaglio_Interlock& sample, const bus::SampleOrigin& origin) {
        const std::string cell(View(sample.cell));
        if (origin.alive) {
          TakeInterlock(sample, cells_[cell]);
        } else {
          cells_.erase(cell);
        }
      });
  lamps_.Take([this](const intaglio_LampSync& sample) {
    CellSnapshot& cell = cells_[std::string(View(sample.cell))];
    cell.has_lamp = true;
    cell.warm_ratio = sample.warm_ratio;
    cell.rate_hz = sample.rate_hz;
  });
  motion_.Take([this](const intaglio_MotionState& sample) {
    CellSnapshot& cell = cells_[std::string(View(sample.cell))];
    cell.has_motion = true;
    cell.motion_fault = sample.fault;
    cell.motion_message = View(sample.message);
    cell.x_mm = sample.x_mm;
    cell.y_mm = sample.y_mm;
    cell.z_mm = sample.z_mm;
    cell.at_rest = sample.at_rest;
    cell.has_block_stage = sample.has_block_stage;
    cell.block_x_mm = sample.block_x_mm;
    cell.block_y_mm = sample.block_y_mm;
  });
}

bool ShopWatcher::IsComplete() const {
  const auto services = client_.services();
  bool served = false;
  for (const ServiceView& service : services) {
    const auto cell = cells_.find(service.cell);
    const bool known = cell != cells_.end();
    if (service.role == intaglio_ROLE_JOB_SERVICE) served = true;
    if (service.role == intaglio_ROLE_SYNCHRONIZER &&
        !(known && cell->second.has_interlock))
      return false;
    if (service.role == intaglio_ROLE_MOTION_BRIDGE &&
        !(known && cell->second.has_motion))
      return false;
  }
  const auto has = [&](intaglio_ServiceRole role) {
    return std::any_of(services.begin(), services.end(),
                       [role](const auto& service) { return service.role == role; });
  };
  return served && client_.KnowsAllServices() && client_.KnowsAllJobs() &&
         !client_.disks().empty() && has(intaglio_ROLE_DISCRETIZER) &&
         has(intaglio_ROLE_SORTER) && has(intaglio_ROLE_SYNCHRONIZER) &&
         has(intaglio_ROLE_MOTION_BRIDGE);
}

ShopSnapshot ShopWatcher::Take() const {
  ShopSnapshot shop;
  shop.services = client_.services();
  for (const auto& [uid, job] : client_.jobs()) shop.jobs.push_back(job);
  std::sort(shop.jobs.begin(), shop.jobs.end(),
            [](const JobView& a, const JobView& b) { return a.number < b.number; });
  shop.disks = client_.disks();
  shop.cells = cells_;
  shop.mounts = client_.mounts();
  return shop;
}

}  // namespace intaglio::client
