#include "services/job_service/published/known_services.h"

#include <optional>
#include <utility>
#include <vector>

#include "services/platform/bus/samples.h"
#include "services/platform/host/peers/identity_role.h"

namespace intaglio::job_service {

using bus::Borrow;
using bus::View;

KnownServices::KnownServices(bus::Bus& bus)
    : reports_(bus, bus::kMachineReport), writer_(bus, bus::kKnownService) {}

void KnownServices::Update(const intaglio_ServiceHealth& health,
                           std::chrono::nanoseconds now) {
  Known& known = services_[std::string(View(health.instance))];
  known.reported_at = now;
  Service service;
  service.role = health.role;
  service.state = health.state;
  service.host = View(health.host);
  service.cell = View(health.cell);
  service.version = View(health.version);
  service.message = View(health.message);
  service.pid = health.pid;
  service.left_out = known.service.left_out;
  if (service == known.service) return;
  known.service = std::move(service);
  known.changed = true;
}

void KnownServices::Remove(const std::string& instance) {
  if (services_.erase(instance) == 0) return;
  const std::string empty;
  intaglio_KnownService sample{};
  sample.instance = Borrow(instance);
  sample.host = sample.cell = sample.version = sample.message = Borrow(empty);
  sample.left_out = Borrow(empty);
  (void)writer_.Dispose(sample);
}

void KnownServices::SetLeftOut(const std::map<std::string, std::string>& workers) {
  for (auto& [instance, known] : services_) {
    const auto worker = workers.find(instance);
    const std::string why = worker == workers.end() ? "" : worker->second;
    if (why == known.service.left_out) continue;
    known.service.left_out = why;
    known.changed = true;
  }
}

void KnownServices::TakeReports() {
  reports_.TakeAll(
      [this](const intaglio_MachineReport& report, const bus::SampleOrigin& origin) {
        if (!host::IsOwn(View(report.instance), origin)) return;
        const std::string instance(View(report.instance));
        if (!origin.alive) instances_.End(instance);
        if (origin.alive) {
          if (!instances_.Admit(instance)) return;
          host::MachineFacts facts;
          host::Update(facts, report.facts);
          facts_[instance] = std::move(facts);
        } else {
          facts_.erase(instance);
        }
        const auto known = services_.find(instance);
        if (known != services_.end()) known->second.changed = true;
      });
}

void KnownServices::Turn(std::chrono::nanoseconds now) {
  TakeReports();
  for (auto& [instance, known] : services_) {
    if (!known.changed && now < known.next) continue;
    known.changed = !Publish(instance, known, now);
    known.next = now + kPeriod;
  }
}

bool KnownServices::Publish(const std::string& instance, const Known& known,
                            std::chrono::nanoseconds now) {
  const Service& service = known.service;
  const auto facts = facts_.find(instance);
  std::optional<host::WireFacts> wire;
  std::vector<intaglio_MachineFacts> machine;
  if (facts != facts_.end()) machine.push_back(wire.emplace(facts->second).sample());
  intaglio_KnownService sample{};
  sample.instance = Borrow(instance);
  sample.role = service.role;
  sample.state = service.state;
  sample.host = Borrow(service.host);
  sample.pid = service.pid;
  sample.cell = Borrow(service.cell);
  sample.version = Borrow(service.version);
  sample.message = Borrow(service.message);
  sample.left_out = Borrow(service.left_out);
  sample.age_ms = bus::AgeMs(now - known.reported_at);
  Borrow(sample.facts, machine);
  return writer_.Write(sample).has_value();
}

}  // namespace intaglio::job_service
