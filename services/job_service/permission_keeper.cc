#include "services/job_service/permission_keeper.h"

#include "services/platform/bus/samples.h"
#include "services/platform/host/process/log.h"

namespace intaglio::job_service {

PermissionKeeper::PermissionKeeper(bus::Bus& bus)
    : bus_(bus), repeating_([this](const std::stop_token& stop) { Repeat(stop); }) {}

void PermissionKeeper::Repeat(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    if (std::chrono::steady_clock::now() - decided_at_ < kPatience) {
      for (auto& [name, cell] : cells_) Write(cell);
    }
    ends_.wait_for(lock, stop, kPeriod, [] { return false; });
  }
}

// The one that had no new job for the longest time.
PermissionKeeper::Cells::node_type PermissionKeeper::TakeOneUnused(
    const std::set<std::string>& in_use) {
  auto oldest = cells_.end();
  for (auto cell = cells_.begin(); cell != cells_.end(); ++cell) {
    if (in_use.contains(cell->first) || cell->second.stop.pressed()) continue;
    if (oldest == cells_.end() || cell->second.opened < oldest->second.opened) {
      oldest = cell;
    }
  }
  return oldest == cells_.end() ? Cells::node_type() : cells_.extract(oldest);
}

void PermissionKeeper::Open(const std::string& cell,
                            const std::set<std::string>& in_use) {
  // Its writer may wait for readers when it is closed: not while the others' permissions
  // wait for the mutex.
  Cells::node_type closed;
  const std::lock_guard lock(mutex_);
  if (const auto known = cells_.find(cell); known != cells_.end()) {
    known->second.opened = ++opened_;
    return;
  }
  if (cells_.size() >= kMaxCells) closed = TakeOneUnused(in_use);
  Cell& opened =
      cells_
          .emplace(
              cell,
              Cell{bus::Writer<intaglio_Permission>(bus_, bus::kPermission, cell),
                   bus::Reader<intaglio_EmergencyStop>(bus_, bus::kEmergencyStop, cell),
                   {},
                   {},
                   0,
                   ++opened_})
          .first->second;
  opened.decided.cell = cell;
}

std::vector<std::pair<std::string, bool>> PermissionKeeper::TakeStops() {
  const std::lock_guard lock(mutex_);
  std::vector<std::pair<std::string, bool>> pressed;
  for (auto& [name, cell] : cells_) {
    bool came = false;
    cell.stops.Take([&, &cell = cell](const intaglio_EmergencyStop& stop) {
      came = cell.stop.Receive(stop) || came;
    });
    pressed.emplace_back(name, came || cell.stop.pressed());
  }
  return pressed;
}

void PermissionKeeper::TakePresses(const std::string& cell,
                                   const std::vector<host::StopPress>& presses) {
  const std::lock_guard lock(mutex_);
  const auto known = cells_.find(cell);
  if (known == cells_.end()) return;
  for (const host::StopPress& press : presses)
    known->second.stop.TakePress(press.source, press.number);
}

void PermissionKeeper::Decide(const std::vector<PermissionView>& permissions) {
  const std::lock_guard lock(mutex_);
  decided_at_ = std::chrono::steady_clock::now();
  for (auto& [name, cell] : cells_) {
    PermissionView wanted = cell.decided;
    wanted.granted = false;
    for (const PermissionView& permission : permissions) {
      if (permission.cell == name) wanted = permission;
    }
    const bool changed = wanted.granted != cell.decided.granted ||
                         wanted.job_uid != cell.decided.job_uid ||
                         wanted.grant != cell.decided.grant ||
                         wanted.renewal != cell.decided.renewal ||
                         wanted.speed_percent != cell.decided.speed_percent;
    cell.decided = wanted;
    if (changed) Write(cell);
  }
}

void PermissionKeeper::Write(Cell& cell) {
  intaglio_Permission sample{};
  sample.cell = bus::Borrow(cell.decided.cell);
  sample.job_uid = bus::Borrow(cell.decided.job_uid);
  sample.epoch = cell.decided.epoch;
  sample.granted = cell.decided.granted;
  sample.operator_name = bus::Borrow(cell.decided.operator_name);
  sample.number = ++cell.number;
  sample.speed_percent = cell.decided.speed_percent;
  sample.grant = cell.decided.grant;
  sample.renewal = cell.decided.renewal;
  sample.first_point = cell.decided.first_point;
  sample.fire_uncertain = cell.decided.fire_uncertain;
  const auto held = host::WireOf(cell.stop.held());
  bus::Borrow(sample.bus_stops, held);
  if (auto written = cell.writer.Write(sample); !written) {
    host::LogWarning("permission of {}: {}", cell.decided.cell, written.error().message);
  }
}

}  // namespace intaglio::job_service
