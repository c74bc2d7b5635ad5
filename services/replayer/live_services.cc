#include "services/replayer/live_services.h"

#include <fmt/format.h>

#include "services/platform/bus/samples.h"

namespace intaglio::replayer {
namespace {

/// Null for one that only listens.
const char* ServesAs(intaglio_ServiceRole role) {
  switch (role) {
    case intaglio_ROLE_JOB_SERVICE:
      return "job service";
    case intaglio_ROLE_DISCRETIZER:
      return "discretizer";
    case intaglio_ROLE_SORTER:
      return "sorter";
    case intaglio_ROLE_SYNCHRONIZER:
      return "synchronizer";
    case intaglio_ROLE_MOTION_BRIDGE:
      return "motion bridge";
    default:
      return nullptr;
  }
}

}  // namespace

LiveServices::LiveServices(bus::Bus& bus)
    : health_(bus, bus::kServiceHealth, {}, bus::Source::kOtherProcesses) {}

const std::map<std::string, std::string>& LiveServices::Read() {
  health_.TakeAll(
      [this](const intaglio_ServiceHealth& sample, const bus::SampleOrigin& origin) {
        const std::string instance(bus::View(sample.instance));
        const char* role = origin.alive ? ServesAs(sample.role) : nullptr;
        if (role == nullptr || sample.state == intaglio_HEALTH_STOPPING) {
          serving_.erase(instance);
          return;
        }
        const std::string cell(bus::View(sample.cell));
        serving_[instance] =
            fmt::format("{}{} ({})", role, cell.empty() ? "" : " of " + cell, instance);
      });
  return serving_;
}

}  // namespace intaglio::replayer
