#pragma once

// A file that one process has at a time. The lock goes with the process, however it ends.

#include <filesystem>
#include <string_view>
#include <utility>

#include "engrave/core/result.h"

namespace intaglio::client {

class FileLock {
 public:
  /// Makes the file if need be, which others may read. Follows no symbolic link, as in a
  /// folder that others can write to. kRefused: another process has it; kIo, with the
  /// system's reason: it cannot be opened.
  static Result<FileLock> TryLock(const std::filesystem::path& file);
  FileLock(FileLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  FileLock& operator=(FileLock&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  ~FileLock();

  /// Replaces the text of the file. kIo with the system's reason.
  Status WriteText(std::string_view text) const;

 private:
  explicit FileLock(int fd) : fd_(fd) {}
  int fd_;
};

}  // namespace intaglio::client
