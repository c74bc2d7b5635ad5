#pragma once

// A folder that belongs to one process at a time: two queues on one database, or two
// machines on one glass record, would spoil each other.

#include <filesystem>

#include "engrave/core/result.h"

namespace intaglio::client {

class FolderLock {
 public:
  /// Makes the folder if need be. kRefused names the process that has it; kIo when the
  /// folder cannot be written. The lock goes with the process, however it ends.
  static Result<FolderLock> Take(const std::filesystem::path& folder);
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&&) = delete;
  ~FolderLock();

 private:
  explicit FolderLock(int fd) : fd_(fd) {}
  int fd_;
};

}  // namespace intaglio::client
