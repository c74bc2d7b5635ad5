#pragma once

// Who may do what on a secured bus: the one table of the roles and their topics. It is
// signed into each role's permissions; docs/deployment.md shows it.
//
// The permissions are by topic, partition and domain. What stands in a sample is not
// looked at: a role that may write TaskStatus may write that of any task.

#include <string>
#include <vector>

#include "services/bus/topics.h"

namespace intaglio::security {

/// A topic as far as permissions see it.
struct RoleTopic {
  const char* name;
  bus::DomainKind domain;
  bus::Scope scope;
};

struct Role {
  std::string name;       ///< folder and common name, e.g. "job-service", "cell-els-03"
  std::string partition;  ///< of its cell topics: the cell, or "*" for all
  std::vector<RoleTopic> writes, reads;
};

/// operator, job-service, stage-worker, recorder, observer, and a cell-NAME for each of
/// `cells`: synchronizer and motion bridge of that machine.
std::vector<Role> RolesOf(const std::vector<std::string>& cells);

/// Prefix of the roles of cells.
inline constexpr char kCellPrefix[] = "cell-";

}  // namespace intaglio::security
