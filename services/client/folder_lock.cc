#include "services/client/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

namespace intaglio::client {

namespace fs = std::filesystem;

namespace {

bool IsFile(int fd, const fs::path& file) {
  struct stat opened = {}, named = {};
  return fstat(fd, &opened) == 0 && stat(file.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace

Result<FolderLock> FolderLock::Take(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::path file = folder / "lock";
  const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (fd < 0) {
    return Fail(
        ErrorCode::kIo,
        fmt::format(
            "cannot write to the folder {}: {}; choose another folder with --folder",
            folder.string(), std::strerror(errno)),
        folder.string());
  }
  // A process that was refused has removed the file meanwhile: it locks nothing.
  if (flock(fd, LOCK_EX | LOCK_NB) == 0 && !IsFile(fd, file)) {
    close(fd);
    return Take(folder);
  }
  if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
    std::string pid = "unknown";
    std::ifstream(file) >> pid;
    close(fd);
    return Fail(ErrorCode::kRefused,
                fmt::format("the folder {} is in use by the process {}; end that "
                            "process, or choose another folder with --folder",
                            folder.string(), pid),
                folder.string());
  }
  const std::string pid = std::to_string(getpid()) + "\n";
  if (ftruncate(fd, 0) != 0 || write(fd, pid.data(), pid.size()) < 0) {
    const int why = errno;
    close(fd);
    return Fail(
        ErrorCode::kIo,
        fmt::format(
            "{}: {}; free space on the disk, or choose another folder with --folder",
            file.string(), std::strerror(why)),
        folder.string());
  }
  return FolderLock(fd);
}

FolderLock::FolderLock(FolderLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}

FolderLock::~FolderLock() {
  if (fd_ >= 0) close(fd_);
}

}  // namespace intaglio::client
