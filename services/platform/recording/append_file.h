#pragma once

// A file that only grows, by whole records: a record that the disk takes only in part is
// cut off again.

#include <cstdint>
#include <filesystem>
#include <initializer_list>

#include "engrave/core/result.h"
#include "services/platform/recording/mcap_fields.h"

namespace intaglio::recording {

class AppendFile {
 public:
  /// What a file of that name is: written over, or left alone (kRefused).
  enum class Existing { kReplace, kKeep };
  /// Makes the file, its name on the disk. kIo with path and remedy.
  static Result<AppendFile> Create(const std::filesystem::path& path,
                                   Existing existing = Existing::kReplace);
  AppendFile(AppendFile&& other) noexcept;
  AppendFile& operator=(AppendFile&& other) noexcept;
  ~AppendFile();

  /// The pieces one behind the other, or nothing of them. kIo.
  Status Append(std::initializer_list<ByteView> pieces);
  /// Until everything is on the disk.
  Status Sync();

  std::uint64_t size() const { return size_; }
  std::uint64_t synced_size() const { return synced_size_; }  ///< on the disk for certain
  std::uint32_t crc() const { return crc_; }  ///< CRC-32 of all bytes so far
  const std::filesystem::path& path() const { return path_; }

 private:
  AppendFile(int descriptor, std::filesystem::path path);
  int descriptor_ = -1;
  std::filesystem::path path_;
  std::uint64_t size_ = 0, synced_size_ = 0;
  std::uint32_t crc_ = 0;
};

}  // namespace intaglio::recording
