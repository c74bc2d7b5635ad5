#pragma once

#include <sched.h>
#include <sys/mount.h>

#include <filesystem>
#include <string>

namespace intaglio::io {

/// Mounts a file system of the given size over the folder, seen by this process only.
/// False where that is not permitted (it takes root).
inline bool MountSmallDisk(const std::filesystem::path& folder, std::size_t byte_count) {
  if (::unshare(CLONE_NEWNS) != 0) return false;
  if (::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return false;
  const std::string options = "size=" + std::to_string(byte_count);
  return ::mount("tmpfs", folder.c_str(), "tmpfs", 0, options.c_str()) == 0;
}

}  // namespace intaglio::io
