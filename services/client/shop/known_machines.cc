#include "services/client/shop/known_machines.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "services/platform/bus/samples.h"

namespace intaglio::client {
namespace {

using bus::View;
using std::chrono::nanoseconds;

nanoseconds AgeOf(const intaglio_KnownService& sample, const bus::SampleOrigin& origin) {
  const nanoseconds now = std::chrono::system_clock::now().time_since_epoch();
  const nanoseconds on_the_way = now - nanoseconds(origin.source_ns);
  return std::chrono::milliseconds(sample.age_ms) + std::max(nanoseconds(0), on_the_way);
}

}  // namespace

KnownMachines::KnownMachines(bus::Bus& bus) : reader_(bus, bus::kKnownService) {}

void KnownMachines::Poll() {
  reader_.TakeAll([this](const intaglio_KnownService& sample,
                         const bus::SampleOrigin& origin) {
    const std::string instance(View(sample.instance));
    if (!origin.alive) {
      known_.erase(instance);
      return;
    }
    Known known;
    known.service =
        ServiceViewOf(sample, std::chrono::steady_clock::now() - AgeOf(sample, origin));
    known.service.left_out = View(sample.left_out);
    for (const intaglio_MachineFacts& facts : View(sample.facts))
      Update(known.facts.emplace_back(), facts);
    known_[instance] = std::move(known);
  });
}

std::vector<ServiceView> KnownMachines::services() const {
  std::vector<ServiceView> views;
  for (const auto& [instance, known] : known_) views.push_back(known.service);
  return views;
}

std::map<std::string, host::MachineFacts> KnownMachines::machines() const {
  std::map<std::string, host::MachineFacts> machines;
  for (const auto& [instance, known] : known_) {
    for (const host::MachineFacts& facts : known.facts)
      Update(machines[known.service.cell], facts);
  }
  return machines;
}

}  // namespace intaglio::client
