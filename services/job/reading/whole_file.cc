#include "services/job/reading/whole_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>

namespace intaglio::reading {

bool WriteAll(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return true;
}

std::vector<std::byte> ReadAll(int descriptor) {
  struct stat status {};
  if (fstat(descriptor, &status) != 0 || status.st_size < 0) return {};
  std::vector<std::byte> bytes(static_cast<std::size_t>(status.st_size));
  std::size_t size = 0;
  while (size < bytes.size()) {
    const ssize_t got = pread(descriptor, bytes.data() + size, bytes.size() - size,
                              static_cast<off_t>(size));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return {};
    size += static_cast<std::size_t>(got);
  }
  return bytes;
}

}  // namespace intaglio::reading
