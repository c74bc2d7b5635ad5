#pragma once

// All that a shop keeps, into one file and back: its queue, the folders of its jobs with
// their journals, its material base and its machine profiles. Recordings, logs and the
// glass records of virtual machines are not in it.

#include <filesystem>
#include <set>
#include <string>
#include <vector>

#include "engrave/core/result.h"
#include "services/backup/archive.h"

namespace intaglio::backup {

/// Where a shop keeps them.
struct ShopPlaces {
  std::filesystem::path database;   ///< "queue": the file of the job service
  std::filesystem::path results;    ///< "jobs": the folder of the jobs' folders
  std::filesystem::path materials;  ///< "materials": the material base
  /// "machines": the folder of the profiles (*.textproto, with the history of what was
  /// taught beside each).
  std::filesystem::path machines;
};

/// Names of parts that are left out.
using Parts = std::set<std::string>;
inline constexpr const char* kParts[] = {"queue", "jobs", "materials", "machines"};

/// Puts them into `file`, while the shop is open or closed: the queue as it is at one
/// moment, and then the journals, which may have more. kNotFound: no queue; kUnreadable:
/// a damaged database; kRefused, kIo as ArchiveWriter.
Result<std::vector<ArchivedFile>> BackUp(const ShopPlaces& places, const Parts& without,
                                         const std::filesystem::path& file);

struct RestoreOptions {
  ShopPlaces places;
  Parts without;
  /// What is there already is kept beside it, as NAME.replaced-TIME; without this,
  /// kRefused.
  bool replace = false;
};

/// Puts the files of a backup to their places. kRefused: the shop is open, or a part is
/// there already. Nothing is changed unless all of it could be written. Returns what was
/// kept beside.
Result<std::vector<std::filesystem::path>> Restore(const Archive& archive,
                                                   const RestoreOptions& options);

}  // namespace intaglio::backup
