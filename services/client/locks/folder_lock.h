#pragma once

// A folder that belongs to one process at a time: two queues on one database, or two
// machines on one glass record, would spoil each other.

#include <filesystem>
#include <utility>

#include "engrave/core/result.h"
#include "services/client/locks/file_lock.h"

namespace intaglio::client {

class FolderLock {
 public:
  /// Makes the folder if need be. kRefused names the process that has it; kIo when the
  /// folder cannot be written. The lock goes with the process, however it ends.
  static Result<FolderLock> Take(const std::filesystem::path& folder);
  FolderLock(FolderLock&&) noexcept = default;
  FolderLock& operator=(FolderLock&&) = delete;

 private:
  explicit FolderLock(FileLock file) : file_(std::move(file)) {}
  FileLock file_;
};

}  // namespace intaglio::client
