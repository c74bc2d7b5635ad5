#pragma once

// A recording held in memory.

#include <fmt/format.h>

#include <cstring>
#include <memory>
#include <string>
#include <utility>

#include "services/platform/recording/byte_source.h"

namespace intaglio::recording {

class MemorySource final : public ByteSource {
 public:
  MemorySource(std::string name, Bytes bytes)
      : name_(std::move(name)), bytes_(std::move(bytes)) {}
  std::uint64_t size() const override { return bytes_.size(); }
  const std::string& name() const override { return name_; }
  Status Read(std::uint64_t offset, std::span<std::byte> out) const override {
    if (offset > bytes_.size() || bytes_.size() - offset < out.size()) {
      return Fail(ErrorCode::kIo, fmt::format("{}: nothing at byte {}", name_, offset));
    }
    if (!out.empty()) std::memcpy(out.data(), bytes_.data() + offset, out.size());
    return {};
  }

 private:
  std::string name_;
  Bytes bytes_;
};

inline std::unique_ptr<ByteSource> MakeMemorySource(std::string name, Bytes bytes) {
  return std::make_unique<MemorySource>(std::move(name), std::move(bytes));
}

}  // namespace intaglio::recording
