#pragma once

// What is mounted in each machine, as a person reported at the machine or when its shop
// was opened, and whether a job may be armed for it.
//
// 1. A job is armed only for what is mounted, as MountMisfit compares them.
// 2. A job of a real machine is armed only when every part that it needs was named: what
//    nobody named is asked for. Of a virtual machine it is not compared.
// 3. What a person says ends every arm at that machine, also when it is the same as
//    before: the block is another one. A program that repeats what it was started with
//    ends arms only when that differs; and where nobody had reported anything before,
//    only those of jobs that are not for it: the machine is the one that was armed.
// Used from one thread.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "services/job_service/records/cell_records.h"
#include "services/job_service/records/job_record.h"

namespace intaglio::job_service {

class MountBook {
 public:
  /// The newest of each machine.
  void Restore(std::vector<MountRecord> mounts);
  /// The record that the command makes, to be kept and then given to Set; nullopt: a
  /// program repeats what is known. `now_utc`: ISO 8601.
  std::optional<MountRecord> RecordFor(const CommandView& command,
                                       const std::string& now_utc) const;
  void Set(const MountRecord& mount);

  const std::map<std::string, MountRecord>& mounts() const { return mounts_; }
  /// Grows with every Set.
  std::uint64_t revision() const { return revision_; }
  /// Why the job may not be armed, and what to do; empty: it may.
  std::string MisfitOf(const JobRecord& job) const;

 private:
  std::map<std::string, MountRecord> mounts_;  // by cell
  std::uint64_t last_number_ = 0, revision_ = 1;
};

}  // namespace intaglio::job_service
