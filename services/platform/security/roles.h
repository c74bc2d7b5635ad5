#pragma once

// What each role may do on a secured bus: the one table of the roles and their topics. It
// is signed into each role's permissions; docs/deployment.md shows it.
//
// The permissions are by topic, partition and domain. A topic that several roles write is
// written in the partition of the role (services/platform/bus/role_names.h), so that its
// readers know whose it is. They do not check the fields of a sample: the job service
// checks that a TaskStatus is of a task that its writer was given.

#include <string>
#include <vector>

#include "services/platform/bus/role_names.h"
#include "services/platform/bus/topics.h"

namespace intaglio::security {

/// A topic as far as permissions see it.
struct RoleTopic {
  const char* name;
  bus::DomainKind domain;
  bus::Scope scope;
  std::string of_roles = "*";  ///< what several roles write: whose may be read
};

struct Role {
  std::string name;       ///< folder and common name, e.g. "job-service", "cell-els-03"
  std::string partition;  ///< of its cell topics: the cell, or "*" for all
  std::vector<RoleTopic> writes, reads;
};

/// operator, submitter, job-service, stage-worker, recorder, observer, and a cell-NAME
/// for each of `cells`: synchronizer and motion bridge of that machine.
std::vector<Role> RolesOf(const std::vector<std::string>& cells);

/// The partition in which the role may write or read the topic; empty: in none.
std::string WritePartition(const Role& role, const RoleTopic& topic);
std::string ReadPartition(const Role& role, const RoleTopic& topic);

}  // namespace intaglio::security
