#pragma once

// What a command has made on the disk goes again when the command is refused.

#include <filesystem>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::client {

class FreshPaths {
 public:
  /// Before they are made: of each path that is not there, it or the uppermost folder
  /// that has to be made for it is removed at the end, with everything in it.
  explicit FreshPaths(const std::vector<std::filesystem::path>& paths);
  ~FreshPaths();
  FreshPaths(const FreshPaths&) = delete;
  FreshPaths& operator=(const FreshPaths&) = delete;
  /// Nothing is removed.
  void Keep() { missing_.clear(); }

 private:
  std::vector<std::filesystem::path> missing_;
};

/// kIo: the disk of the folder, which need not be there yet, has less than 2 MB of room.
Status CheckRoom(const std::filesystem::path& folder);

}  // namespace intaglio::client
