#pragma once

// What a job service keeps of its machines, over restarts.

#include <cstdint>
#include <string>
#include <vector>

#include "services/job/machine/mounted_parts.h"

namespace intaglio::job_service {

/// The job that was granted a permission in the machine last: piece_book.h.
struct PieceRecord {
  std::string cell;
  std::string job_uid;
  std::uint32_t job_number = 0;
  bool opened = false;                  ///< key or door was open after the job had ended
  std::vector<std::uint32_t> stations;  ///< granted since the last opening
  std::string block;                    ///< size of their blocks, as in JobPlace
};

/// A loader has put the block in for this job.
struct LoadedBlock {
  std::string cell, block_id, job_uid;
};

/// What a person reported as mounted: the newest counts, and the older ones are the
/// journal.
struct MountRecord {
  std::uint64_t number = 0;  ///< grows by one a mount, over all machines
  std::string cell;
  MountedParts parts;
  std::string operator_name;  ///< who reported it
  std::string mounted_utc;    ///< when, ISO 8601, ms
};

}  // namespace intaglio::job_service
