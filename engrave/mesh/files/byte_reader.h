#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>

namespace intaglio::mesh {

/// The bytes of a model one after another, so that a large file is never held as a whole.
class ByteReader {
 public:
  virtual ~ByteReader() = default;
  /// Fills the buffer as far as there are bytes; returns the number of bytes read.
  virtual std::size_t Read(std::span<char> buffer) = 0;
};

class MemoryReader final : public ByteReader {
 public:
  explicit MemoryReader(std::string_view rest) : rest_(rest) {}
  std::size_t Read(std::span<char> buffer) override {
    const std::size_t count = rest_.copy(buffer.data(), buffer.size());
    rest_.remove_prefix(count);
    return count;
  }

 private:
  std::string_view rest_;
};

}  // namespace intaglio::mesh
