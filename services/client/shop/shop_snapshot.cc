#include "services/client/shop/shop_snapshot.h"

#include <algorithm>

#include "services/platform/bus/samples.h"

namespace intaglio::client {

using bus::View;

ShopWatcher::Cells::Cells(bus::Bus& bus)
    : interlocks(bus, bus::kInterlock, ""),
      lamps(bus, bus::kLampSync, ""),
      motion(bus, bus::kMotionState, "") {}

void ShopWatcher::Cells::Take() {
  interlocks.TakeAll(
      [this](const intaglio_Interlock& sample, const bus::SampleOrigin& origin) {
        const std::string cell(View(sample.cell));
        if (origin.alive) {
          Update(cells[cell], sample);
        } else {
          cells.erase(cell);
        }
      });
  lamps.Take([this](const intaglio_LampSync& sample) {
    Update(cells[std::string(View(sample.cell))], sample);
  });
  motion.Take([this](const intaglio_MotionState& sample) {
    CellSnapshot& cell = cells[std::string(View(sample.cell))];
    Update(cell, sample);
    cell.x_mm = sample.x_mm;
    cell.y_mm = sample.y_mm;
    cell.z_mm = sample.z_mm;
    cell.at_rest = sample.at_rest;
  });
}

ShopWatcher::ShopWatcher(bus::Bus& bus) : client_(bus) {
  if (bus.options().meets_cells) {
    met_ = std::make_unique<Cells>(bus);
  } else {
    known_ = std::make_unique<KnownMachines>(bus);
  }
}

void ShopWatcher::Poll(std::chrono::milliseconds time) {
  client_.Poll(time);
  if (met_) met_->Take();
  if (known_) known_->Poll();
}

std::vector<ServiceView> ShopWatcher::services() const {
  return known_ ? known_->services() : client_.services();
}

std::map<std::string, CellSnapshot> ShopWatcher::cells() const {
  if (met_) return met_->cells;
  std::map<std::string, CellSnapshot> cells;
  for (const auto& [name, facts] : known_->machines()) cells[name] = {facts};
  return cells;
}

bool ShopWatcher::IsServed() const {
  return std::ranges::any_of(client_.services(), [](const ServiceView& service) {
    return service.role == intaglio_ROLE_JOB_SERVICE;
  });
}

const ServiceView* FindJobService(const std::vector<ServiceView>& services) {
  const auto found =
      std::ranges::find(services, intaglio_ROLE_JOB_SERVICE, &ServiceView::role);
  return found == services.end() ? nullptr : &*found;
}

bool IsOfMachine(const ServiceView& service) {
  return service.role == intaglio_ROLE_SYNCHRONIZER ||
         service.role == intaglio_ROLE_MOTION_BRIDGE;
}

bool HasAnotherVersion(const ServiceView& service, const ServiceView* job_service) {
  return job_service != nullptr && service.version != job_service->version;
}

bool HasAnotherVersion(const std::string& cell,
                       const std::vector<ServiceView>& services) {
  const ServiceView* job_service = FindJobService(services);
  return std::ranges::any_of(services, [&](const ServiceView& service) {
    return IsOfMachine(service) && service.cell == cell &&
           HasAnotherVersion(service, job_service);
  });
}

bool ShopWatcher::IsComplete() const {
  const auto found = services();
  const auto machines = cells();
  const ServiceView* job_service = FindJobService(found);
  for (const ServiceView& service : found) {
    if (HasAnotherVersion(service, job_service)) continue;
    const auto cell = machines.find(service.cell);
    const bool known = cell != machines.end();
    if (service.role == intaglio_ROLE_SYNCHRONIZER &&
        !(known && cell->second.has_interlock))
      return false;
    if (service.role == intaglio_ROLE_MOTION_BRIDGE &&
        !(known && cell->second.has_motion))
      return false;
  }
  const bool all = IsServed() && client_.KnowsAllServices(found) &&
                   client_.KnowsAllJobs() && !client_.disks().empty();
  // Who is missing in what a job service knows is not there; another client may yet
  // discover it.
  if (known_ || !all) return all;
  const auto has = [&](intaglio_ServiceRole role) {
    return std::ranges::find(found, role, &ServiceView::role) != found.end();
  };
  return has(intaglio_ROLE_DISCRETIZER) && has(intaglio_ROLE_SORTER) &&
         has(intaglio_ROLE_SYNCHRONIZER) &&
         (has(intaglio_ROLE_MOTION_BRIDGE) ||
          std::ranges::any_of(found, &ServiceView::is_marker));
}

ShopSnapshot ShopWatcher::Take() const {
  ShopSnapshot shop;
  shop.taken_at = std::chrono::steady_clock::now();
  shop.services = services();
  for (const auto& [uid, job] : client_.jobs()) shop.jobs.push_back(job);
  std::sort(shop.jobs.begin(), shop.jobs.end(),
            [](const JobView& a, const JobView& b) { return a.number < b.number; });
  shop.disks = client_.disks();
  shop.cells = cells();
  shop.mounts = client_.mounts();
  return shop;
}

}  // namespace intaglio::client
