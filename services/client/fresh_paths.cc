#include "services/client/fresh_paths.h"

#include <fmt/format.h>

namespace intaglio::client {
namespace {

namespace fs = std::filesystem;

// A new queue, the files of the services and their logs.
constexpr std::uintmax_t kMinRoomBytes = 2'000'000;

bool IsThere(const fs::path& path) {
  std::error_code error;
  return fs::exists(fs::symlink_status(path, error));
}

}  // namespace

FreshPaths::FreshPaths(const std::vector<fs::path>& paths) {
  for (const fs::path& path : paths) {
    fs::path missing;
    for (fs::path at = fs::absolute(path).lexically_normal();
         !at.empty() && !IsThere(at) && at != at.root_path(); at = at.parent_path()) {
      missing = at;
    }
    if (!missing.empty()) missing_.push_back(missing);
  }
}

FreshPaths::~FreshPaths() {
  std::error_code ignored;
  for (const fs::path& path : missing_) fs::remove_all(path, ignored);
}

Status CheckRoom(const fs::path& folder) {
  std::error_code error;
  fs::path there = fs::absolute(folder).lexically_normal();
  while (!IsThere(there) && there != there.root_path()) there = there.parent_path();
  const fs::space_info space = fs::space(there, error);
  // A file system without a size, like /proc, is not a full disk: the folder is tried.
  if (error || space.capacity == 0 || space.available >= kMinRoomBytes) return {};
  return Fail(ErrorCode::kIo,
              fmt::format("the disk of the folder {} is full, {:.1f} MB are free: make "
                          "room, or choose another folder with --folder",
                          folder.string(), static_cast<double>(space.available) / 1e6),
              folder.string());
}

}  // namespace intaglio::client
