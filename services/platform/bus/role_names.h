#pragma once

// Names of the identities of a shop, and the DDS partition in which each of them writes
// what several roles may write: its health, its tasks, its credit, its alarms.
//
// On a secured bus the access control lets an identity write in the partition of its own
// role alone. So a reader of "role/cell-els-03" receives nothing that a stage worker has
// written, whatever name the worker puts in the sample. Without identities, on one
// computer, the partitions are the same but are not enforced.

#include <string>

namespace intaglio::bus {

inline constexpr char kOperatorRole[] = "operator";
inline constexpr char kSubmitterRole[] = "submitter";
inline constexpr char kJobServiceRole[] = "job-service";
inline constexpr char kStageWorkerRole[] = "stage-worker";
inline constexpr char kRecorderRole[] = "recorder";
inline constexpr char kObserverRole[] = "observer";
/// Prefix of the roles of cells: synchronizer and motion bridge of one machine.
inline constexpr char kCellPrefix[] = "cell-";
/// No cell has it in its name, so no partition of a cell is that of a role.
inline constexpr char kRolePartitionPrefix[] = "role/";

inline std::string CellRole(const std::string& cell) { return kCellPrefix + cell; }
inline std::string RolePartition(const std::string& role) {
  return kRolePartitionPrefix + role;
}
/// Of the roles of all cells; for readers.
inline std::string AnyCellPartition() { return RolePartition(CellRole("*")); }

}  // namespace intaglio::bus
