#pragma once

// A zip archive held in memory (PKWARE APPNOTE 6.3, with the sizes of ZIP64): its files
// by their names, stored or deflated. Only the directory is trusted, and only within
// bounds.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "engrave/core/result.h"

namespace intaglio::io {

class ZipArchive {
 public:
  struct File {
    std::string name;        ///< as Read takes it, in lower case
    std::uint64_t size = 0;  ///< as the directory declares it, bytes
  };

  /// Nothing when it is no whole archive. The bytes must outlive it.
  static std::optional<ZipArchive> Open(std::string_view bytes);

  /// The sum of the sizes that the directory declares, bytes.
  std::uint64_t unpacked_size() const { return unpacked_size_; }
  /// By their names.
  std::vector<File> Files() const;
  /// A name without a slash at its beginning, in any case.
  bool Contains(std::string_view name) const;
  /// kNotFound; kUnsupported: encrypted or packed in another way; kUnreadable: it is not
  /// what its size and its checksum say.
  Result<std::string> Read(std::string_view name) const;

 private:
  struct Entry {
    std::uint64_t packed_size = 0, size = 0, header = 0;
    std::uint32_t crc = 0;
    std::uint16_t method = 0, flags = 0;
  };

  explicit ZipArchive(std::string_view bytes) : bytes_(bytes) {}
  bool ReadDirectory();
  static bool TakeZip64(std::string_view extra, Entry& entry);

  std::string_view bytes_;
  std::map<std::string, Entry> entries_;
  std::uint64_t unpacked_size_ = 0;
};

}  // namespace intaglio::io
