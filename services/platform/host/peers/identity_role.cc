#include "services/platform/host/peers/identity_role.h"

#include <fmt/format.h>

#include "services/platform/bus/role_names.h"
#include "services/platform/bus/samples.h"

namespace intaglio::host {
namespace {

bool IsOfItsRole(const intaglio_ServiceHealth& health, const bus::SampleWriter& writer) {
  const std::string role = IdentityRole(health.role, std::string(bus::View(health.cell)));
  return writer.partition == bus::RolePartition(role);
}

}  // namespace

std::string IdentityRole(intaglio_ServiceRole role, const std::string& cell) {
  switch (role) {
    case intaglio_ROLE_JOB_SERVICE:
      return bus::kJobServiceRole;
    case intaglio_ROLE_DISCRETIZER:
    case intaglio_ROLE_SORTER:
      return bus::kStageWorkerRole;
    case intaglio_ROLE_SYNCHRONIZER:
    case intaglio_ROLE_MOTION_BRIDGE:
      return bus::CellRole(cell);
    case intaglio_ROLE_RECORDER:
    case intaglio_ROLE_REPLAYER:
      return bus::kRecorderRole;
    case intaglio_ROLE_CONSOLE:
      return bus::kOperatorRole;
  }
  return bus::kObserverRole;
}

std::string InstanceName(const std::string& service, const std::string& host, int pid,
                         const std::string& participant) {
  return fmt::format("{}-{}-{}-{}", service, host, pid, participant);
}

bool IsOwn(std::string_view instance, const bus::SampleOrigin& origin) {
  // The library ends an instance when its last writer is lost; that cannot be forged.
  if (!origin.alive && !origin.disposed) return true;
  return origin.writer != nullptr && instance.ends_with("-" + origin.writer->participant);
}

bool IsOwnHealth(const intaglio_ServiceHealth& health, const bus::SampleOrigin& origin) {
  if (!IsOwn(bus::View(health.instance), origin)) return false;
  return !origin.alive || IsOfItsRole(health, *origin.writer);
}

bool IsOwnTask(const intaglio_TaskStatus& status, const bus::SampleOrigin& origin) {
  if (!IsOwn(bus::View(status.worker), origin)) return false;
  if (!origin.alive) return true;
  if (status.stage != intaglio_STAGE_ENGRAVE) {
    return origin.writer->partition == bus::RolePartition(bus::kStageWorkerRole);
  }
  return origin.writer->partition.starts_with(bus::RolePartition(bus::kCellPrefix));
}

bool HasNoRole(const bus::SampleOrigin& origin) {
  return origin.writer != nullptr && origin.writer->partition.empty();
}

}  // namespace intaglio::host
