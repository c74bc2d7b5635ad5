#include "services/platform/security/roles.h"

#include <initializer_list>

namespace intaglio::security {
namespace {

template <typename T>
RoleTopic Of(const bus::Topic<T>& topic, const std::string& of_roles = "*") {
  return {topic.name, topic.domain, topic.scope, of_roles};
}

using Topics = std::vector<RoleTopic>;

Topics Join(std::initializer_list<Topics> parts) {
  Topics all;
  for (const Topics& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

// Every service publishes its health.
Topics OwnReports() { return {Of(bus::kServiceHealth), Of(bus::kAlarm)}; }

// What can be seen of a shop without seeing what is engraved.
Topics ShopState() {
  return {Of(bus::kJobStatus),     Of(bus::kJobCount),    Of(bus::kTaskStatus),
          Of(bus::kServiceHealth), Of(bus::kServiceList), Of(bus::kAlarm),
          Of(bus::kDiskSpace),     Of(bus::kMounted),     Of(bus::kKnownService)};
}

Topics CellState() {
  return {Of(bus::kMotionState),   Of(bus::kPositionReport), Of(bus::kLampSync),
          Of(bus::kInterlock),     Of(bus::kPermission),     Of(bus::kPulseEventBatch),
          Of(bus::kEmergencyStop), Of(bus::kManualState)};
}

// A web console is an operator, and says where it serves.
Role Operator() {
  return {bus::kOperatorRole,
          "*",
          {Of(bus::kJobSubmission), Of(bus::kJobCommand), Of(bus::kEmergencyStop),
           Of(bus::kManualCommand), Of(bus::kServiceHealth)},
          Join({ShopState(), CellState(), {Of(bus::kJobCommandAnswer)}})};
}

// To submit is one right; to arm, to move and to light is another one. An emergency stop
// is everybody's who has a place in the shop.
Role Submitter() {
  return {bus::kSubmitterRole,
          "*",
          {Of(bus::kJobSubmission), Of(bus::kEmergencyStop)},
          Join({ShopState(), CellState()})};
}

Role JobService() {
  return {bus::kJobServiceRole,
          "*",
          Join({OwnReports(),
                {Of(bus::kPresence), Of(bus::kServiceList), Of(bus::kDiskSpace),
                 Of(bus::kJobStatus), Of(bus::kJobCount), Of(bus::kJobCommandAnswer),
                 Of(bus::kDiscretizeTask), Of(bus::kSortTask), Of(bus::kEngraveTask),
                 Of(bus::kModelChunk), Of(bus::kPermission), Of(bus::kMounted),
                 Of(bus::kKnownService)}}),
          {Of(bus::kJobSubmission), Of(bus::kJobCommand), Of(bus::kTaskStatus),
           Of(bus::kServiceHealth), Of(bus::kCredit), Of(bus::kEmergencyStop),
           Of(bus::kPresence), Of(bus::kManualCommand), Of(bus::kInterlock),
           Of(bus::kMachineReport)}};
}

Role StageWorker() {
  return {bus::kStageWorkerRole,
          "*",
          Join({OwnReports(),
                {Of(bus::kPresence), Of(bus::kTaskStatus), Of(bus::kCredit),
                 Of(bus::kPointBatch), Of(bus::kPathBatch), Of(bus::kMarkBatch),
                 Of(bus::kOrderedMarkBatch)}}),
          {Of(bus::kDiscretizeTask), Of(bus::kSortTask), Of(bus::kModelChunk),
           Of(bus::kPointBatch), Of(bus::kMarkBatch), Of(bus::kCredit)}};
}

// Health shows a second synchronizer or bridge of the same machine that the first one
// exists.
Role Cell(const std::string& cell) {
  return {bus::CellRole(cell),
          cell,
          Join({OwnReports(),
                {Of(bus::kPresence), Of(bus::kTaskStatus), Of(bus::kCredit),
                 Of(bus::kMotionSegmentBatch), Of(bus::kMotionState),
                 Of(bus::kPositionReport), Of(bus::kLampSync), Of(bus::kPulseEventBatch),
                 Of(bus::kInterlock), Of(bus::kCellMove), Of(bus::kManualState),
                 Of(bus::kMachineReport)}}),
          {Of(bus::kServiceHealth), Of(bus::kEngraveTask), Of(bus::kPathBatch),
           Of(bus::kOrderedMarkBatch), Of(bus::kCredit), Of(bus::kPermission),
           Of(bus::kEmergencyStop), Of(bus::kMotionSegmentBatch), Of(bus::kMotionState),
           Of(bus::kPositionReport), Of(bus::kPresence, bus::kJobServiceRole),
           Of(bus::kInterlock), Of(bus::kManualCommand), Of(bus::kCellMove),
           Of(bus::kManualState)}};
}

Role Recorder() {
  return {bus::kRecorderRole, "*", OwnReports(),
          Join({ShopState(),
                CellState(),
                {Of(bus::kJobSubmission), Of(bus::kJobCommand),
                 Of(bus::kJobCommandAnswer), Of(bus::kDiscretizeTask), Of(bus::kSortTask),
                 Of(bus::kEngraveTask), Of(bus::kCredit), Of(bus::kMotionSegmentBatch),
                 Of(bus::kModelChunk), Of(bus::kPointBatch), Of(bus::kPathBatch),
                 Of(bus::kMarkBatch), Of(bus::kOrderedMarkBatch), Of(bus::kManualCommand),
                 Of(bus::kCellMove), Of(bus::kMachineReport)}})};
}

Role Observer() {
  return {bus::kObserverRole, "*", {}, Join({ShopState(), CellState()})};
}

}  // namespace

std::vector<Role> RolesOf(const std::vector<std::string>& cells) {
  std::vector<Role> roles = {Operator(),    Submitter(), JobService(),
                             StageWorker(), Recorder(),  Observer()};
  for (const std::string& cell : cells) roles.push_back(Cell(cell));
  return roles;
}

std::string WritePartition(const Role& role, const RoleTopic& topic) {
  if (topic.scope == bus::Scope::kRole) return bus::RolePartition(role.name);
  return topic.scope == bus::Scope::kCell ? role.partition : "";
}

std::string ReadPartition(const Role& role, const RoleTopic& topic) {
  if (topic.scope == bus::Scope::kRole) {
    // A role that reads every cell reads everything, also samples without a partition.
    const bool all = topic.of_roles == "*" && role.partition == "*";
    return all ? "*" : bus::RolePartition(topic.of_roles);
  }
  return topic.scope == bus::Scope::kCell ? role.partition : "";
}

}  // namespace intaglio::security
