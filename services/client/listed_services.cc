#include "services/client/listed_services.h"

#include <algorithm>

#include "services/platform/bus/samples.h"

namespace intaglio::client {

using bus::View;

ListedServices::ListedServices(bus::Bus& bus) : reader_(bus, bus::kServiceList) {}

void ListedServices::Poll() {
  reader_.TakeAll(
      [this](const intaglio_ServiceList& list, const bus::SampleOrigin& origin) {
        const std::string instance(View(list.instance));
        if (!origin.alive) {
          lists_.erase(instance);
          return;
        }
        std::vector<ListedService>& services = lists_[instance];
        services.clear();
        for (const intaglio_ServiceEntry& entry : View(list.services)) {
          services.push_back({std::string(View(entry.instance)), entry.role,
                              std::string(View(entry.cell))});
        }
      });
}

std::set<std::string> ListedServices::Cells(
    const std::set<intaglio_ServiceRole>& roles) const {
  std::set<std::string> cells;
  for (const auto& [instance, services] : lists_) {
    for (const ListedService& service : services)
      if (roles.contains(service.role)) cells.insert(service.cell);
  }
  return cells;
}

bool ListedServices::AreAllIn(const std::set<std::string>& found,
                              const std::set<intaglio_ServiceRole>& roles) const {
  const auto listed = Cells(roles);
  return !listed.empty() &&
         std::includes(found.begin(), found.end(), listed.begin(), listed.end());
}

}  // namespace intaglio::client
