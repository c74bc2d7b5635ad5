#pragma once

// Bytes that are read at any place.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "engrave/core/result.h"
#include "services/platform/recording/mcap_fields.h"

namespace intaglio::recording {

/// Read may be called from several threads at once.
class ByteSource {
 public:
  virtual ~ByteSource() = default;
  /// As it was when the source was opened; a file that is being written grows on.
  virtual std::uint64_t size() const = 0;
  /// Fills `out` from `offset`; kIo when that is not possible.
  virtual Status Read(std::uint64_t offset, std::span<std::byte> out) const = 0;
  /// For error messages.
  virtual const std::string& name() const = 0;
};

/// kNotFound or kIo.
Result<std::unique_ptr<ByteSource>> OpenFileSource(const std::filesystem::path& file);

}  // namespace intaglio::recording
