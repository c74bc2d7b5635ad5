#include "services/job_service/published/service_list.h"

#include <utility>
#include <vector>

#include "services/platform/bus/samples.h"
#include "services/platform/host/peers/identity_role.h"
#include "services/platform/host/process/log.h"

namespace intaglio::job_service {

using bus::Borrow;
using bus::View;

ServiceList::ServiceList(bus::Bus& bus, std::string instance)
    : instance_(std::move(instance)),
      discovery_time_(bus.discovery_time()),
      health_(bus, bus::kServiceHealth),
      lists_(bus, bus::kServiceList),
      known_(bus) {}

void ServiceList::TakeHealth(std::chrono::nanoseconds now) {
  health_.TakeAll(
      [this, now](const intaglio_ServiceHealth& health, const bus::SampleOrigin& origin) {
        if (!host::IsOwnHealth(health, origin)) return;
        const std::string instance(View(health.instance));
        if (!origin.alive) {
          instances_.End(instance);
          known_.Remove(instance);
          changed_ = services_.erase(instance) > 0 || changed_;
          return;
        }
        if (!instances_.Admit(instance)) return;
        known_.Update(health, now);
        if (services_.contains(instance)) return;
        services_[instance] = {health.role, std::string(View(health.cell))};
        changed_ = true;
      });
}

void ServiceList::Turn(std::chrono::nanoseconds now) {
  if (first_turn_.count() < 0) first_turn_ = now;
  TakeHealth(now);
  known_.Turn(now);
  if (changed_ && now - first_turn_ >= discovery_time_) Publish();
}

void ServiceList::Publish() {
  std::vector<intaglio_ServiceEntry> entries;
  for (const auto& [instance, entry] : services_)
    entries.push_back({Borrow(instance), entry.role, Borrow(entry.cell)});
  intaglio_ServiceList sample{};
  sample.instance = Borrow(instance_);
  Borrow(sample.services, entries);
  if (auto written = lists_.Write(sample); written)
    changed_ = false;
  else
    host::LogWarning("list of the services: {}", written.error().message);
}

}  // namespace intaglio::job_service
