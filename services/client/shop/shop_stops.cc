#include "services/client/shop/shop_stops.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <set>

#include "engrave/core/try.h"
#include "services/platform/bus/samples.h"

namespace intaglio::client {
namespace {

using bus::Borrow;
using bus::View;

std::string SourceName(const std::string& program) {
  char host[256] = "localhost";
  gethostname(host, sizeof host - 1);
  return fmt::format("{}-{}-{}-{:x}", program, host, getpid(),
                     std::chrono::system_clock::now().time_since_epoch().count());
}

}  // namespace

bool Names(const HeldPresses& presses, const std::string& source, std::uint64_t number) {
  return std::any_of(presses.begin(), presses.end(), [&](const HeldPress& press) {
    return press.source == source && press.number >= number;
  });
}

StopSource::StopSource(bus::Bus& bus, const std::string& program, std::string cell)
    : name_(SourceName(program)),
      cell_(std::move(cell)),
      writer_(bus, bus::kEmergencyStop, cell_) {}

Result<std::uint64_t> StopSource::Press(const std::string& reason) {
  return Send(true, reason, {});
}

Result<std::uint64_t> StopSource::Release(const HeldPresses& presses,
                                          const std::string& reason) {
  return Send(false, reason, presses);
}

Result<std::uint64_t> StopSource::Send(bool pressed, const std::string& reason,
                                       const HeldPresses& presses) {
  std::vector<intaglio_StopPress> released;
  for (const HeldPress& press : presses)
    released.push_back({Borrow(press.source), press.number});
  intaglio_EmergencyStop sample{};
  sample.cell = Borrow(cell_);
  sample.source = Borrow(name_);
  sample.number = ++number_;
  sample.pressed = pressed;
  sample.operator_name = Borrow(operator_name_);
  sample.reason = Borrow(reason);
  Borrow(sample.released, released);
  INTAGLIO_TRY(writer_.Write(sample));
  return number_;
}

MachineReports::MachineReports(bus::Bus& bus, const std::string& cell)
    : interlocks_(bus, bus::kInterlock, cell) {
  if (cell.empty()) {
    health_ =
        std::make_unique<bus::Reader<intaglio_ServiceHealth>>(bus, bus::kServiceHealth);
    listed_ = std::make_unique<ListedServices>(bus);
  } else {
    machines_[cell];
  }
}

const std::map<std::string, MachineStops>& MachineReports::Poll() {
  if (health_) health_->Take([this](const intaglio_ServiceHealth& s) { Add(s); });
  if (listed_) listed_->Poll();
  interlocks_.Take([this](const intaglio_Interlock& sample) {
    MachineStops& machine = machines_[std::string(View(sample.cell))];
    machine = {true,
               sample.bus_stop_pressed,
               {},
               sample.laser_link_up,
               sample.key_on,
               sample.door_closed,
               sample.emergency_stop_released,
               sample.shutters_open == 0};
    for (const intaglio_StopPress& press : View(sample.bus_stops))
      machine.held.push_back({std::string(View(press.source)), press.number});
  });
  return machines_;
}

void MachineReports::Add(const intaglio_ServiceHealth& sample) {
  if (kMachineRoles.contains(sample.role) && !View(sample.cell).empty())
    machines_[std::string(View(sample.cell))];
}

bool MachineReports::KnowsAllMachines() const {
  if (!listed_) return false;
  std::set<std::string> cells;
  for (const auto& [cell, stops] : machines_) cells.insert(cell);
  return listed_->AreAllIn(cells, kMachineRoles);
}

}  // namespace intaglio::client
