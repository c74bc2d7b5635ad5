#include "services/client/locks/folder_lock.h"

#include <fmt/format.h>
#include <unistd.h>

#include <fstream>
#include <string>

namespace intaglio::client {

namespace fs = std::filesystem;

Result<FolderLock> FolderLock::Take(const fs::path& folder) {
  std::error_code ignored;
  fs::create_directories(folder, ignored);
  const fs::path file = folder / "lock";
  auto lock = FileLock::TryLock(file);
  if (!lock && lock.error().code == ErrorCode::kRefused) {
    std::string pid = "unknown";
    std::ifstream(file) >> pid;
    return Fail(ErrorCode::kRefused,
                fmt::format("the folder {} is in use by the process {}; end that "
                            "process, or choose another folder with --folder",
                            folder.string(), pid),
                folder.string());
  }
  if (!lock) {
    return Fail(
        ErrorCode::kIo,
        fmt::format(
            "cannot write to the folder {}: {}; choose another folder with --folder",
            folder.string(), lock.error().message),
        folder.string());
  }
  if (const auto written = lock->WriteText(std::to_string(getpid()) + "\n"); !written) {
    return Fail(
        ErrorCode::kIo,
        fmt::format(
            "{}: {}; free space on the disk, or choose another folder with --folder",
            file.string(), written.error().message),
        folder.string());
  }
  return FolderLock(std::move(*lock));
}

}  // namespace intaglio::client
