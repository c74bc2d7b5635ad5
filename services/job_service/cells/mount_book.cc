#include "services/job_service/cells/mount_book.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "proto/task.pb.h"

namespace intaglio::job_service {

void MountBook::Restore(std::vector<MountRecord> mounts) {
  for (MountRecord& mount : mounts) {
    last_number_ = std::max(last_number_, mount.number);
    mounts_[mount.cell] = std::move(mount);
  }
}

std::optional<MountRecord> MountBook::RecordFor(const CommandView& command,
                                                const std::string& now_utc) const {
  const auto known = mounts_.find(command.cell);
  const bool repeats = known != mounts_.end() && known->second.parts == command.mounted;
  if (command.basis == intaglio_ARM_BY_PROGRAM && repeats) return std::nullopt;
  return MountRecord{last_number_ + 1, command.cell, command.mounted,
                     command.operator_name, now_utc};
}

void MountBook::Set(const MountRecord& mount) {
  last_number_ = mount.number;
  mounts_[mount.cell] = mount;
  ++revision_;
}

std::string MountBook::MisfitOf(const JobRecord& job) const {
  FrozenJob frozen;
  // A job that is not readable is refused by its workers.
  if (job.frozen_job.empty() || !frozen.ParseFromString(job.frozen_job)) return "";
  const auto known = mounts_.find(job.cell);
  const MountedParts mounted =
      known == mounts_.end() ? MountedParts() : known->second.parts;
  if (IsRealMachine(frozen.machine())) {
    const auto missing = MissingParts(frozen, mounted);
    if (!missing.empty()) {
      const std::string wanted = WantedTextOf(frozen);
      return fmt::format(
          "nobody has reported what is mounted in {} ({}){}: check it and report it "
          "({}), then "
          "intaglio arm {}",
          job.cell, fmt::join(missing, ", "),
          wanted.empty() ? "" : "; the job is for " + wanted, MountCommandFor(frozen),
          job.number);
    }
  }
  if (known == mounts_.end() || !PartsOf(frozen).block_mm) return "";
  return MountMisfit(frozen, mounted);
}

}  // namespace intaglio::job_service
