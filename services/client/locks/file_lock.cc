#include "services/client/locks/file_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

bool IsFile(int fd, const fs::path& file) {
  struct stat opened = {}, named = {};
  return fstat(fd, &opened) == 0 && stat(file.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

}  // namespace

Result<FileLock> FileLock::TryLock(const fs::path& file) {
  const int fd = open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644);
  if (fd < 0) return Fail(ErrorCode::kIo, std::strerror(errno), file.string());
  FileLock lock(fd);
  if (flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return Fail(ErrorCode::kRefused, "another process has locked it", file.string());
  }
  // A process that was refused has removed the file meanwhile: it locks nothing.
  if (!IsFile(fd, file)) return TryLock(file);
  return lock;
}

FileLock::~FileLock() {
  if (fd_ >= 0) close(fd_);
}

Status FileLock::WriteText(std::string_view text) const {
  if (ftruncate(fd_, 0) != 0 || pwrite(fd_, text.data(), text.size(), 0) < 0)
    return Fail(ErrorCode::kIo, std::strerror(errno));
  return {};
}

}  // namespace intaglio::client
